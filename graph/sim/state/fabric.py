"""Fabric: where every prim is now, flattened, read by path and by many at once.

Physics moves bodies; everything below a moving body follows at the offset that the stage gives it. Nothing is computed
when physics steps: poses are composed when somebody reads them.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.scene.stage import Warn, ignore_warning
from graph.sim.transforms import Floats

from .fabric_poses import NOTHING, FabricPoses
from .fabric_prims import FabricPrim


class Fabric(FabricPoses):
    """World transforms and attributes by path. Matrices are (4, 4), column vectors, stage units.

    What users write here to one prim moves that prim only: what is below keeps its place, and reading it afterwards
    gives the warning `fabric-stale-transform`, once per prim (`get_prim_at_path` is strict and raises instead).
    """

    enabled = True
    """Whether this is Fabric; False where the stage itself is the world (`fidelity.fabric: off`)."""

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        super().__init__(stage, warn)
        self.muted = False
        """Whether what is written to the stage now comes from physics."""
        self.follow_stage = True
        """Whether edits of the stage are heard of."""
        self._on_change = _forgetter(self)
        self._listener = _listen(self._on_change, stage)

    def close(self) -> None:
        """Stop listening to the stage."""
        self._listener.Revoke()

    # -- prims, as usdrt spells them ---------------------------------------------------------------------------------

    def get_prim_at_path(self, path: str) -> FabricPrim:
        """The prim at a path, with strict reads: a value that would be out of date raises. False if there is none."""
        return FabricPrim(self, str(path))

    GetPrimAtPath = get_prim_at_path

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

    def checked(self, path: str, matrix: Any) -> Floats:
        """A world matrix that a user gives. Raises RunError for one that is none."""
        out = np.array(matrix, dtype=np.float64)
        if out.shape != (4, 4) or not transforms.usable(out):
            raise RunError(f"{path}: a world matrix must be (4, 4), finite and not flat.")
        return out

    def place_body(self, path: str, matrix: Floats) -> None:
        """Put a body, or a still prim that has become a frame, somewhere, without its scale; what it carries goes too.

        Raises RunError for a body held by a joint.
        """
        pose = transforms.rigid_part(matrix)
        pose[:3, 3] *= self.meters_per_unit
        if path in self._frames:
            self._frames[path] = pose
        elif self._physics is not None:
            self._physics.set_poses((path,), pose[None])
        self._latest = None
        self.stamp += 1

    def take_from_stage(self, path: str, matrix: Floats) -> None:
        """The stage says where a body is: `place_body`, the stage left alone."""
        Fabric.place_body(self, path, self.checked(path, matrix))

    def settle(self) -> None:
        """All that the stage has moved was taken from it."""

    def restore(self, poses: Mapping[str, Floats]) -> None:
        """Forget what users have placed; still prims that became bodies, and kinematic bodies, go to `poses` [m]."""
        self._written, self._offsets, self._stamps = NOTHING, {}, {}
        self._frames.update({path: poses[path] for path in self._frames if path in poses})
        self.forget()

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

    def _finish_written(self, paths: Sequence[str], written: Mapping[str, Floats], out: Floats) -> None:
        for number, path in enumerate(paths):
            if path in written:
                out[number] = written[path]
            cause = self.stale_because_of(path)
            if cause is not None:
                self.warn("fabric-stale-transform", path, stale_message(cause))

    def outdated_on_stage(self, path: str) -> str | None:
        """Why the transform that the stage holds of a prim is not where it is now; None if it is."""
        if path in self._stamps:
            return "a user has placed it in Fabric; the stage keeps its old xformOps. Read omni:fabric:worldMatrix."
        physics = self._physics
        if self.steps and physics is not None and path in physics.body_paths and path not in physics.kinematic:
            return (
                "physics moves it in Fabric; the stage keeps the xformOps of play. Read omni:fabric:worldMatrix, or "
                "switch Fabric off (fidelity fabric: off)."
            )
        return None


def stale_message(cause: str) -> str:
    """What is wrong with the matrix of a prim below `cause`, and what to do."""
    return (
        f"{cause}, above it, was placed in Fabric after it, which moves that prim alone; this one keeps its old place. "
        "Place it too, or call app.fabric.update_world_xforms()."
    )


def _forgetter(fabric: Fabric) -> Callable[[Any, Any], None]:
    """What makes a Fabric forget what it has read when prims or transforms of its stage change."""
    weak = weakref.ref(fabric)

    def changed(notice: Any, sender: Any) -> None:
        alive = weak()
        if alive is None or alive.muted or not alive.follow_stage:
            return
        moved = [path.GetPrimPath() for path in notice.GetChangedInfoOnlyPaths() if "xformOp" in path.name]
        if moved or notice.GetResyncedPaths():
            alive.forget()
            for path in dict.fromkeys(moved):
                alive.stage_moved(path.pathString)

    return changed


def _listen(callback: Callable[[Any, Any], None], stage: Any) -> Any:
    """Have USD call back on changes; it holds the callback weakly, so its owner must keep it."""
    from graph.sim.usd import Tf, Usd

    return Tf.Notice.Register(Usd.Notice.ObjectsChanged, callback, stage)
