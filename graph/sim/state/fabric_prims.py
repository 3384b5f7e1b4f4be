"""Prims and attributes of Fabric, one by one, under the names that usdrt uses. Reads are strict: what would be out of
date raises instead of being answered.

Matrices are those of USD here: row vectors, the translation in the last row, stage units.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError

if TYPE_CHECKING:
    from .prim_poses import PrimPoses

WORLD, LOCAL = "omni:fabric:worldMatrix", "omni:fabric:localMatrix"


class StaleReadError(RunError):
    """A value in Fabric is older than something that it depends on."""


class FabricAttribute:
    """One attribute of a prim in Fabric. False where there is no such attribute."""

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
        """Whether `get` has something to give."""
        if self._name in (WORLD, LOCAL):
            return self._fabric.has_place(self._path)
        return self._fabric.get_raw(self._path, self._name) is not None

    def get(self) -> Any:
        """The value of now. The world and local matrices are `Gf.Matrix4d`.

        Raises StaleReadError where it is out of date: of a prim below one that a user has placed in Fabric, and of the
        stage's xformOps where physics or a user has moved the prim in Fabric. Raises RunError where there is no value.
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
        """Set the value in Fabric; the stage is not touched. A matrix moves the prim, and none below it.

        Matrices: `Gf.Matrix4d` or (4, 4) row vectors. Raises RunError for what is not a matrix.
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
        """Rises with every change that this value may have seen."""
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
    """One prim in Fabric. False where neither the stage nor Fabric has it."""

    def __init__(self, fabric: PrimPoses, path: str) -> None:
        self._fabric, self._path = fabric, path

    def __bool__(self) -> bool:
        return self._fabric.has_prim(self._path)

    def is_valid(self) -> bool:
        """Whether there is such a prim."""
        return bool(self)

    def get_path(self) -> str:
        """The prim's path."""
        return self._path

    def has_attribute(self, name: str) -> bool:
        """Whether the prim has an attribute of that name."""
        return bool(self.get_attribute(name))

    def get_attribute(self, name: str) -> FabricAttribute:
        """An attribute, whether it is there or not."""
        return FabricAttribute(self._fabric, self._path, name)

    def create_attribute(self, name: str, type_name: Any = None, custom: bool = True) -> FabricAttribute:
        """An attribute to be set; Fabric takes values of any type, so `type_name` and `custom` change nothing."""
        return FabricAttribute(self._fabric, self._path, name)

    IsValid, GetPath, HasAttribute, GetAttribute, CreateAttribute = (
        is_valid,
        get_path,
        has_attribute,
        get_attribute,
        create_attribute,
    )


def stale_message(cause: str) -> str:
    """What is wrong with the matrix of a prim below `cause`, and what to do."""
    return (
        f"{cause}, above it, was placed in Fabric after it, which moves that prim alone; this one keeps its old place. "
        "Place it too, or call app.fabric.update_world_xforms()"
    )
