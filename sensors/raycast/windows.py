"""Finds the rays in cones: directions are sorted into bands of elevation and cells of azimuth within them."""

from __future__ import annotations

import itertools

import numpy as np

COLUMNS = 720
"""Cells of a band."""

PER_DEGREE = COLUMNS // 360

BANDS_PER_DEGREE = (50, 2)
"""One band per lidar row; above `MOST_BANDS`, bands are one cell high."""

MOST_BANDS = 512
BAND_EDGE_DEG = 0.0071
"""Bands begin this far from round numbers, because elevations are often round."""

MARGIN_DEG = 0.01
"""Windows are widened by this angle, so that rounding loses no ray."""


ROUNDING = 1e-9
"""Tolerance of cosines: a band about the pole that a cone just reaches counts as fully inside."""


class RayGrid:
    """Directions by azimuth and elevation, to find quickly those in any number of cones.

    local: (n, 3) float32 unit directions, in a frame that `rotation` (3, 3) turns to world axes; z is up in it.
    """

    def __init__(self, local: np.ndarray) -> None:
        x, y, z = local.astype(np.float64).T
        elevation = np.rad2deg(np.arctan2(z, np.hypot(x, y)))
        band = _bands(elevation)
        column = np.clip(_cell(np.rad2deg(np.arctan2(y, x))) + COLUMNS // 2, 0, COLUMNS - 1)
        order = np.lexsort((column, band))
        count = int(band.max()) + 1 if len(band) else 0
        ends = np.searchsorted(band[order], np.arange(count + 1))
        rows = [order[start:end] for start, end in itertools.pairwise(ends)]
        # Each band is stored twice, so that a window across the seam is one run as well.
        self._index = np.concatenate([each for row in rows for each in (row, row)] or [order])
        filled = np.bincount(band * COLUMNS + column, minlength=count * COLUMNS).reshape(count, COLUMNS)
        before = np.cumsum(np.concatenate([0 * filled[:, :1], filled, filled], 1), axis=1)
        self._start = (2 * ends[:-1, None] + before).astype(np.int32)
        self._low = np.array([elevation[row].min() for row in rows])
        self._high = np.array([elevation[row].max() for row in rows])
        middle = np.deg2rad(self._low + self._high) / 2
        self._sine, self._cosine = np.sin(middle), np.maximum(np.cos(middle), 1e-12)
        self._reach = np.deg2rad(self._high - self._low) / 2
        self.rotation: np.ndarray = np.eye(3)
        self.count = len(local)
        """Number of directions."""

    def near(self, axes: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(index (k,), counts (m,)): every ray in a cone about the origin, and some more, cone after cone.

        axes: (m, 3) float64, of any length, world axes; half: (m,) [rad], half the angle of each cone; from pi on, all
        rays. A ray is repeated for each cone that may contain it.
        """
        x, y, z = (axes @ self.rotation).T
        elevation, azimuth = np.arctan2(z, np.hypot(x, y)), np.rad2deg(np.arctan2(y, x))
        middle, wide = np.rad2deg(elevation), np.rad2deg(half) + MARGIN_DEG
        first = np.searchsorted(self._high, middle - wide)
        last = np.searchsorted(self._low, middle + wide, side="right")
        bands = np.maximum(last - first, 0)
        owner, band = np.repeat(np.arange(len(axes)), bands), _runs(first, bands)
        width = self._width(elevation, half, owner, band)
        centre = azimuth.take(owner)
        low = _cell(centre - width)
        span = np.minimum(_cell(centre + width) - low, COLUMNS - 1)
        low = (low + COLUMNS // 2) % COLUMNS
        start, end = self._start[band, low], self._start[band, low + span + 1]
        rays = end - start
        counts = np.bincount(owner, rays, len(axes)).astype(np.intp)
        return self._index.take(_runs(start, rays)), counts

    def _width(self, elevation: np.ndarray, half: np.ndarray, owner: np.ndarray, band: np.ndarray) -> np.ndarray:
        """Half the azimuth [deg] of the cone `owner` in a band: by the spherical law of cosines."""
        within = np.minimum(half.take(owner) + self._reach.take(band) + np.deg2rad(MARGIN_DEG), np.pi)
        above = np.cos(within) - np.take(np.sin(elevation), owner) * self._sine.take(band) - ROUNDING
        cosine = above / (np.take(np.maximum(np.cos(elevation), 1e-12), owner) * self._cosine.take(band))
        return np.asarray(np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0))) + MARGIN_DEG)


def _bands(elevation: np.ndarray) -> np.ndarray:
    """The band of each elevation [deg], numbered upwards; no band is empty."""
    for per_degree in BANDS_PER_DEGREE:
        found, band = np.unique(np.floor((elevation + BAND_EDGE_DEG) * per_degree), return_inverse=True)
        if len(found) <= MOST_BANDS:
            break
    return band


def _cell(degrees: np.ndarray) -> np.ndarray:
    return np.asarray(np.floor(degrees * PER_DEGREE), np.int64)


def _runs(start: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Every value in the runs start .. start + count - 1, run after run."""
    return np.asarray(np.arange(count.sum()) + np.repeat(start - (np.cumsum(count) - count), count))
