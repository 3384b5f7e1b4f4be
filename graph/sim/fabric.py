"""Fabric: where every prim is now, flattened, read by path and by many at once.

Physics moves bodies; everything below a moving body follows at the offset that the stage gives it. Nothing is computed
when physics steps: poses are composed when somebody reads them.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.errors import RunError

from . import transforms
from .stage import meters_per_unit
from .transforms import Floats

if TYPE_CHECKING:
    from .physics.engine import Physics


class Poses:
    """The poses of all bodies at one moment, and what users had written: immutable, valid after the world moved on."""

    def __init__(
        self, stamp: int, physics: Physics | None, index: Mapping[str, int], written: Mapping[str, Floats]
    ) -> None:
        self.stamp = stamp
        self.written = written
        self._index = index
        self._physics = physics
        if physics is None:
            self.positions, self._rotations, self._state = np.zeros((0, 3)), np.zeros((0, 3, 3)), None
        else:
            self.positions, self._rotations = physics.positions.copy(), physics.rotations.copy()
            self._state = physics.state()
        self.positions.flags.writeable = False

    @cached_property
    def matrices(self) -> Floats:
        """(B + 1, 4, 4) rigid body poses [m], the identity last: for what hangs on no body."""
        out = np.zeros((len(self.positions) + 1, 4, 4))
        out[:-1, :3, :3] = self._rotations
        out[:-1, :3, 3] = self.positions
        out[:, 3, 3] = 1
        out[-1, :3, :3] = np.eye(3)
        out.flags.writeable = False
        return out

    def velocities(self, bodies: Iterable[str]) -> Floats:
        """(n, 6) of the origins of bodies: linear [m/s], angular [rad/s], world axes; 0 if it does not move."""
        rows = np.array([self._index.get(path, -1) for path in bodies], dtype=np.intp)
        return self._motion[rows]

    @cached_property
    def _motion(self) -> Floats:
        """(B + 1, 6) of all bodies, zeros last. Once the physics is freed there is nothing that moves."""
        if self._physics is None or self._state is None or self._physics.closed:
            return np.zeros((len(self.positions) + 1, 6))
        return np.concatenate([self._physics.velocities(self._state), np.zeros((1, 6))])


@dataclass(frozen=True)
class _Binding:
    """Which body each of some prims follows (-1: none), and its matrix in that body's rigid frame [stage units]."""

    bodies: NDArray[np.intp]
    offsets: Floats


class Fabric:
    """World transforms and attributes by path. Matrices are (4, 4), column vectors, stage units."""

    def __init__(self, stage: Any) -> None:
        self.stage = stage
        self.meters_per_unit = meters_per_unit(stage)
        self.stamp = 0
        """Changes whenever any pose may have changed."""
        self._physics: Physics | None = None
        self._index: dict[str, int] = {}
        self._latest: Poses | None = None
        self._bindings: dict[tuple[str, ...], _Binding] = {}
        self._written: Mapping[str, Floats] = MappingProxyType({})
        self._offsets: dict[str, Floats] = {}
        self._values: dict[tuple[str, str], tuple[Any, int]] = {}
        self._on_change = _forgetter(self)
        self._listener = _listen(self._on_change, stage)

    def bind(self, physics: Physics | None) -> None:
        """Follow the bodies of a world that starts to play (None: nothing moves)."""
        self._physics = physics
        self._index = {path: number for number, path in enumerate(physics.body_paths)} if physics else {}
        self.forget()

    def unbind(self) -> None:
        """Return to the stage: nothing follows a body, and what users wrote to its prims is gone."""
        self._physics = None
        self._index, self._offsets, self._written = {}, {}, MappingProxyType({})
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
        self._latest = None

    def capture(self) -> Poses:
        """The poses of this moment; free if nothing moved since the last capture."""
        if self._latest is None:
            self._latest = Poses(self.stamp, self._physics, self._index, self._written)
        return self._latest

    def world_matrices(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 4, 4) prim to world, now or at captured `poses`. Raises RunError for a prim that is not there."""
        poses = poses or self.capture()
        binding = self._bind(tuple(paths))
        matrices = poses.matrices[binding.bodies]
        if self.meters_per_unit != 1:
            matrices[:, :3, 3] /= self.meters_per_unit
        out = matrices @ binding.offsets
        if poses.written:
            for number, path in enumerate(paths):
                if path in poses.written:
                    out[number] = poses.written[path]
        return out

    def world_matrix(self, path: str, poses: Poses | None = None) -> Floats:
        """(4, 4) prim to world, now or at captured `poses`."""
        out: Floats = self.world_matrices((path,), poses)[0]
        return out

    def rigid_matrices(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 4, 4) poses without scale, in metres: the frames that `geometry.Mesh.vertices` of bodies are given in."""
        poses = poses or self.capture()
        rows = [self._index.get(path, -1) for path in paths]
        if -1 not in rows:
            return poses.matrices[np.array(rows, dtype=np.intp)]
        out = np.stack([transforms.rigid_part(matrix) for matrix in self.world_matrices(paths, poses)])
        out[:, :3, 3] *= self.meters_per_unit
        return out

    def velocities(self, paths: Sequence[str], poses: Poses | None = None) -> Floats:
        """(n, 6) of bodies' origins: linear [m/s], angular [rad/s], world axes; 0 for what is no moving body."""
        return (poses or self.capture()).velocities(paths)

    def set_world_matrix(self, path: str, matrix: Floats) -> None:
        """Place one prim, and none below it.

        A free or kinematic body is moved in physics too, without its scale. A prim that follows a body follows it from
        its new place on. What was placed is forgotten on stop.
        """
        matrix = np.array(matrix, dtype=np.float64)
        if matrix.shape != (4, 4) or not transforms.usable(matrix):
            raise RunError(f"{path}: a world matrix must be (4, 4), finite and not flat.")
        bound = self._bind((path,))
        if path in self._index and self._physics is not None:
            pose = transforms.rigid_part(matrix)
            pose[:3, 3] *= self.meters_per_unit
            self._physics.set_pose(path, pose)
        elif bound.bodies[0] >= 0:
            body = self.capture().matrices[bound.bodies[0]].copy()
            body[:3, 3] /= self.meters_per_unit
            self._offsets[path] = transforms.inverse_rigid(body) @ matrix
            self._bindings.clear()
        else:
            self._written = MappingProxyType({**self._written, path: matrix})
        self._latest = None
        self.stamp += 1

    def get(self, path: str, attribute: str, default: Any = None) -> Any:
        """An attribute's value in Fabric; where nobody has set one, the stage's; else `default`."""
        entry = self._values.get((path, attribute))
        if entry is not None:
            return entry[0]
        prim = self.stage.GetPrimAtPath(path)
        value = prim.GetAttribute(attribute).Get() if prim and prim.HasAttribute(attribute) else None
        return default if value is None else value

    def set(self, path: str, attribute: str, value: Any) -> None:
        """Set an attribute in Fabric; the stage is not touched, and the prim need not be on it."""
        previous = self._values.get((path, attribute))
        self._values[path, attribute] = (value, 0 if previous is None else previous[1] + 1)

    def change_stamp(self, path: str, attribute: str) -> int:
        """How often an attribute has been set since its first value; -1 if never."""
        entry = self._values.get((path, attribute))
        return -1 if entry is None else entry[1]

    def close(self) -> None:
        """Stop listening to the stage."""
        self._listener.Revoke()

    def _bind(self, paths: tuple[str, ...]) -> _Binding:
        binding = self._bindings.get(paths)
        if binding is None:
            binding = self._bindings[paths] = self._bound(paths)
        return binding

    def _bound(self, paths: tuple[str, ...]) -> _Binding:
        from .usd import EARLIEST, UsdGeom

        xforms = UsdGeom.XformCache(EARLIEST)
        inverses: dict[str, Floats] = {}
        bodies = np.full(len(paths), -1, dtype=np.intp)
        offsets = np.empty((len(paths), 4, 4))
        for number, path in enumerate(paths):
            prim = self.stage.GetPrimAtPath(path) if path.startswith("/") else None
            if not prim:
                raise RunError(f"{path}: no such prim on the stage.")
            body = self._body_of(path)
            if body is not None:
                bodies[number] = self._index[body]
                if body not in inverses:
                    world = transforms.from_usd(xforms.GetLocalToWorldTransform(self.stage.GetPrimAtPath(body)))
                    inverses[body] = transforms.inverse_rigid(transforms.rigid_part(world))
            if path in self._offsets:
                offsets[number] = self._offsets[path]
                continue
            offsets[number] = transforms.from_usd(xforms.GetLocalToWorldTransform(prim))
            if body is not None:
                offsets[number] = inverses[body] @ offsets[number]
        return _Binding(bodies, offsets)

    def _body_of(self, path: str) -> str | None:
        while path:
            if path in self._index:
                return path
            path = path.rpartition("/")[0]
        return None


def _forgetter(fabric: Fabric) -> Callable[[Any, Any], None]:
    """What makes a Fabric forget what it has read when prims or transforms of its stage change."""
    weak = weakref.ref(fabric)

    def changed(notice: Any, sender: Any) -> None:
        alive = weak()
        if alive is not None and (
            notice.GetResyncedPaths() or any("xformOp" in path.name for path in notice.GetChangedInfoOnlyPaths())
        ):
            alive.forget()

    return changed


def _listen(callback: Callable[[Any, Any], None], stage: Any) -> Any:
    """Have USD call back on changes; it holds the callback weakly, so its owner must keep it."""
    from .usd import Tf, Usd

    return Tf.Notice.Register(Usd.Notice.ObjectsChanged, callback, stage)
