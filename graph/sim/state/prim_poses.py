"""Where prims are now: bodies as physics has them, all else as the stage composes it around them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.scene.stage import Warn, ignore_warning, meters_per_unit
from graph.sim.transforms import Floats

from .attribute_values import AttributeValues, Live
from .bindings import Binding, bind, scale_and_shear
from .fabric_prims import FabricPrim
from .poses import Poses
from .stage_listener import StageListener

if TYPE_CHECKING:
    from graph.sim.physics.protocol import PhysicsEngine

NOTHING: Mapping[str, Floats] = MappingProxyType({})


class PrimPoses(ABC):
    """World transforms and attributes by path; matrices are (4, 4), column vectors, stage units.

    What Fabric and the stage as the world have in common: bodies are where physics has them, all else hangs on them as
    the stage composes it. Subclasses say what it means to place a prim.
    """

    enabled: bool
    """Whether this is Fabric; False where the stage itself is the world (`fidelity.fabric: off`)."""
    every_step: bool
    """Whether it has to know of every single step."""

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        self.stage = stage
        self.warn = warn
        self.values = AttributeValues(stage)
        """Attributes that somebody has set."""
        self.set = self.values.set
        self.change_stamp = self.values.change_stamp
        self.stage_has, self.has_prim = self.values.stage_has, self.values.has_prim
        self.meters_per_unit = meters_per_unit(stage)
        self.stamp = 0
        """Changes whenever any pose may have changed."""
        self.steps = 0
        """Physics steps since play."""
        self.muted = False
        """Whether what is written to the stage now comes from physics."""
        self.follow_stage = True
        """Whether edits of the stage are heard of."""
        self.promoted: dict[str, bool] = {}
        """Still prims that users have moved while playing, bodies since; whether what is below each goes with it."""
        self.promote: Callable[[str], bool] | None = None
        """Asked before a still prim is placed: makes it one if physics or rays look at it; set while playing."""
        self.carried: Callable[[str], None] | None = None
        """Called with each body that is placed, to take along the bodies below it; set while the stage is the world."""
        self._physics: PhysicsEngine | None = None
        self._layout: dict[str, int] = {}
        self._frames: dict[str, Floats] = {}
        self._speeds: dict[str, Floats] = {}
        self._latest: Poses | None = None
        self._bindings: dict[tuple[str, ...], Binding] = {}
        self._residuals: dict[str, Floats] = {}
        self._listener = StageListener(stage, self)

    def close(self) -> None:
        """Stop listening to the stage; attributes of physics end."""
        self._listener.close()
        self.values.live.clear()

    def take_values(self, other: PrimPoses) -> None:
        """Take over all attributes that somebody has set."""
        self.values.take(other.values)

    # -- attributes and prims ----------------------------------------------------------------------------------------

    @property
    def live(self) -> dict[str, Live]:
        """Attributes, by name, whose values the physics has and takes."""
        return self.values.live

    def get(self, path: str, attribute: str, default: Any = None) -> Any:
        """An attribute's value; where nobody has set one, the stage's; else `default`."""
        value = self.get_raw(path, attribute)
        if attribute.startswith("xformOp") and not self.values.has(path, attribute):
            cause = self.outdated_on_stage(path)
            if cause is not None:
                self.warn("fabric-stale-transform", f"{path}.{attribute}", cause)
        return default if value is None else value

    def get_raw(self, path: str, attribute: str) -> Any:
        """As `get`, without a warning where the value is out of date; None where there is none.

        The points of what physics deforms are where it has them.
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
        """The prim at a path, as usdrt spells it, with strict reads: a value that would be out of date raises.

        False if there is none.
        """
        return FabricPrim(self, str(path))

    GetPrimAtPath = get_prim_at_path

    def has_place(self, path: str) -> bool:
        """Whether the stage has a prim, so that it stands somewhere."""
        return bool(self.values.prim(path))

    def resets(self, path: str) -> bool:
        """Whether a prim's transform does not count from its parent."""
        from graph.sim.usd import UsdGeom

        xformable = UsdGeom.Xformable(self.values.prim(path))
        return bool(xformable and xformable.GetResetXformStack())

    def stale_because_of(self, path: str) -> str | None:
        """The prim above that was placed by a user after this one, so that its own matrix is out of date; else None."""
        return None

    def outdated_on_stage(self, path: str) -> str | None:
        """Why the transform that the stage holds of a prim is not where it is now; None if it is."""
        return None

    # -- life --------------------------------------------------------------------------------------------------------

    def bind(self, physics: PhysicsEngine | None) -> None:
        """Follow the bodies of a world that starts to play, or is another from now on (None: nothing moves)."""
        self._physics = physics
        bodies = physics.body_paths if physics else ()
        self._frames = {path: frame for path, frame in self._frames.items() if path not in bodies}
        self._residuals = {path: self._residual(path) for path in (*bodies, *self._frames)}
        self._number_rows()

    def rebind(self, physics: PhysicsEngine | None, touched: Sequence[str]) -> None:
        """Follow the bodies of a world that was compiled anew; what is at and below `touched` may have another size."""
        prefixes = tuple(f"{path.rstrip('/')}/" for path in touched)
        self._residuals = {
            path: residual
            for path, residual in self._residuals.items()
            if path not in touched and not path.startswith(prefixes)
        }
        self.bind(physics)

    def unbind(self) -> None:
        """Return to the stage: nothing follows a body, and what users wrote to its prims is gone."""
        self._physics = None
        self._layout, self._residuals, self._frames, self._speeds, self.promoted, self.steps = {}, {}, {}, {}, {}, 0
        self.values.forget()
        self.forget()

    def forget(self) -> None:
        """The stage has changed: read it again where it is asked for next."""
        self._bindings.clear()
        self._latest = None
        self.stamp += 1

    def stepped(self, count: int = 1) -> None:
        """Physics has stepped `count` times: poses read from now on are new ones."""
        self.stamp += count
        self.steps += count
        self._latest = None

    def touched(self) -> None:
        """Somebody has written to physics between its steps: poses read from now on are new ones."""
        self.stamp += 1
        self._latest = None

    # -- poses -------------------------------------------------------------------------------------------------------

    def capture(self) -> Poses:
        """The poses of this moment; free if nothing moved since the last capture."""
        if self._latest is None:
            frames = np.stack(list(self._frames.values())) if self._frames else None
            self._latest = Poses(self.stamp, self._physics, self._layout, self._placed(), frames, dict(self._speeds))
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
        return self._finished(paths, poses.written, out)

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
        """(n, 6) of bodies' origins: linear [m/s], angular [rad/s], world axes; 0 for what is not a moving body."""
        return (poses or self.capture()).velocities(paths)

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
        """Place a prim: (4, 4) prim to world, stage units. Raises RunError for a matrix that is not usable."""

    def checked(self, path: str, matrix: Any) -> Floats:
        """A world matrix that a user gives. Raises RunError for one that is none."""
        out = np.array(matrix, dtype=np.float64)
        if out.shape != (4, 4) or not transforms.usable(out):
            raise RunError(f"{path}: a world matrix must be (4, 4), finite and not flat")
        return out

    def place_body(self, path: str, matrix: Floats) -> None:
        """Put a body, or a still prim that has become a frame, somewhere, without its scale; what it carries goes too.

        Raises RunError for a body held by a joint.
        """
        self._put(path, matrix)

    def take_from_stage(self, path: str, matrix: Floats) -> None:
        """The stage says where a body is: `place_body`, the stage left alone."""
        self._put(path, self.checked(path, matrix))

    @abstractmethod
    def settle(self) -> None:
        """All that the stage has moved was taken from it."""

    def restore(self, poses: Mapping[str, Floats]) -> None:
        """Still prims that became bodies, and kinematic bodies, go to `poses` [m]; what users placed is forgotten."""
        self._frames.update({path: poses[path] for path in self._frames if path in poses})
        self.forget()

    @abstractmethod
    def stage_moved(self, path: str) -> None:
        """The stage has a new transform for a prim."""

    @abstractmethod
    def update_world_xforms(self) -> None:
        """Take what is below prims that users have placed along: nothing is stale then."""

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
        """World matrices that users have given to prims on no body."""
        return NOTHING

    def _offset(self, path: str) -> Floats | None:
        """Where a user has placed a prim in the frame of its body; None: where the stage has it."""
        return None

    def _finished(self, paths: Sequence[str], written: Mapping[str, Floats], out: Floats) -> Floats:
        """The world matrices `out` of prims with what users have placed put in."""
        return out

    def _bind(self, paths: tuple[str, ...]) -> Binding:
        binding = self._bindings.get(paths)
        if binding is None:
            binding = self._bindings[paths] = bind(
                self.stage, paths, self.body_of, self._layout, self._residuals, self._offset
            )
        return binding

    def _residual(self, path: str) -> Floats:
        """What a body's transform has beside its pose: scale and shear; kept for as long as there is the body."""
        if path in self._residuals:
            return self._residuals[path]
        return scale_and_shear(self.stage, path)

    def _carries(self, path: str) -> bool:
        """Whether the prim at a path is a body that takes along what is below it."""
        return path in self._layout and self.promoted.get(path, True)

    def body_of(self, path: str) -> str | None:
        """The nearest body, at or above a path, that a prim there moves with."""
        here = path
        while here:
            if here in self._layout and (here == path or self._carries(here)):
                return here
            if self.has_place(here) and self.resets(here):
                return None
            here = here.rpartition("/")[0]
        return None
