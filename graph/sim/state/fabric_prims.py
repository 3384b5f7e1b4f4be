"""Prims and attributes of Fabric, one by one, under usdrt's names. Reads are strict: an out-of-date value raises.

Matrices are as in USD: row vectors, the translation in the last row, stage units.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError

if TYPE_CHECKING:
    from .prim_poses import PrimPoses

WORLD, LOCAL = "omni:fabric:worldMatrix", "omni:fabric:localMatrix"


class StaleReadError(RunError):
    """A value in Fabric is older than a value on which it depends."""


class FabricAttribute:
    """One attribute of a prim in Fabric. Falsy if it does not exist."""

    def __init__(self, fabric: PrimPoses, path: str, name: str) -> None:
        self._fabric, self._path, self._name = fabric, path, name

    def __bool__(self) -> bool:
        return self.has_value() or self._fabric.stage_has(self._path, self._name)

    def get_name(self) -> str:
        """The attribute's name."""
        return self._name

    def get_path(self) -> str:
        """The path of its prim, a dot, and its name."""
        return f"{self._path}.{self._name}"

    def has_value(self) -> bool:
        """Whether `get` has a value."""
        if self._name in (WORLD, LOCAL):
            return self._fabric.has_place(self._path)
        return self._fabric.get_raw(self._path, self._name) is not None

    def get(self) -> Any:
        """The present value. The world and local matrices are `Gf.Matrix4d`.

        Raises StaleReadError for an out-of-date value: of a prim below one that a user has placed in Fabric, and of the
        stage's xformOps if physics or a user has moved the prim in Fabric. Raises RunError without a value.
        """
        if self._name in (WORLD, LOCAL):
            return self._matrix()
        value = self._fabric.get_raw(self._path, self._name)
        if value is None:
            raise RunError(f"{self.get_path()}: there is no such attribute in Fabric or on the stage, or no value")
        if self._name.startswith("xformOp") and self._fabric.change_stamp(self._path, self._name) < 0:
            reason = self._fabric.outdated_on_stage(self._path)
            if reason is not None:
                raise StaleReadError(f"{self.get_path()}: {reason}")
        return value

    def set(self, value: Any) -> None:
        """Sets the value in Fabric; the stage is not changed. A matrix moves only this prim.

        Matrices: `Gf.Matrix4d` or (4, 4) row vectors. Raises RunError for an invalid matrix.
        """
        if self._name not in (WORLD, LOCAL):
            self._fabric.set(self._path, self._name, value)
            return
        matrix = np.array(value, dtype=np.float64)
        if matrix.shape != (4, 4):
            raise RunError(f"{self.get_path()}: a matrix is (4, 4), not {matrix.shape}")
        world = matrix.T
        if self._name == LOCAL:
            world = self._parent() @ world
        self._fabric.set_world_matrix(self._path, world)

    def get_change_stamp(self) -> int:
        """A number that grows with every change that may affect this value."""
        if self._name in (WORLD, LOCAL):
            return self._fabric.stamp
        return self._fabric.change_stamp(self._path, self._name)

    def _matrix(self) -> Any:
        from graph.sim.usd import Gf

        world = self._world(self._path)
        if self._name == LOCAL:
            world = np.linalg.inv(self._parent()) @ world
        return Gf.Matrix4d(*world.T.ravel().tolist())

    def _world(self, path: str) -> Any:
        if not self._fabric.has_place(path):
            raise RunError(f"{path}: it has no transform; there is no such prim on the stage, or it has no place")
        cause = self._fabric.stale_because_of(path)
        if cause is not None:
            raise StaleReadError(f"{self.get_path()}: {stale_message(cause)}")
        return self._fabric.world_matrix(path)

    def _parent(self) -> Any:
        above = self._path.rpartition("/")[0]
        if not above or self._fabric.resets(self._path):
            return np.eye(4)
        return self._world(above)

    GetName, GetPath, HasValue, Get, Set = get_name, get_path, has_value, get, set


class FabricPrim:
    """One prim in Fabric. Falsy if neither the stage nor Fabric has it."""

    def __init__(self, fabric: PrimPoses, path: str) -> None:
        self._fabric, self._path = fabric, path

    def __bool__(self) -> bool:
        return self._fabric.has_prim(self._path)

    def is_valid(self) -> bool:
        """Whether the prim exists."""
        return bool(self)

    def get_path(self) -> str:
        """The prim's path."""
        return self._path

    def has_attribute(self, name: str) -> bool:
        """Whether the prim has an attribute of that name."""
        return bool(self.get_attribute(name))

    def get_attribute(self, name: str) -> FabricAttribute:
        """An attribute, existing or not."""
        return FabricAttribute(self._fabric, self._path, name)

    def create_attribute(self, name: str, type_name: Any = None, custom: bool = True) -> FabricAttribute:
        """An attribute to be set; Fabric accepts values of any type, so `type_name` and `custom` have no effect."""
        return FabricAttribute(self._fabric, self._path, name)

    IsValid, GetPath, HasAttribute = is_valid, get_path, has_attribute
    GetAttribute, CreateAttribute = get_attribute, create_attribute


def stale_message(cause: str) -> str:
    """The message about an out-of-date matrix of a prim below `cause`, with what to do."""
    return (
        f"{cause}, above it, was placed in Fabric after it, which moves that prim alone; this one keeps its old place. "
        "Place it too, or call app.fabric.update_world_xforms()"
    )
