"""Where prims are now: bodies as physics has them, all else as the stage composes it around them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.scene.stage import Warn, ignore_warning, meters_per_unit
from graph.sim.transforms import Floats

from .fabric_values import FabricValues
from .poses import Poses

if TYPE_CHECKING:
    from graph.sim.physics.protocol import PhysicsEngine

NOTHING: Mapping[str, Floats] = MappingProxyType({})


@dataclass(frozen=True)
class _Binding:
    """Which body each of some prims follows (-1: none), by row and path, and its matrix in that body's rigid frame."""

    bodies: NDArray[np.intp]
    names: tuple[str, ...]
    offsets: Floats


class FabricPoses(FabricValues):
    """World transforms by path. Matrices are (4, 4), column vectors, stage units."""

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        super().__init__(stage, warn)
        self.meters_per_unit = meters_per_unit(stage)
        self.stamp = 0
        """Changes whenever any pose may have changed."""
        self.steps = 0
        """Physics steps since play."""
        self.promoted: dict[str, bool] = {}
        """Still prims that users have moved while playing, bodies since; whether what is below each goes with it."""
        self.promote: Callable[[str], bool] | None = None
        """Asked before a still prim is placed: makes it one if physics or rays look at it; set while playing."""
        self._physics: PhysicsEngine | None = None
        self._layout: dict[str, int] = {}
        self._frames: dict[str, Floats] = {}
        self._speeds: dict[str, Floats] = {}
        self._latest: Poses | None = None
        self._bindings: dict[tuple[str, ...], _Binding] = {}
        self._residuals: dict[str, Floats] = {}
        self._written: Mapping[str, Floats] = NOTHING
        self._stamps: dict[str, int] = {}
        self._offsets: dict[str, Floats] = {}

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
        self._layout, self._offsets, self._written, self._stamps = {}, {}, NOTHING, {}
        self._residuals, self._frames, self._speeds, self.promoted, self.steps = {}, {}, {}, {}, 0
        self._forget_values()
        self.forget()

    def forget(self) -> None:
        """The stage has changed: read it again where it is asked for next."""
        self._bindings.clear()
        self._latest = None
        self.stamp += 1

    every_step = False
    """Whether it has to know of every single step."""

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

    def get_raw(self, path: str, attribute: str) -> Any:
        """As `FabricValues.get_raw`; the points of what physics deforms are where it has them."""
        if attribute == "points" and (path, attribute) not in self._values:
            points = self.capture().points(path)
            if points is not None:
                from graph.sim.usd import Vt

                inverse: Floats = np.asarray(np.linalg.inv(self.world_matrix(path)), dtype=np.float64)
                local = transforms.transformed(inverse, points / self.meters_per_unit)
                return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(local, dtype=np.float32))
        return super().get_raw(path, attribute)

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

    def _number_rows(self) -> None:
        bodies = self._physics.body_paths if self._physics else ()
        self._layout = {path: number for number, path in enumerate((*bodies, *self._frames))}
        self.forget()

    # -- inside ------------------------------------------------------------------------------------------------------

    def _finish_written(self, paths: Sequence[str], written: Mapping[str, Floats], out: Floats) -> None:
        """Put in what users have written."""

    def _bind(self, paths: tuple[str, ...]) -> _Binding:
        binding = self._bindings.get(paths)
        if binding is None:
            binding = self._bindings[paths] = self._bound(paths)
        return binding

    def _bound(self, paths: tuple[str, ...]) -> _Binding:
        from graph.sim.usd import EARLIEST, UsdGeom

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
        from graph.sim.usd import EARLIEST, UsdGeom

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
            if self.has_place(here) and self.resets(here):
                return None
            here = here.rpartition("/")[0]
        return None
