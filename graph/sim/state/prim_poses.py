"""The present poses of prims: bodies from physics, everything else as the stage composes it around them."""

from __future__ import annotations

import weakref
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.base.suggesting import Suggesting
from graph.sim import transforms
from graph.sim.scene.stage import Warn, ignore_warning
from graph.sim.scene.stage_metadata import meters_per_unit
from graph.sim.transforms import Floats

from .attribute_values import AttributeValues, Live
from .fabric_prims import FabricPrim
from .poses import Binding, Poses, bind, scale_and_shear

if TYPE_CHECKING:
    from graph.sim.physics.protocol import PhysicsEngine


class StageListener:
    """Calls a follower, held weakly, for prims and transforms that change on a stage, until `close`.

    A quaternion that is not of length 1, which USD would take for another rotation, is normalised where it is set.
    """

    def __init__(self, stage: Any, follower: PrimPoses) -> None:
        from graph.sim.scene.stage_faults import ORIENT, make_unit
        from graph.sim.usd import Tf, Usd

        def repair(path: Any, warn: Warn) -> None:
            attribute = stage.GetAttributeAtPath(path)
            if path.name.startswith(ORIENT) and attribute:
                make_unit(attribute, warn)

        self._changed = _teller(weakref.ref(follower), repair)  # USD holds it weakly
        self._notice = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._changed, stage)

    def close(self) -> None:
        """Stops listening."""
        self._notice.Revoke()


def _teller(
    follower: Callable[[], PrimPoses | None], repair: Callable[[Any, Warn], None]
) -> Callable[[Any, Any], None]:
    def changed(notice: Any, sender: Any) -> None:
        alive = follower()
        if alive is None or alive.muted or not alive.follow_stage:
            return
        ops = [path for path in notice.GetChangedInfoOnlyPaths() if "xformOp" in path.name]
        for path in ops:
            repair(path, alive.warn)
        moved = [path.GetPrimPath() for path in ops]
        if moved or notice.GetResyncedPaths():
            alive.forget()
            for path in dict.fromkeys(moved):
                alive.stage_moved(path.pathString)

    return changed


NOTHING: Mapping[str, Floats] = MappingProxyType({})


class PrimPoses(Suggesting, ABC):
    """World transforms and attributes by path; matrices are (4, 4), column vectors, stage units.

    The common part of Fabric and of the stage as the world: bodies have their poses of physics, and everything else
    follows them as the stage composes it. Subclasses define what placing a prim means.
    """

    enabled: bool
    """Whether this is Fabric; False if the stage itself is the world (`fidelity.fabric: off`)."""
    every_step: bool
    """Whether it must be called after every single step."""

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        self.stage = stage
        self.warn = warn
        self.values = AttributeValues(stage)
        """Attributes that were set."""
        self.set = self.values.set
        self.change_stamp = self.values.change_stamp
        self.stage_has, self.has_prim = self.values.stage_has, self.values.has_prim
        self._unit: float | None = None
        self.stamp = 0
        """Changes whenever any pose may have changed."""
        self.steps = 0
        """Physics steps since play."""
        self.muted = False
        """Whether the present writes to the stage come from physics."""
        self.follow_stage = True
        """Whether edits of the stage are followed."""
        self.promoted: dict[str, bool] = {}
        """Static prims that users have moved while playing and that are now bodies; whether the descendants of each
        move with it.
        """
        self.promote: Callable[[str], bool] | None = None
        """Called before a static prim is placed: makes it a body if physics or rays use it; set while playing."""
        self.carried: Callable[[str], None] | None = None
        """Called with each body that is placed, to move the bodies below it; set while the stage is the world."""
        self._physics: PhysicsEngine | None = None
        self._layout: dict[str, int] = {}
        self._frames: dict[str, Floats] = {}
        self._speeds: dict[str, Floats] = {}
        self._latest: Poses | None = None
        self._bindings: dict[tuple[str, ...], Binding] = {}
        self._residuals: dict[str, Floats] = {}
        self._listener = StageListener(stage, self)

    @property
    def meters_per_unit(self) -> float:
        """Metres in a unit of the stage: what the stage says, and while it plays, what it said at play."""
        return meters_per_unit(self.stage) if self._unit is None else self._unit

    def close(self) -> None:
        """Stops listening to the stage; attributes of physics end."""
        self._listener.close()
        self.values.live.clear()

    def take_values(self, other: PrimPoses) -> None:
        """Takes over all attributes that were set."""
        self.values.take(other.values)

    # -- attributes and prims ----------------------------------------------------------------------------------------

    @property
    def live(self) -> dict[str, Live]:
        """Attributes, by name, whose values physics owns."""
        return self.values.live

    def get(self, path: str, attribute: str, default: Any = None) -> Any:
        """An attribute's value: as set, else the stage's, else `default`."""
        value = self.get_raw(path, attribute)
        if attribute.startswith("xformOp") and not self.values.has(path, attribute):
            cause = self.outdated_on_stage(path)
            if cause is not None:
                self.warn("fabric-stale-transform", f"{path}.{attribute}", cause)
        return default if value is None else value

    def get_raw(self, path: str, attribute: str) -> Any:
        """As `get`, without a warning about an out-of-date value; None without a value.

        The points of a prim that physics deforms are the present ones.
        """
        if attribute == "points" and not self.values.has(path, attribute):
            points = self.capture().points(path)
            if points is not None:
                from graph.sim.usd import Vt

                inverse: Floats = np.asarray(np.linalg.inv(self.world_matrix(path)), dtype=np.float64)
                local = transforms.transformed(inverse, points / self.meters_per_unit)
                return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(local, dtype=np.float32))
        return self.values.get(path, attribute)

    def get_prim_at_path(self, path: str) -> FabricPrim:
        """The prim at a path, with usdrt's name and strict reads: an out-of-date value raises.

        Falsy if it does not exist.
        """
        return FabricPrim(self, str(path))

    GetPrimAtPath = get_prim_at_path

    def has_place(self, path: str) -> bool:
        """Whether the stage has a prim, so that it has a pose."""
        return bool(self.values.prim(path))

    def resets(self, path: str) -> bool:
        """Whether a prim's transform ignores its parent."""
        from graph.sim.usd import UsdGeom

        xformable = UsdGeom.Xformable(self.values.prim(path))
        return bool(xformable and xformable.GetResetXformStack())

    def stale_because_of(self, path: str) -> str | None:
        """The ancestor that a user placed after this prim, so that the prim's own matrix is out of date, or None."""
        return None

    def outdated_on_stage(self, path: str) -> str | None:
        """Why the stage's transform of a prim is not its present one, or None."""
        return None

    # -- life --------------------------------------------------------------------------------------------------------

    def bind(self, physics: PhysicsEngine | None) -> None:
        """Follows the bodies of a world that starts to play or has changed (None: nothing moves)."""
        self._physics = physics
        if self._unit is None:
            self._unit = meters_per_unit(self.stage)
            self.forget()
        bodies = physics.body_paths if physics else ()
        self._frames = {path: frame for path, frame in self._frames.items() if path not in bodies}
        self._residuals = {path: self._residual(path) for path in (*bodies, *self._frames)}
        self._number_rows()

    def rebind(self, physics: PhysicsEngine | None, touched: Sequence[str]) -> None:
        """Follows the bodies of a world that was compiled again; prims at and below `touched` may have another size."""
        prefixes = tuple(f"{path.rstrip('/')}/" for path in touched)
        self._residuals = {
            path: residual
            for path, residual in self._residuals.items()
            if path not in touched and not path.startswith(prefixes)
        }
        self.bind(physics)

    def unbind(self) -> None:
        """Returns to the stage: nothing follows a body, and values that users wrote to its prims are dropped."""
        self._physics = self._unit = None
        self._layout, self._residuals, self._frames, self._speeds, self.promoted, self.steps = {}, {}, {}, {}, {}, 0
        self.values.forget()
        self.forget()

    def forget(self) -> None:
        """The stage has changed: it is read again at the next use."""
        self._bindings.clear()
        self._latest = None
        self.stamp += 1

    def stepped(self, count: int = 1) -> None:
        """Physics has stepped `count` times: poses read from now on are new."""
        self.stamp += count
        self.steps += count
        self._latest = None

    def touched(self) -> None:
        """A user has written to physics between its steps: poses read from now on are new."""
        self.stamp += 1
        self._latest = None

    # -- poses -------------------------------------------------------------------------------------------------------

    def capture(self) -> Poses:
        """The present poses; costs nothing if nothing moved since the last capture."""
        if self._latest is None:
            frames = np.stack(list(self._frames.values())) if self._frames else None
            self._latest = Poses(self.stamp, self._physics, self._layout, self._placed(), frames, dict(self._speeds))
        return self._latest

    def world_matrices(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 4, 4) prim to world, now or at captured `poses`. Raises RunError for a missing prim."""
        poses = poses or self.capture()
        binding = self._bind(tuple(paths))
        if poses.layout is self._layout:
            matrices = poses.matrices[binding.bodies]
        else:
            matrices = self.rigid_matrices(binding.names, poses)
        if self.meters_per_unit != 1:
            matrices[:, :3, 3] /= self.meters_per_unit
        out = matrices @ binding.offsets
        return self._finished(paths, poses.written, out)

    def world_matrix(self, path: str, poses: Poses | None = None) -> Floats:
        """(4, 4) prim to world, now or at captured `poses`."""
        out: Floats = self.world_matrices((path,), poses)[0]
        return out

    def rigid_matrices(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 4, 4) poses without scale, in metres: the frames of `geometry.Mesh.vertices` of bodies.

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
            elif path in self._layout and poses.layout is not self._layout:  # it was not a body then
                out[number] = self.capture().matrices[self._layout[path]]
            else:
                out[number] = transforms.rigid_part(self.world_matrix(path, poses))
                out[number, :3, 3] *= self.meters_per_unit
        return out

    def velocities(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 6) of bodies' origins: linear [m/s], angular [rad/s], world axes; 0 for static ones."""
        return (poses or self.capture()).velocities(paths)

    # -- still prims that users move ---------------------------------------------------------------------------------

    def set_frames(self, poses: Mapping[str, Floats], velocities: Mapping[str, Floats] | None = None) -> None:
        """Places prims that physics does not move, as bodies of their own: rigid poses (4, 4) [m] by path.

        velocities: (6,) linear [m/s] and angular [rad/s] of their origins, world axes; default 0. Kinematic bodies of
        physics may be included, because physics does not know how fast they are moved.
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
        """From now on a static prim counts as a kinematic body."""
        self._frames[path] = self.rigid_matrices((path,))[0].copy()
        self._residuals[path] = self._residual(path)
        self._number_rows()

    def is_body(self, path: str) -> bool:
        """Whether a prim is a body that physics or users move."""
        return path in self._layout

    def bodies_below(self, path: str) -> list[str]:
        """Bodies strictly below a prim."""
        prefix = f"{path.rstrip('/')}/"
        return [body for body in self._layout if body.startswith(prefix)]

    def _number_rows(self) -> None:
        bodies = self._physics.body_paths if self._physics else ()
        self._layout = {path: number for number, path in enumerate((*bodies, *self._frames))}
        self.forget()

    # -- placing -----------------------------------------------------------------------------------------------------

    @abstractmethod
    def set_world_matrix(self, path: str, matrix: Floats) -> None:
        """Places a prim: (4, 4) prim to world, stage units. Raises RunError for an unusable matrix."""

    def checked(self, path: str, matrix: Any) -> Floats:
        """A world matrix that a user gives. Raises RunError for an invalid one."""
        out = np.array(matrix, dtype=np.float64)
        if out.shape != (4, 4) or not transforms.usable(out):
            raise RunError(f"{path}: a world matrix must be (4, 4), finite and not flat")
        return out

    def place_body(self, path: str, matrix: Floats) -> None:
        """Places a body, or a static prim that has become a frame, without its scale; what it carries moves too.

        Raises RunError for a body held by a joint.
        """
        self._put(path, matrix)

    def take_from_stage(self, path: str, matrix: Floats) -> None:
        """Takes a body's pose from the stage: `place_body` without writing to the stage."""
        self._put(path, self.checked(path, matrix))

    @abstractmethod
    def settle(self) -> None:
        """Marks all moves by the stage as handled."""

    def restore(self, poses: Mapping[str, Floats]) -> None:
        """Static prims that became bodies, and kinematic bodies, go to `poses` [m]; placed poses are dropped."""
        self._frames.update({path: poses[path] for path in self._frames if path in poses})
        self.forget()

    @abstractmethod
    def stage_moved(self, path: str) -> None:
        """The stage has a new transform for a prim."""

    @abstractmethod
    def update_world_xforms(self) -> None:
        """Moves the descendants of placed prims with them; then nothing is stale."""

    def _put(self, path: str, matrix: Floats) -> None:
        pose = transforms.rigid_part(matrix)
        pose[:3, 3] *= self.meters_per_unit
        if path in self._frames:
            self._frames[path] = pose
        elif self._physics is not None:
            self._physics.set_poses((path,), pose[None])
        self._latest = None
        self.stamp += 1

    # -- inside ------------------------------------------------------------------------------------------------------

    def _placed(self) -> Mapping[str, Floats]:
        """World matrices that users have given to prims without a body."""
        return NOTHING

    def _offset(self, path: str) -> Floats | None:
        """The pose that a user gave a prim in the frame of its body, or None: that of the stage."""
        return None

    def _finished(self, paths: Sequence[str], written: Mapping[str, Floats], out: Floats) -> Floats:
        """The world matrices `out` of prims, with the placed poses inserted."""
        return out

    def _bind(self, paths: tuple[str, ...]) -> Binding:
        binding = self._bindings.get(paths)
        if binding is None:
            binding = self._bindings[paths] = bind(
                self.stage, paths, self.body_of, self._layout, self._residuals, self._offset
            )
        return binding

    def _residual(self, path: str) -> Floats:
        """A body's transform without its pose: scale and shear; kept as long as the body exists."""
        if path in self._residuals:
            return self._residuals[path]
        return scale_and_shear(self.stage, path)

    def _carries(self, path: str) -> bool:
        """Whether the prim at a path is a body that moves its descendants."""
        return path in self._layout and self.promoted.get(path, True)

    def body_of(self, path: str) -> str | None:
        """The nearest body, at or above a path, with which a prim there moves."""
        here = path
        while here:
            if here in self._layout and (here == path or self._carries(here)):
                return here
            if self.has_place(here) and self.resets(here):
                return None
            here = here.rpartition("/")[0]
        return None
