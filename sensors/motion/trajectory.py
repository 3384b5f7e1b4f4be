"""Poses between known poses: positions along straight lines, rotations along great circles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graph.sim.transforms import quaternions, rotation_matrices, slerp


class Trajectory:
    """A rigid motion through known poses, constant before the first and after the last.

    times: (m,) float64, ascending [s]; poses: (m, 4, 4) float64 rigid [m]. twists: gives the velocities at these times,
    (m, 6) float64, of the moving origin [m/s] and angular [rad/s], world axes.
    """

    def __init__(self, times: np.ndarray, poses: np.ndarray, twists: Callable[[], np.ndarray] | None = None) -> None:
        self._times, self._poses, self._twists = times, poses, twists
        self.turns = bool(np.any(poses[:, :3, :3] != poses[0, :3, :3]))
        """Whether its rotation changes."""
        self.moves = bool(np.any(poses[:, :3, 3] != poses[0, :3, 3]))
        """Whether its position changes."""
        self._quaternions = quaternions(poses[:, :3, :3]) if self.turns else None
        self._kept = np.ones(len(poses), bool)  # whether the rotation stays until the next pose
        self._kept[:-1] = np.all(poses[1:, :3, :3] == poses[:-1, :3, :3], axis=(1, 2))

    def positions(self, times: np.ndarray) -> np.ndarray:
        """(n, 3) float64 [m]."""
        if not self.moves:
            return np.broadcast_to(self._poses[0, :3, 3], (len(times), 3))
        index, share = self._between(times)
        first, second = self._poses[index, :3, 3], self._poses[np.minimum(index + 1, len(self._poses) - 1), :3, 3]
        return np.asarray(first + share[:, None] * (second - first))

    def rotations(self, times: np.ndarray) -> np.ndarray:
        """(n, 3, 3) float64."""
        if self._quaternions is None:
            return np.broadcast_to(self._poses[0, :3, :3], (len(times), 3, 3))
        index, share = self._between(times)
        second = self._quaternions[np.minimum(index + 1, len(self._poses) - 1)]
        out = np.asarray(rotation_matrices(slerp(self._quaternions[index], second, share)))
        exact = self._kept[index] | (share == 0.0)  # the known matrix itself, whatever poses follow
        out[exact] = self._poses[index[exact], :3, :3]
        return out

    def velocities(self, times: np.ndarray) -> np.ndarray:
        """(n, 6) float64, interpolated linearly: of the origin [m/s], angular [rad/s]; 0 if unknown."""
        if self._twists is None:
            return np.zeros((len(times), 6))
        twists, (index, share) = self._twists(), self._between(times)
        first, second = twists[index], twists[np.minimum(index + 1, len(twists) - 1)]
        return np.asarray(first + share[:, None] * (second - first))

    def poses(self, times: np.ndarray) -> np.ndarray:
        """(n, 4, 4) float64 rigid [m]."""
        if not (self.turns or self.moves):
            return np.repeat(self._poses[:1], len(times), axis=0)
        out = np.zeros((len(times), 4, 4))
        out[:, :3, :3] = self.rotations(times)
        out[:, :3, 3] = self.positions(times)
        out[:, 3, 3] = 1.0
        return out

    def _between(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The known pose at or before each time, and the fraction (0 to 1) of the way to the next."""
        known = self._times
        index = np.clip(np.searchsorted(known, times, side="right") - 1, 0, len(known) - 1)
        step = known[np.minimum(index + 1, len(known) - 1)] - known[index]
        share = np.where(step > 0, (times - known[index]) / np.where(step > 0, step, 1.0), 0.0)
        return index, np.clip(share, 0.0, 1.0)
