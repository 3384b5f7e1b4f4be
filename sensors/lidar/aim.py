"""Origins and directions of a shot's rays, and the frame in which its points are given.

Rays start at one pose, or each at the sensor's pose when it fires.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import inverse_rigid
from sensors.compiled import compiled
from sensors.raycast.rays import COMMON


@dataclass(slots=True)
class RayPoses:
    """The sensor's poses at the firing times of rays: ray i has pose number `which[i]`.

    rotations: (u, 3, 3) float64, sensor to world; positions: (u, 3) float64 [m]; which: (n,), ascending. twists: gives
    the sensor's velocities at these poses, (u, 6) float64 [m/s, rad/s], world axes.
    """

    rotations: np.ndarray
    positions: np.ndarray
    which: np.ndarray
    turning: bool = True
    twists: Callable[[], np.ndarray] | None = None

    def part(self, rows: slice) -> RayPoses:
        """The poses of the rays in `rows`."""
        which = self.which[rows]
        used, twists = slice(which[0], which[-1] + 1), self.twists
        return RayPoses(
            self.rotations[used],
            self.positions[used],
            which - which[0],
            self.turning,
            None if twists is None else lambda: twists()[used],
        )

    def swing(self, pose: np.ndarray) -> float:
        """The largest angle [rad] between one of the rotations and that of `pose`, rounded up."""
        if not self.turning:
            return 0.0
        cosine = (np.einsum("nij,ij->n", self.rotations, pose[:3, :3]) - 1.0) / 2.0
        return float(np.arccos(np.clip(cosine.min(initial=1.0), -1.0, 1.0))) + 1e-6


@dataclass(slots=True)
class Aim:
    """Poses of the rays of a shot.

    pose: (4, 4) float64 sensor to world [m], near the middle of the shot. table: (n, 6) float32, its columns 3 to 5 the
    unit directions, world axes. offsets: (n, 3) float32 [m], world axes, from the pose's position to each ray's origin;
    None if all rays start there. moves: the sensor's pose for each ray; None if it is stationary at `pose`.
    """

    pose: np.ndarray
    table: np.ndarray
    offsets: np.ndarray | None = None
    moves: RayPoses | None = None

    def to_world(self, points: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """(k, 3) float64 [m], world, of points (k, 3), each in the sensor frame at the firing time of its ray.

        Computed column by column, so that a point does not depend on the number of points.
        """
        rotation = self._turns(rays)
        x, y, z = points.astype(np.float64).T
        origin = self.pose[:3, 3]
        out = np.stack(
            [rotation[..., i, 0] * x + rotation[..., i, 1] * y + rotation[..., i, 2] * z + origin[i] for i in range(3)],
            1,
        )
        if self.moves is not None:
            out += (self.moves.positions - origin)[self.moves.which[rays]]
        return out

    def twists(self, rays: np.ndarray) -> np.ndarray | None:
        """(6, k) float32: the sensor's velocity [m/s] and angular velocity [rad/s] when each of some rays was fired,
        world axes, as if it extended to the position of `pose`; None if it is stationary.
        """
        moves = self.moves
        if moves is None or moves.twists is None:
            return None
        at = np.array(moves.twists())
        at[:, :3] += np.cross(at[:, 3:], self.pose[:3, 3] - moves.positions)
        return np.asarray(np.take(at.T.astype(np.float32), moves.which[rays], axis=1))

    def turned_back(self, vectors: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """Vectors (k, 3) along world axes, each turned into the sensor frame at the firing time of its ray."""
        return turned_back(vectors, self._turns(rays).astype(vectors.dtype))

    def _turns(self, rays: np.ndarray) -> np.ndarray:
        if self.moves is None:
            return self.pose[:3, :3]
        return np.asarray(self.moves.rotations[self.moves.which[rays]])


@compiled
def aim_rays(columns: np.ndarray, rotation: np.ndarray, start: np.ndarray, table: np.ndarray) -> None:
    """Writes rays that begin at `start` (3,) into a table (n, 6), from directions (3, n) and a rotation (3, 3)."""
    a, b, c = rotation[0]
    d, e, f = rotation[1]
    g, h, i = rotation[2]
    left, up, ahead = start
    for ray in range(len(table)):
        x, y, z = columns[0, ray], columns[1, ray], columns[2, ray]
        table[ray, 0], table[ray, 1], table[ray, 2] = left, up, ahead
        table[ray, 3] = a * x + b * y + c * z
        table[ray, 4] = d * x + e * y + f * z
        table[ray, 5] = g * x + h * y + i * z


def moving_aim(
    pose: np.ndarray, moves: RayPoses, columns: np.ndarray, origins: np.ndarray | None, table: np.ndarray
) -> Aim:
    """The aim of a sensor that moves while it fires; writes the directions of its n rays into a table (n, 6).

    pose: any pose of the sensor during the shot. columns: (3, n) float32 directions, and origins: (n, 3) float32 [m] of
    the rays, both in the sensor frame.
    """
    offsets = np.empty((len(table), 3), np.float32)
    places = (moves.positions - pose[:3, 3]).astype(np.float32)
    turns = moves.rotations if moves.turning else moves.rotations[:1]
    _aim_each(
        *(columns, COMMON if origins is None else origins, moves.which, turns.astype(np.float32), places),
        *(table, offsets),
    )
    return Aim(pose, table, offsets, moves)


@compiled
def _aim_each(
    columns: np.ndarray,
    origins: np.ndarray,
    which: np.ndarray,
    turns: np.ndarray,
    places: np.ndarray,
    table: np.ndarray,
    offsets: np.ndarray,
) -> None:
    """Writes directions, and `offsets` (n, 3) of rays that fire from the poses `which` (n,): turns (u or 1, 3, 3) and
    places (u, 3).
    """
    for ray in range(len(table)):
        pose, own = which[ray], min(ray, len(origins) - 1)
        turn = min(pose, len(turns) - 1)
        x, y, z = columns[0, ray], columns[1, ray], columns[2, ray]
        p, q, r = origins[own, 0], origins[own, 1], origins[own, 2]
        for axis in range(3):
            a, b, c = turns[turn, axis, 0], turns[turn, axis, 1], turns[turn, axis, 2]
            table[ray, 3 + axis] = a * x + b * y + c * z
            offsets[ray, axis] = places[pose, axis] + (a * p + b * q + c * r)


def turned_back(vectors: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) in the axes of the rotated frame, R^T v; rotation: (3, 3), or (n, 3, 3) for one each."""
    out = np.empty(vectors.shape, np.result_type(vectors, rotation))
    _turn_back(vectors, rotation.reshape(-1, 3, 3), out)
    return out


@compiled
def _turn_back(vectors: np.ndarray, rotations: np.ndarray, out: np.ndarray) -> None:
    for row in range(len(vectors)):
        own = min(row, len(rotations) - 1)
        x, y, z = vectors[row, 0], vectors[row, 1], vectors[row, 2]
        for axis in range(3):
            out[row, axis] = x * rotations[own, 0, axis] + y * rotations[own, 1, axis] + z * rotations[own, 2, axis]


@dataclass(frozen=True, slots=True)
class Output:
    """Transforms measurements from the sensor frame of each firing to the output frame.

    world: along world axes, about the world's origin. common: (4, 4) pose of the sensor at the one time to which all
    points are transformed (COMPENSATED); None leaves each in the sensor frame of its own firing. custom: (4, 4) from
    the sensor frame to the output frame, or None.
    """

    world: bool = False
    common: np.ndarray | None = None
    custom: np.ndarray | None = None

    @property
    def is_sensor_frame(self) -> bool:
        """Whether points stay on the beams with which they were measured."""
        return not self.world and self.common is None and self.custom is None

    def points(self, points: np.ndarray, aim: Aim, rays: np.ndarray) -> np.ndarray:
        """(k, 3) float32 [m] of points (k, 3) float32 in the sensor frame; their rays: (k,)."""
        if self.is_sensor_frame:
            return points
        if self.world:
            return aim.to_world(points, rays).astype(np.float32)
        if self.common is None:
            assert self.custom is not None
            return _moved(points, self.custom).astype(np.float32)
        return _moved(aim.to_world(points, rays), self._from_world(self.common)).astype(np.float32)

    def vectors(self, world: np.ndarray, aim: Aim, rays: np.ndarray) -> np.ndarray:
        """Vectors (k, 3) along world axes, turned to the axes of the output frame."""
        if self.world:
            return world
        if self.common is not None:
            return turned_back(world, self._from_world(self.common)[:3, :3].T.astype(world.dtype))
        local = aim.turned_back(world, rays)
        return local if self.custom is None else turned_back(local, self.custom[:3, :3].T.astype(world.dtype))

    def _from_world(self, common: np.ndarray) -> np.ndarray:
        inverse = inverse_rigid(common)
        return inverse if self.custom is None else self.custom @ inverse


def _moved(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(k, 3) float64: points moved by a rigid matrix, by columns, so that bytes do not depend on their number."""
    x, y, z = points.astype(np.float64).T
    return np.stack([matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2] * z + matrix[i, 3] for i in range(3)], 1)
