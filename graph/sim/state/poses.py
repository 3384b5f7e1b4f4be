"""The poses of all bodies at one moment, a copy that stays valid; and the bodies that prims follow."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.base.errors import RunError
from graph.base.records import dataclass
from graph.sim import transforms
from graph.sim.transforms import Floats

if TYPE_CHECKING:
    from graph.sim.physics.protocol import PhysicsEngine, Snapshot


class Poses:
    """The poses of all bodies at one moment, and the poses that users had written: immutable.

    speeds: (6,) linear [m/s] and angular [rad/s] of frames and bodies that are moved by other means than physics, by
    path. layout: the row of each body by path. Bodies of physics come first, in its order, then `frames`: the rigid
    poses (F, 4, 4) [m] of static prims that users have moved. Two states with the same layout object have the same
    rows.
    """

    def __init__(
        self,
        stamp: int,
        physics: PhysicsEngine | None,
        layout: Mapping[str, int],
        written: Mapping[str, Floats],
        frames: Floats | None = None,
        speeds: Mapping[str, Floats] | None = None,
    ) -> None:
        self.stamp = stamp
        self.written = written
        self.layout = layout
        if physics is None:
            self.positions, self._rotations = np.zeros((0, 3)), np.zeros((0, 3, 3))
            self._snapshot: Snapshot | None = None
        else:
            self.positions, self._rotations = physics.positions.copy(), physics.rotations.copy()
            self._snapshot = physics.snapshot()
        self.bodies = len(self.positions)
        """The number of rows that are bodies of physics."""
        if frames is not None:
            self.positions = np.concatenate([self.positions, frames[:, :3, 3]])
            self._rotations = np.concatenate([self._rotations, frames[:, :3, :3]])
        self._speeds = speeds or {}
        self.positions.setflags(write=False)

    @cached_property
    def matrices(self) -> Floats:
        """(B + F + 1, 4, 4) rigid body poses [m]; the identity is last, for prims without a body."""
        out = np.zeros((len(self.positions) + 1, 4, 4))
        out[:-1, :3, :3] = self._rotations
        out[:-1, :3, 3] = self.positions
        out[:, 3, 3] = 1
        out[-1, :3, :3] = np.eye(3)
        out.setflags(write=False)
        return out

    def points(self, path: str) -> Floats | None:
        """(p, 3) the points of a prim that physics deforms, in the world [m], else None."""
        return None if self._snapshot is None else self._snapshot.points(path)

    def point_velocities(self, path: str) -> Floats | None:
        """(p, 3) the velocities of these points [m/s], else None."""
        return None if self._snapshot is None else self._snapshot.point_velocities(path)

    def velocities(self, bodies: Iterable[str]) -> Floats:
        """(n, 6) of the origins of bodies: linear [m/s], angular [rad/s], world axes; 0 for static ones."""
        rows = np.array([self.layout.get(path, -1) for path in bodies], dtype=np.intp)
        return self._motion[rows]

    @cached_property
    def _motion(self) -> Floats:
        """(B + F + 1, 6) of all bodies; 0 in the last row, and for bodies after physics is freed."""
        out = np.zeros((len(self.positions) + 1, 6))
        if self._snapshot is not None:
            out[: self.bodies] = self._snapshot.velocities()
        for path, speed in self._speeds.items():
            if path in self.layout:
                out[self.layout[path]] = speed
        return out


@dataclass(frozen=True)
class Binding:
    """The body that each of some prims follows (-1: none), by row and path, and its matrix in that body's rigid
    frame.
    """

    bodies: NDArray[np.intp]
    names: tuple[str, ...]
    offsets: Floats


def bind(
    stage: Any,
    paths: tuple[str, ...],
    body_of: Callable[[str], str | None],
    rows: Mapping[str, int],
    residuals: Mapping[str, Floats],
    offset: Callable[[str], Floats | None],
) -> Binding:
    """Binds prims to the bodies with which they move. Raises RunError for a prim that is not on the stage.

    body_of: the body of a prim, None without one. rows, residuals: of the bodies, by path; see `scale_and_shear`.
    offset: where a user has placed a prim in the frame of its body, None where the stage has it.
    """
    from graph.sim.usd import EARLIEST, UsdGeom

    xforms = UsdGeom.XformCache(EARLIEST)
    bodies = np.full(len(paths), -1, dtype=np.intp)
    offsets = np.empty((len(paths), 4, 4))
    names = [""] * len(paths)
    for number, path in enumerate(paths):
        prim = stage.GetPrimAtPath(path) if path.startswith("/") else None
        if not prim:
            raise RunError(f"{path}: no such prim on the stage")
        body = body_of(path)
        if body is None:
            offsets[number] = transforms.from_usd(xforms.GetLocalToWorldTransform(prim))
            continue
        bodies[number], names[number] = rows[body], body
        placed = offset(path)
        if placed is not None:
            offsets[number] = placed
            continue
        # Composed from the body downwards: where the body itself stands on the stage leaves no trace in it.
        relative, _ = xforms.ComputeRelativeTransform(prim, stage.GetPrimAtPath(body))
        offsets[number] = residuals[body] @ transforms.from_usd(relative)
    return Binding(bodies, tuple(names), offsets)


def scale_and_shear(stage: Any, path: str) -> Floats:
    """(4, 4) The scale and shear of a body's transform on the stage, which its pose does not contain."""
    from graph.sim.usd import EARLIEST, UsdGeom

    prim = stage.GetPrimAtPath(path)
    world = transforms.from_usd(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(prim))
    out = transforms.inverse_rigid(transforms.rigid_part(world)) @ world
    out[:3, 3] = 0.0
    return out
