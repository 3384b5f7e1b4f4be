"""Fabric: where every prim is now, flattened, read by path and by many at once.

Physics moves bodies; everything below a moving body follows at the offset that the stage gives it. Nothing is computed
when physics steps: poses are composed when somebody reads them.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from graph.errors import RunError

from . import transforms
from .fabric_prims import FabricPrim
from .poses import Poses
from .stage import Warn, ignore_warning, meters_per_unit
from .transforms import Floats

if TYPE_CHECKING:
    from .physics.engine import Physics

_NOTHING: Mapping[str, Floats] = MappingProxyType({})


class Live(Protocol):
    """An attribute that the physics has: what it is now at a path (None: it has none there), and what to do with it."""

    def read(self, path: str) -> Any:
        """The value of now."""

    def write(self, path: str, value: Any) -> None:
        """Take a value that somebody sets."""


@dataclass(frozen=True)
class _Binding:
    """Which body each of some prims follows (-1: none), by row and path, and its matrix in that body's rigid frame."""

    bodies: NDArray[np.intp]
    names: tuple[str, ...]
    offsets: Floats


class Fabric:
    """World transforms and attributes by path. Matrices are (4, 4), column vectors, stage units.

    What users write here to one prim moves that prim only: what is below keeps its place, and reading it afterwards
    gives the warning `fabric-stale-transform`, once per prim (`get_prim_at_path` is strict and raises instead).
    """

    enabled = True
    """Whether this is Fabric; False where the stage itself is the world (`fidelity.fabric: off`)."""

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        self.stage = stage
        self.warn = warn
        self.meters_per_unit = meters_per_unit(stage)
        self.stamp = 0
        """Changes whenever any pose may have changed."""
        self.steps = 0
        """Physics steps since play."""
        self._physics: Physics | None = None
        self._layout: dict[str, int] = {}
        self._frames: dict[str, Floats] = {}
        self._speeds: dict[str, Floats] = {}
        self.promoted: dict[str, bool] = {}
        """Still prims that users have moved while playing, bodies since; whether what is below each goes with it."""
        self.promote: Callable[[str], bool] | None = None
        """Asked before a still prim is placed: makes it one if physics or rays look at it; set while playing."""
        self.muted = False
        """Whether what is written to the stage now comes from physics."""
        self.follow_stage = True
        """Whether edits of the stage are heard of."""
        self._latest: Poses | None = None
        self._bindings: dict[tuple[str, ...], _Binding] = {}
        self._residuals: dict[str, Floats] = {}
        self._written: Mapping[str, Floats] = _NOTHING
        self._stamps: dict[str, int] = {}
        self._offsets: dict[str, Floats] = {}
        self._values: dict[tuple[str, str], tuple[Any, int]] = {}
        self.live: dict[str, Live] = {}
        """Attributes, by name, whose values the physics has and takes; None of one leaves them to Fabric."""
        self._on_change = _forgetter(self)
        self._listener = _listen(self._on_change, stage)

    # -- life --------------------------------------------------------------------------------------------------------

    def bind(self, physics: Physics | None) -> None:
        """Follow the bodies of a world that starts to play, or is another from now on (None: nothing moves)."""
        self._physics = physics
        bodies = physics.body_paths if physics else ()
        self._frames = {path: frame for path, frame in self._frames.items() if path not in bodies}
        self._residuals = {path: self._residual(path) for path in (*bodies, *self._frames)}
        self._number_rows()

    def rebind(self, physics: Physics | None, touched: Sequence[str]) -> None:
        """Follow the bodies of a world that was compiled anew; what is at and below `touched` may have another size."""
        prefixes = tuple(f"{path.rstrip('/')}/" for path in touched)
        self._residuals = {
            path: residual
            for path, residual in self._residuals.items()
            if path not in touched and not path.startswith(prefixes)
        }
        self.bind(physics)

    def restore(self, poses: Mapping[str, Floats]) -> None:
        """Forget what users have placed; still prims that became bodies, and kinematic bodies, go to `poses` [m]."""
        self._written, self._offsets, self._stamps = _NOTHING, {}, {}
        self._frames.update({path: poses[path] for path in self._frames if path in poses})
        self.forget()

    def unbind(self) -> None:
        """Return to the stage: nothing follows a body, and what users wrote to its prims is gone."""
        self._physics = None
        self._layout, self._offsets, self._written, self._stamps = {}, {}, _NOTHING, {}
        self._residuals, self._frames, self._speeds, self.promoted, self.steps = {}, {}, {}, {}, 0
        self._values = {key: entry for key, entry in self._values.items() if not self.stage.GetPrimAtPath(key[0])}
        self.forget()

    def forget(self) -> None:
        """The stage has changed: read it again where it is asked for next."""
        self._bindings.clear()
        self._latest = None
        self.stamp += 1

    def stepped(self) -> None:
        """Physics has stepped: poses read from now on are new ones."""
        self.stamp += 1
        self.steps += 1
        self._latest = None

    def touched(self) -> None:
        """Somebody has written to physics between its steps: poses read from now on are new ones."""
        self.stamp += 1
        self._latest = None

    def close(self) -> None:
        """Stop listening to the stage."""
        self._listener.Revoke()

    # -- poses -------------------------------------------------------------------------------------------------------

    def capture(self) -> Poses:
        """The poses of this moment; free if nothing moved since the last capture."""
        if self._latest is None:
            frames = np.stack(list(self._frames.values())) if self._frames else None
            self._latest = Poses(self.stamp, self._physics, self._layout, self._written, frames, dict(self._speeds))
        return self._latest

    def world_matrices(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 4, 4) prim to world, now or at captured `poses`. Raises RunError for a prim that is not there."""
        poses = poses or self.capture()
        binding = self._bind(tuple(paths))
        if poses.layout is self._layout:
            matrices = poses.matrices[binding.bodies]
        else:
            matrices = self.rigid_matrices(binding.names, poses)
        if self.meters_per_unit != 1:
            matrices[:, :3, 3] /= self.meters_per_unit
        out = matrices @ binding.offsets
        if self._stamps:
            self._finish_written(paths, poses.written, out)
        return out

    def world_matrix(self, path: str, poses: Poses | None = None) -> Floats:
        """(4, 4) prim to world, now or at captured `poses`."""
        out: Floats = self.world_matrices((path,), poses)[0]
        return out

    def rigid_matrices(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 4, 4) poses without scale, in metres: the frames that `geometry.Mesh.vertices` of bodies are given in.

        An empty path is the world.
        """
        poses = poses or self.capture()
        rows = [poses.layout.get(path, -1) for path in paths]
        if -1 not in rows:
            return poses.matrices[np.array(rows, dtype=np.intp)]
        out = np.empty((len(rows), 4, 4))
        for number, (path, row) in enumerate(zip(paths, rows, strict=True)):
            if row >= 0 or not path:
                out[number] = poses.matrices[row]
            elif path in self._layout and poses.layout is not self._layout:  # it was no body then
                out[number] = self.capture().matrices[self._layout[path]]
            else:
                out[number] = transforms.rigid_part(self.world_matrix(path, poses))
                out[number, :3, 3] *= self.meters_per_unit
        return out

    def velocities(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 6) of bodies' origins: linear [m/s], angular [rad/s], world axes; 0 for what is no moving body."""
        return (poses or self.capture()).velocities(paths)

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
            self._physics.set_pose(path, pose)
        self._latest = None
        self.stamp += 1

    # -- still prims that users move ---------------------------------------------------------------------------------

    def set_frames(self, poses: Mapping[str, Floats], velocities: Mapping[str, Floats] | None = None) -> None:
        """Place prims that nothing in physics moves, as bodies of their own: rigid poses (4, 4) [m] by path.

        velocities: (6,) linear [m/s] and angular [rad/s] of their origins, world axes; 0 where not given. Those of
        kinematic bodies of physics may be among them: it does not know how fast they are moved.
        """
        new = [path for path in poses if path not in self._layout]
        self._frames.update(poses)
        self._speeds.update(velocities or {})
        if new:
            self._residuals.update({path: self._residual(path) for path in new})
            self._number_rows()
        self._latest = None
        self.stamp += 1

    def add_frame(self, path: str) -> None:
        """From now on a still prim counts as a body that only users move."""
        self._frames[path] = self.rigid_matrices((path,))[0].copy()
        self._written = MappingProxyType({each: m for each, m in self._written.items() if each != path})
        self._residuals[path] = self._residual(path)
        self._number_rows()

    def is_body(self, path: str) -> bool:
        """Whether a prim is a body that physics or users move."""
        return path in self._layout

    def bodies_below(self, path: str) -> list[str]:
        """Bodies strictly below a prim."""
        prefix = f"{path.rstrip('/')}/"
        return [body for body in self._layout if body.startswith(prefix)]

    def take_from_stage(self, path: str, matrix: Floats) -> None:
        """The stage says where a body is: `place_body`, the stage left alone."""
        Fabric.place_body(self, path, self.checked(path, matrix))

    def settle(self) -> None:
        """All that the stage has moved was taken from it."""

    def _number_rows(self) -> None:
        bodies = self._physics.body_paths if self._physics else ()
        self._layout = {path: number for number, path in enumerate((*bodies, *self._frames))}
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
        from .usd import EARLIEST, Usd, UsdGeom

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

    # -- attributes --------------------------------------------------------------------------------------------------

    def get(self, path: str, attribute: str, default: Any = None) -> Any:
        """An attribute's value in Fabric; where nobody has set one, the stage's; else `default`."""
        value = self.get_raw(path, attribute)
        if attribute.startswith("xformOp") and (path, attribute) not in self._values:
            cause = self.outdated_on_stage(path)
            if cause is not None:
                self.warn("fabric-stale-transform", f"{path}.{attribute}", cause)
        return default if value is None else value

    def get_raw(self, path: str, attribute: str) -> Any:
        """As `get`, without a word where the value is out of date; None where there is none."""
        if attribute in self.live and (value := self.live[attribute].read(path)) is not None:
            return value
        entry = self._values.get((path, attribute))
        if entry is not None:
            return entry[0]
        return self.stage.GetAttributeAtPath(f"{path}.{attribute}").Get() if self.stage_has(path, attribute) else None

    def stage_has(self, path: str, attribute: str) -> bool:
        """Whether the stage has an attribute of a prim."""
        prim = self._prim(path)
        return bool(prim and prim.HasAttribute(attribute))

    def has_prim(self, path: str) -> bool:
        """Whether the stage has a prim, or Fabric a value of it."""
        return bool(self._prim(path)) or any(key[0] == path for key in self._values)

    def has_place(self, path: str) -> bool:
        """Whether the stage has a prim, so that it stands somewhere."""
        return bool(self._prim(path))

    def resets(self, path: str) -> bool:
        """Whether a prim's transform does not count from its parent."""
        from .usd import UsdGeom

        xformable = UsdGeom.Xformable(self._prim(path))
        return bool(xformable and xformable.GetResetXformStack())

    def _prim(self, path: str) -> Any:
        from .usd import Sdf

        valid = path.startswith("/") and path != "/" and Sdf.Path.IsValidPathString(path)
        return self.stage.GetPrimAtPath(path) if valid else None

    def set(self, path: str, attribute: str, value: Any) -> None:
        """Set an attribute in Fabric; the stage is not touched, and the prim need not be on it."""
        if attribute in self.live:
            self.live[attribute].write(path, value)
        previous = self._values.get((path, attribute))
        self._values[path, attribute] = (value, 0 if previous is None else previous[1] + 1)

    def take_values(self, other: Fabric) -> None:
        """Take over all attributes that somebody has set."""
        self._values.update(other._values)

    def change_stamp(self, path: str, attribute: str) -> int:
        """How often an attribute has been set since its first value; -1 if never."""
        entry = self._values.get((path, attribute))
        return -1 if entry is None else entry[1]

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

    # -- prims, as usdrt spells them ---------------------------------------------------------------------------------

    def get_prim_at_path(self, path: str) -> FabricPrim:
        """The prim at a path, with strict reads: a value that would be out of date raises. False if there is none."""
        return FabricPrim(self, str(path))

    GetPrimAtPath = get_prim_at_path

    # -- inside ------------------------------------------------------------------------------------------------------

    def _bind(self, paths: tuple[str, ...]) -> _Binding:
        binding = self._bindings.get(paths)
        if binding is None:
            binding = self._bindings[paths] = self._bound(paths)
        return binding

    def _bound(self, paths: tuple[str, ...]) -> _Binding:
        from .usd import EARLIEST, UsdGeom

        xforms = UsdGeom.XformCache(EARLIEST)
        bodies = np.full(len(paths), -1, dtype=np.intp)
        offsets = np.empty((len(paths), 4, 4))
        names = [""] * len(paths)
        for number, path in enumerate(paths):
            prim = self.stage.GetPrimAtPath(path) if path.startswith("/") else None
            if not prim:
                raise RunError(f"{path}: no such prim on the stage.")
            body = self.body_of(path)
            if body is None:
                offsets[number] = transforms.from_usd(xforms.GetLocalToWorldTransform(prim))
                continue
            bodies[number], names[number] = self._layout[body], body
            if path in self._offsets:
                offsets[number] = self._offsets[path]
                continue
            # Composed from the body downwards: where the body itself stands on the stage leaves no trace in it.
            relative, _ = xforms.ComputeRelativeTransform(prim, self.stage.GetPrimAtPath(body))
            offsets[number] = self._residuals[body] @ transforms.from_usd(relative)
        return _Binding(bodies, tuple(names), offsets)

    def _residual(self, path: str) -> Floats:
        """What a body's transform has beside its pose: scale and shear; kept for as long as there is the body."""
        if path in self._residuals:
            return self._residuals[path]
        from .usd import EARLIEST, UsdGeom

        prim = self.stage.GetPrimAtPath(path)
        world = transforms.from_usd(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(prim))
        out = transforms.inverse_rigid(transforms.rigid_part(world)) @ world
        out[:3, 3] = 0.0
        return out

    def _carries(self, path: str) -> bool:
        """Whether the prim at a path is a body that takes along what is below it."""
        return path in self._layout and self.promoted.get(path, True)

    def body_of(self, path: str) -> str | None:
        """The nearest body, at or above a path, that a prim there moves with."""
        here = path
        while here:
            if here in self._layout and (here == path or self._carries(here)):
                return here
            here = here.rpartition("/")[0]
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
    from .usd import Tf, Usd

    return Tf.Notice.Register(Usd.Notice.ObjectsChanged, callback, stage)
