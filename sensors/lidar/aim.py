"""Origins and directions of a shot's rays: from one pose, or for each ray from the sensor's pose when it fires."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


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

    pose: (4, 4) float64 sensor to world [m], near the middle of the shot. directions: (3, n) float32 unit, world axes.
    offsets: (n, 3) float32 [m], world axes, from the pose's position to each ray's origin; None if all rays start
    there. moves: the sensor's pose for each ray; None if it is stationary at `pose`.
    """

    pose: np.ndarray
    directions: np.ndarray
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


def moving_aim(
    pose: np.ndarray, moves: RayPoses, columns: np.ndarray, origins: np.ndarray | None, world: np.ndarray
) -> Aim:
    """The aim of a sensor that moves while it fires; writes the directions of its n rays into `world`, (3, n).

    pose: any pose of the sensor during the shot. columns: (3, n) float32 directions, and origins: (n, 3) float32 [m] of
    the rays, both in the sensor frame.
    """
    which = moves.which
    start = np.take((moves.positions - pose[:3, 3]).astype(np.float32), which, axis=0)
    x, y, z = columns
    for axis in range(3):
        row = _row(moves, axis)
        world[axis] = row[0] * x + row[1] * y + row[2] * z
        if origins is not None:
            start[:, axis] += row[0] * origins[:, 0] + row[1] * origins[:, 1] + row[2] * origins[:, 2]
    return Aim(pose, world, start, moves)


def _row(moves: RayPoses, axis: int) -> list[np.ndarray]:
    """One row of each ray's rotation: three columns (n,) float32, or single numbers if all rotations are equal."""
    if not moves.turning:
        return list(moves.rotations[0, axis].astype(np.float32))
    return [np.take(moves.rotations[:, axis, column].astype(np.float32), moves.which) for column in range(3)]


def turned_back(vectors: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) in the axes of the rotated frame: R^T v, column by column, so that sums do not depend on n.

    rotation: (3, 3), or (n, 3, 3) for one each.
    """
    out = np.empty(vectors.shape, np.result_type(vectors, rotation))
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    column, term = np.empty(len(vectors), out.dtype), np.empty(len(vectors), out.dtype)
    for axis in range(3):
        np.multiply(x, rotation[..., 0, axis], out=column)
        column += np.multiply(y, rotation[..., 1, axis], out=term)
        column += np.multiply(z, rotation[..., 2, axis], out=term)
        out[:, axis] = column
    return out
