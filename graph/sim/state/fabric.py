"""Fabric: where every prim is now, flattened, read by path and by many at once.

Physics moves bodies; everything below a moving body follows at the offset that the stage gives it. Nothing is computed
when physics steps: poses are composed when somebody reads them.
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
    """Poses and attributes beside the stage, which keeps what it held at play.

    What users write here to one prim moves that prim only: what is below keeps its place, and reading it afterwards
    gives the warning `fabric-stale-transform`, once per prim (`get_prim_at_path` is strict and raises instead).
    """

    enabled = True
    every_step = False

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        super().__init__(stage, warn)
        self._written: Mapping[str, Floats] = NOTHING
        self._stamps: dict[str, int] = {}
        self._offsets: dict[str, Floats] = {}

    def unbind(self) -> None:
        """Return to the stage."""
        self._offsets, self._written, self._stamps = {}, NOTHING, {}
        super().unbind()

    def add_frame(self, path: str) -> None:
        """From now on a still prim counts as a body that only users move."""
        super().add_frame(path)
        self._written = MappingProxyType({each: m for each, m in self._written.items() if each != path})

    # -- placing -----------------------------------------------------------------------------------------------------

    def set_world_matrix(self, path: str, matrix: Floats) -> None:
        """Place one prim, and none below it.

        A free or kinematic body is moved in physics too, without its scale. A prim that follows a body follows it from
        its new place on. What was placed is forgotten on stop.
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
        """Forget what users have placed; still prims that became bodies, and kinematic bodies, go to `poses` [m]."""
        self._written, self._offsets, self._stamps = NOTHING, {}, {}
        super().restore(poses)

    # -- staleness ---------------------------------------------------------------------------------------------------

    def stale_because_of(self, path: str) -> str | None:
        """The prim above that was placed by a user after this one, so that its own matrix is out of date; else None."""
        own, above = self._stamps.get(path, -1), path
        while above and not self._carries(above):
            above = above.rpartition("/")[0]
            if self._stamps.get(above, -1) > own and not self._carries(above):
                return above
        return None

    def update_world_xforms(self) -> None:
        """Take what is below prims that users have placed along, at its local transforms: nothing is stale then."""
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
        """All that the stage has moved was taken from it."""

    def stage_moved(self, path: str) -> None:
        """The stage has a new transform for a prim: it counts from now on, for what is below too."""
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
        """Why the transform that the stage holds of a prim is not where it is now; None if it is."""
        if path in self._stamps:
            return "a user has placed it in Fabric; the stage keeps its old xformOps. Read omni:fabric:worldMatrix"
        physics = self._physics
        if self.steps and physics is not None and path in physics.body_paths and path not in physics.kinematic:
            return (
                "physics moves it in Fabric; the stage keeps the xformOps of play. Read omni:fabric:worldMatrix, or "
                "switch Fabric off (fidelity fabric: off)"
            )
        return None
