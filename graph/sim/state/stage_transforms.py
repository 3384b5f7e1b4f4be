"""The stage as the world (`fidelity.fabric: off`): physics writes to it, and reads give its content."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.scene.stage import Warn, ignore_warning
from graph.sim.transforms import Floats

from .prim_poses import PrimPoses

if TYPE_CHECKING:
    from collections.abc import Iterator

    from graph.sim.physics.protocol import PhysicsEngine


class StageTransforms(PrimPoses):
    """Poses by the stage's own rules: a placed prim is written to the stage, and its descendants move with it.

    Every physics step writes the local transforms of the bodies that moved. Their poses are also kept in the precision
    of physics until another write changes them, so that sensors see the same bits as with Fabric on; all other prims
    are composed from the stage whenever they are read.
    """

    enabled = False
    every_step = True

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        super().__init__(stage, warn)
        self._writer: Any = None

    def bind(self, physics: PhysicsEngine | None) -> None:
        """Follows the bodies of a world, and writes them from now on.

        Raises UserError for one that cannot be written.
        """
        super().bind(physics)
        self._attach()

    def unbind(self) -> None:
        """Returns to the stage."""
        self._writer = None
        super().unbind()

    def stepped(self, count: int = 1) -> None:
        """Physics has stepped: writes what moved."""
        super().stepped(count)
        self._write()

    def touched(self) -> None:
        """A user has written to physics between its steps: writes what moved."""
        super().touched()
        self._write()

    def stage_moved(self, path: str) -> None:
        """The stage has a new transform for a prim; while playing, `settle` follows."""
        if self._writer is not None and self.promote is None:
            self._attach()

    def set_world_matrix(self, path: str, matrix: Floats) -> None:
        """Places a prim, and its descendants with it, by writing its local transform to the stage.

        A free or kinematic body is moved in physics too, without its scale. Stop restores the stage.
        """
        matrix = self.checked(path, matrix)
        prim = self.stage.GetPrimAtPath(path) if path.startswith("/") else None
        if not prim:
            raise RunError(f"{path}: no such prim on the stage")
        if path in self._layout or (self.body_of(path) is None and self.promote is not None and self.promote(path)):
            self.place_body(path, matrix)
        else:
            self._author(prim, matrix)

    def settle(self) -> None:
        """Takes over prims that the stage has moved; the bodies below are written again relative to them."""
        if self._writer is not None:
            self._attach()

    def restore(self, poses: Mapping[str, Floats]) -> None:
        """Static prims that became bodies, and kinematic bodies, go to `poses` [m] on the stage too."""
        super().restore(poses)
        kinematic = self._physics.kinematic if self._physics is not None else frozenset()
        for path in (*self._frames, *kinematic):
            world = self.capture().matrices[self._layout[path]].copy()
            world[:3, 3] /= self.meters_per_unit
            with self._quietly():
                self._author(self.stage.GetPrimAtPath(path), world @ self._residuals[path])
        self._attach()

    def place_body(self, path: str, matrix: Floats) -> None:
        """As in Fabric; the stage is written too."""
        super().place_body(path, matrix)
        if self._physics is not None and path in self._physics.body_paths and path not in self._physics.kinematic:
            self._write()
        else:
            world = self.capture().matrices[self._layout[path]].copy()
            world[:3, 3] /= self.meters_per_unit
            with self._quietly():
                self._author(self.stage.GetPrimAtPath(path), world @ self._residuals[path])
            self._attach()
        self._bindings.clear()
        if self.carried is not None:
            self.carried(path)

    def update_world_xforms(self) -> None:
        """Does nothing: the stage moves descendants with their parents."""

    @contextmanager
    def _quietly(self) -> Iterator[None]:
        before, self.muted = self.muted, True
        try:
            yield
        finally:
            self.muted = before

    def _attach(self) -> None:
        from .body_writer import BodyWriter

        physics = self._physics
        paths = [path for path in physics.body_paths if path not in physics.kinematic] if physics else []
        self._writer = BodyWriter(self.stage, self.meters_per_unit)
        with self._quietly():
            self._writer.attach(paths, [self._layout[path] for path in paths], self._world(), self._residuals)

    def _write(self) -> None:
        if self._writer is not None and self._writer.bodies:
            with self._quietly():
                self._writer.write(self._world())

    def _world(self) -> Floats:
        """(B, 4, 4) rigid poses of all bodies, stage units."""
        out = self.capture().matrices[:-1]
        if self.meters_per_unit != 1:
            out = out.copy()
            out[:, :3, 3] /= self.meters_per_unit
        return out

    def _author(self, prim: Any, world: Floats) -> None:
        """Writes the local transform that puts a prim at `world`."""
        from graph.sim.usd import EARLIEST, UsdGeom

        from .body_writer import author_local

        schema = UsdGeom.Xformable(prim)
        if not schema:
            raise RunError(f"{prim.GetPath()}: a {prim.GetTypeName() or 'prim without type'} has no transform")
        parent, above = prim.GetParent(), np.eye(4)
        if not schema.GetResetXformStack() and not parent.IsPseudoRoot():
            path = parent.GetPath().pathString
            if self.body_of(path) is not None:
                above = self.world_matrix(path)
            else:
                above = transforms.from_usd(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(parent))
            world = np.linalg.inv(above) @ world
        author_local(self.stage, prim, above, world)
