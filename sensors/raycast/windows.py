"""Which rays lie in which cones: directions sorted into cells of azimuth and elevation."""

from __future__ import annotations

import numpy as np

PER_DEGREE = 2
"""Cells per degree, both ways."""

COLUMNS = 360 * PER_DEGREE
MARGIN_DEG = 0.01
"""Windows are this much wider than they need be, so that rounding loses no ray."""


class RayGrid:
    """Directions by azimuth and elevation, to find at once those in any number of cones.

    local: (n, 3) float32 unit directions, in a frame that `rotation` (3, 3) turns into the world's; z is up in it.
    """

    def __init__(self, local: np.ndarray) -> None:
        x, y, z = local.astype(np.float64).T
        row = _cell(np.rad2deg(np.arctan2(z, np.hypot(x, y))))
        column = np.clip(_cell(np.rad2deg(np.arctan2(y, x))) + COLUMNS // 2, 0, COLUMNS - 1)
        self._lowest = int(row.min()) if len(row) else 0
        self._rows = int(row.max()) - self._lowest + 1 if len(row) else 0
        cell = (row - self._lowest) * COLUMNS + column
        self._index = np.argsort(cell, kind="stable")
        self._start = np.concatenate([[0], np.cumsum(np.bincount(cell, minlength=self._rows * COLUMNS))])
        self.rotation: np.ndarray = np.eye(3)
        self.count = len(local)
        """Number of directions."""

    def near(self, axes: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(index, owner), each (k,): every ray in a cone about the origin, and some more, with the cone's number.

        axes: (m, 3) float64, of any length, world axes; half: (m,) [rad], half the angle of each cone: from pi on all
        rays. Sorted by owner; a ray comes once for each cone that it may lie in.
        """
        half, elevation, azimuth = self._angles(axes, half)
        low = np.clip(_cell(elevation - half) - self._lowest, 0, self._rows)
        high = np.clip(_cell(elevation + half) - self._lowest, -1, self._rows - 1)
        owner, first, last = _columns(azimuth, _width(elevation, half))
        segment, row = _expand(low[owner], np.maximum(high - low + 1, 0)[owner])
        base = row * COLUMNS
        start, end = self._start[base + first[segment]], self._start[base + last[segment] + 1]
        which, position = _expand(start, end - start)
        return self._index[position], owner[segment][which]

    def _angles(self, axes: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Half angle, elevation and azimuth [deg] of cones."""
        x, y, z = (axes @ self.rotation).T
        wide = np.minimum(np.rad2deg(half) + MARGIN_DEG, 180.0)
        return wide, np.rad2deg(np.arctan2(z, np.hypot(x, y))), np.rad2deg(np.arctan2(y, x))


def _cell(degrees: np.ndarray) -> np.ndarray:
    return np.asarray(np.floor(degrees * PER_DEGREE), np.int64)


def _width(elevation: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Half the azimuth [deg] that a cone takes up: all round where it reaches the pole."""
    polar = np.abs(elevation) + half >= 89.9
    sine = np.sin(np.deg2rad(np.minimum(half, 90.0))) / np.maximum(np.cos(np.deg2rad(elevation)), 1e-9)
    return np.where(polar, 180.0, np.rad2deg(np.arcsin(np.minimum(sine, 1.0))) + MARGIN_DEG)


def _columns(azimuth: np.ndarray, width: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(owner, first, last) runs of columns, sorted by owner; a window that crosses the seam is two runs."""
    low = _cell(azimuth - width) + COLUMNS // 2
    high = _cell(azimuth + width) + COLUMNS // 2
    around = high - low >= COLUMNS - 1
    low[around], high[around] = 0, COLUMNS - 1
    below, above = np.flatnonzero(low < 0), np.flatnonzero(high >= COLUMNS)
    owner = np.concatenate([np.arange(len(low)), below, above])
    first = np.concatenate([np.maximum(low, 0), low[below] + COLUMNS, np.zeros(len(above), np.int64)])
    last = np.concatenate([np.minimum(high, COLUMNS - 1), np.full(len(below), COLUMNS - 1), high[above] - COLUMNS])
    order = np.argsort(owner, kind="stable")
    return owner[order], first[order], last[order]


def _expand(start: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(number of the run, value) of every value in the runs start .. start + count - 1, run after run."""
    run = np.repeat(np.arange(len(count)), count)
    offset = start - (np.cumsum(count) - count)
    return run, np.arange(len(run)) + offset[run]
