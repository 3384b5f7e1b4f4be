"""Fabric: the present transforms of all prims, flattened, read one by one or many at once.

Physics moves bodies; everything below a moving body follows at the offset on the stage. Physics steps compute nothing
here: poses are composed when they are read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from graph.sim import transforms
from graph.sim.scene.stage import Warn, ignore_warning
from graph.sim.transforms import Floats

from .fabric_prims import stale_message
from .prim_poses import NOTHING, PrimPoses


class Fabric(PrimPoses):
    """Poses and attributes beside the stage; the stage keeps its state of play.

    A value that users write here to one prim moves only that prim: its descendants keep their poses, and reading them
    afterwards gives the warning `fabric-stale-transform`, once per prim (`get_prim_at_path` is strict and raises
    instead).
    """

    enabled = True
    every_step = False

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        super().__init__(stage, warn)
        self._written: Mapping[str, Floats] = NOTHING
        self._stamps: dict[str, int] = {}
        self._offsets: dict[str, Floats] = {}

    def unbind(self) -> None:
        """Returns to the stage."""
        self._offsets, self._written, self._stamps = {}, NOTHING, {}
        super().unbind()

    def add_frame(self, path: str) -> None:
        """From now on a static prim counts as a kinematic body."""
        super().add_frame(path)
        self._written = MappingProxyType({each: m for each, m in self._written.items() if each != path})

    # -- placing -----------------------------------------------------------------------------------------------------

    def set_world_matrix(self, path: str, matrix: Floats) -> None:
        """Places one prim without its descendants.

        A free or kinematic body is moved in physics too, without its scale. A prim that follows a body follows it from
        its new pose on. Placed poses are dropped at a stop.
        """
        matrix = self.checked(path, matrix)
        bound = self._bind((path,))
        if path in self._layout or (bound.bodies[0] < 0 and self.promote is not None and self.promote(path)):
            self.place_body(path, matrix)
        elif bound.bodies[0] >= 0:
            body = self.capture().matrices[bound.bodies[0]].copy()
            body[:3, 3] /= self.meters_per_unit
            self._offsets[path] = transforms.inverse_rigid(body) @ matrix
            self._bindings.clear()
        else:
            self._written = MappingProxyType({**self._written, path: matrix})
        self._latest = None
        self.stamp += 1
        self._stamps[path] = self.stamp

    def restore(self, poses: Mapping[str, Floats]) -> None:
        """Drops the poses that users have placed; static prims that became bodies, and kinematic bodies, go to
        `poses` [m].
        """
        self._written, self._offsets, self._stamps = NOTHING, {}, {}
        super().restore(poses)

    # -- staleness ---------------------------------------------------------------------------------------------------

    def stale_because_of(self, path: str) -> str | None:
        """The ancestor that a user placed after this prim, so that the prim's own matrix is out of date, or None."""
        own, above = self._stamps.get(path, -1), path
        while above and not self._carries(above):
            above = above.rpartition("/")[0]
            if self._stamps.get(above, -1) > own and not self._carries(above):
                return above
        return None

    def update_world_xforms(self) -> None:
        """Moves the descendants of placed prims with them, by their local transforms; then nothing is stale."""
        from graph.sim.usd import EARLIEST, Usd, UsdGeom

        xforms = UsdGeom.XformCache(EARLIEST)
        stale: dict[str, str] = {}
        for path in sorted(self._stamps):
            prim = self.stage.GetPrimAtPath(path)
            walk: Any = iter(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()) if prim else ())
            for each in walk:
                below = each.GetPath().pathString
                if self._carries(below) or (below != path and self.resets(below)):
                    walk.PruneChildren()
                elif (cause := self.stale_because_of(below)) is not None:
                    stale[below] = cause
        for path in sorted(stale):  # parents first
            above = path.rpartition("/")[0]
            while above != stale[path] and above not in stale:
                above = above.rpartition("/")[0]
            prim, reference = (self.stage.GetPrimAtPath(each) for each in (path, above))
            relative, _ = xforms.ComputeRelativeTransform(prim, reference)
            self.set_world_matrix(path, self.world_matrix(above) @ transforms.from_usd(relative))

    def settle(self) -> None:
        """Marks all moves by the stage as handled."""

    def stage_moved(self, path: str) -> None:
        """The stage has a new transform for a prim: it counts from now on, for its descendants too."""
        prefix = f"{path.rstrip('/')}/"
        gone = [each for each in self._stamps if each == path or each.startswith(prefix)]
        for each in gone:
            del self._stamps[each]
            self._offsets.pop(each, None)
        if gone:
            self._written = MappingProxyType({each: m for each, m in self._written.items() if each not in gone})
            self.forget()

    def _placed(self) -> Mapping[str, Floats]:
        return self._written

    def _offset(self, path: str) -> Floats | None:
        return self._offsets.get(path)

    def _finished(self, paths: Sequence[str], written: Mapping[str, Floats], out: Floats) -> Floats:
        if not self._stamps:
            return out
        for number, path in enumerate(paths):
            if path in written:
                out[number] = written[path]
            cause = self.stale_because_of(path)
            if cause is not None:
                self.warn("fabric-stale-transform", path, stale_message(cause))
        return out

    def outdated_on_stage(self, path: str) -> str | None:
        """Why the stage's transform of a prim is not its present one, or None."""
        if path in self._stamps:
            return "a user has placed it in Fabric; the stage keeps its old xformOps. Read omni:fabric:worldMatrix"
        physics = self._physics
        if self.steps and physics is not None and path in physics.body_paths and path not in physics.kinematic:
            return (
                "physics moves it in Fabric; the stage keeps the xformOps of play. Read omni:fabric:worldMatrix, or "
                "switch Fabric off (fidelity fabric: off)"
            )
        return None
