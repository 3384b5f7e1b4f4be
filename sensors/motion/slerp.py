"""Poses between known poses: positions along straight lines, rotations along great circles."""

from __future__ import annotations

import numpy as np

from graph.sim.transforms import rotation_matrices


def slerp(first: np.ndarray, second: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Unit quaternions (n, 4) the `share` (n,) of the way from `first` to `second` (n, 4), the shorter way round.

    Shoemake, "Animating rotation with quaternion curves" (1985). Quaternions that are the same, or nearly so, are
    interpolated linearly and normalised, which differs by less than 1e-14.
    """
    cosine = np.einsum("ij,ij->i", first, second)
    second = np.where(cosine[:, None] < 0, -second, second)
    angle = np.arccos(np.minimum(np.abs(cosine), 1.0))
    sine = np.sin(angle)
    close = sine < 1e-6
    scale = np.where(close, 1.0, sine)
    one = np.where(close, 1.0 - share, np.sin((1.0 - share) * angle) / scale)
    two = np.where(close, share, np.sin(share * angle) / scale)
    out = one[:, None] * first + two[:, None] * second
    return np.asarray(out / np.sqrt(np.einsum("ij,ij->i", out, out))[:, None])


def quaternions(rotations: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) as unit quaternions (n, 4), w, x, y, z; each divided by its largest component (Shepperd)."""
    m = np.asarray(rotations, np.float64)
    xx, yy, zz = m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]
    # The outer product q q^T, four times over: its row with the largest diagonal is q times that component.
    outer = np.empty((len(m), 4, 4))
    outer[:, 0, 0], outer[:, 1, 1] = 1 + xx + yy + zz, 1 + xx - yy - zz
    outer[:, 2, 2], outer[:, 3, 3] = 1 - xx + yy - zz, 1 - xx - yy + zz
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        outer[:, 0, i + 1] = outer[:, i + 1, 0] = m[:, k, j] - m[:, j, k]
        outer[:, j + 1, k + 1] = outer[:, k + 1, j + 1] = m[:, k, j] + m[:, j, k]
    largest = np.argmax(np.einsum("nii->ni", outer), axis=1)
    q = outer[np.arange(len(m)), largest]
    return np.asarray(q / np.sqrt(np.einsum("ij,ij->i", q, q))[:, None])


class Trajectory:
    """A rigid motion through known poses, constant before the first and after the last.

    times: (m,) float64, rising [s]; poses: (m, 4, 4) float64 rigid [m].
    """

    def __init__(self, times: np.ndarray, poses: np.ndarray) -> None:
        self._times, self._poses = times, poses
        self.turns = bool(np.any(poses[:, :3, :3] != poses[0, :3, :3]))
        """Whether its rotation changes at all."""
        self.moves = bool(np.any(poses[:, :3, 3] != poses[0, :3, 3]))
        """Whether its position changes at all."""
        self._quaternions = quaternions(poses[:, :3, :3]) if self.turns else None

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
        return np.asarray(rotation_matrices(slerp(self._quaternions[index], second, share)))

    def poses(self, times: np.ndarray) -> np.ndarray:
        """(n, 4, 4) float64 rigid [m]."""
        out = np.zeros((len(times), 4, 4))
        out[:, :3, :3] = self.rotations(times)
        out[:, :3, 3] = self.positions(times)
        out[:, 3, 3] = 1.0
        return out

    def _between(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The known pose at or before each time, and how far it is to the next, 0 to 1."""
        known = self._times
        index = np.clip(np.searchsorted(known, times, side="right") - 1, 0, len(known) - 1)
        step = known[np.minimum(index + 1, len(known) - 1)] - known[index]
        share = np.where(step > 0, (times - known[index]) / np.where(step > 0, step, 1.0), 0.0)
        return index, np.clip(share, 0.0, 1.0)
