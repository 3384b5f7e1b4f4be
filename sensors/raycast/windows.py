"""Finds the rays in cones: directions are sorted into bands of elevation and cells of azimuth within them."""

from __future__ import annotations

import itertools

import numpy as np

COLUMNS = 720
"""Cells of a band."""

PER_RADIAN = COLUMNS / (2 * np.pi)

BANDS_PER_DEGREE = (50, 2)
"""One band per lidar row; above `MOST_BANDS`, bands are one cell high."""

MOST_BANDS = 512
BAND_EDGE_DEG = 0.0071
"""Bands begin this far from round numbers, because elevations are often round."""

MARGIN = np.deg2rad(0.01)
"""Windows are widened by this angle [rad], so that rounding loses no ray."""

ROUNDING = 1e-9
"""Tolerance of cosines: a band about the pole that a cone just reaches counts as fully inside."""


class RayGrid:
    """Directions by azimuth and elevation, to find quickly those in any number of cones.

    local: (n, 3) float32 unit directions, in a frame that `rotation` (3, 3) turns to world axes; z is up in it.
    """

    def __init__(self, local: np.ndarray) -> None:
        x, y, z = local.astype(np.float64).T
        elevation = np.arctan2(z, np.hypot(x, y))
        band = _bands(np.rad2deg(elevation))
        column = np.clip(_cell(np.arctan2(y, x) * PER_RADIAN) + COLUMNS // 2, 0, COLUMNS - 1)
        order = np.lexsort((column, band))
        count = int(band.max()) + 1 if len(band) else 0
        ends = np.searchsorted(band[order], np.arange(count + 1))
        rows = [order[start:end] for start, end in itertools.pairwise(ends)]
        # Each band is stored twice, so that a window across the seam is one run as well.
        self._index = np.concatenate([each for row in rows for each in (row, row)] or [order])
        filled = np.bincount(band * COLUMNS + column, minlength=count * COLUMNS).reshape(count, COLUMNS)
        before = np.cumsum(np.concatenate([0 * filled[:, :1], filled, filled], 1), axis=1)
        self._start = (2 * ends[:-1, None] + before).astype(np.int32).reshape(-1)
        self._low = low = np.array([elevation[row].min() for row in rows])
        self._high = high = np.array([elevation[row].max() for row in rows])
        middle = (low + high) / 2
        # By columns: sine and cosine of a band's middle, half its height [rad].
        self._bands = np.stack([np.sin(middle), np.maximum(np.cos(middle), 1e-12), (high - low) / 2])
        self.rotation: np.ndarray = np.eye(3)
        self.count = len(local)
        """Number of directions."""

    def near(self, axes: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(index (k,), counts (m,)): every ray in a cone about the origin, and some more, cone after cone.

        axes: (m, 3) float64, of any length, world axes; half: (m,) [rad], half the angle of each cone; from pi on, all
        rays. A ray is repeated for each cone that may contain it.
        """
        return self.near_local(axes @ self.rotation, half)

    def near_local(self, axes: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same, with the axes in the grid's own frame."""
        x, y, z = axes.T
        level = np.hypot(x, y)
        elevation, azimuth, length = np.arctan2(z, level), np.arctan2(y, x), np.maximum(np.hypot(level, z), 1e-300)
        wide = half + MARGIN
        first = self._high.searchsorted(elevation - wide)
        bands = np.maximum(self._low.searchsorted(elevation + wide, side="right") - first, 0)
        cones = np.stack([z / length, np.maximum(level / length, 1e-12), wide, azimuth * PER_RADIAN])
        sine, cosine, wide, centre = cones.repeat(bands, axis=1)
        band = _runs(first, bands)
        band_sine, band_cosine, reach = self._bands.take(band, axis=1)
        # Half the azimuth of a cone in a band, by the spherical law of cosines.
        within = np.cos(np.minimum(wide + reach, np.pi)) - sine * band_sine - ROUNDING
        width = np.arccos((within / (cosine * band_cosine)).clip(-1.0, 1.0)) * PER_RADIAN + MARGIN * PER_RADIAN
        low = _cell(centre - width)
        span = np.minimum(_cell(centre + width) - low, COLUMNS - 1)
        low = (low + COLUMNS // 2) % COLUMNS + band * (2 * COLUMNS + 1)
        start = self._start.take(low)
        rays = self._start.take(low + span + 1) - start
        counts = np.bincount(np.arange(len(axes)).repeat(bands), rays, len(axes)).astype(np.intp)
        return self._index.take(_runs(start, rays)), counts


def _bands(elevation: np.ndarray) -> np.ndarray:
    """The band of each elevation [deg], numbered upwards; no band is empty."""
    for per_degree in BANDS_PER_DEGREE:
        found, band = np.unique(np.floor((elevation + BAND_EDGE_DEG) * per_degree), return_inverse=True)
        if len(found) <= MOST_BANDS:
            break
    return band


def _cell(azimuth: np.ndarray) -> np.ndarray:
    return np.asarray(np.floor(azimuth), np.int64)


def _runs(start: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Every value in the runs start .. start + count - 1, run after run."""
    ends = count.cumsum()
    out = (start - ends + count).repeat(count)
    out += np.arange(len(out))
    return np.asarray(out)
