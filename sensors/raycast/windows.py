"""Finds the rays in cones: directions are sorted into bands of elevation and cells of azimuth within them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graph.sim.transforms import apply
from sensors.compiled import compiled

COLUMNS = 720
"""Cells of a band; fewer from `FULL_SPANS` spans on, so that the table of cells does not grow further."""

FULL_SPANS = 8

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

    local: (n, 3) float32 unit directions, in a frame that `rotation` (3, 3) turns to world axes; z is up in it. starts:
    the first ray of each of s spans, ascending from 0: a cone finds the rays of one of them only.
    """

    def __init__(self, local: np.ndarray, starts: Sequence[int] = (0,)) -> None:
        ends = [*starts[1:], len(local)]
        self.sizes = np.diff([*starts, len(local)])
        """(s,), the number of rays in each span."""
        cones = [_cone(local[start:end]) for start, end in zip(starts, ends, strict=True)]
        self.middles, self.angles = np.array([axis for axis, _ in cones]), np.array([angle for _, angle in cones])
        """(s, 3) float64 unit, and (s,), the largest angle [rad] between that and the rays of a span."""
        x, y, z = local.astype(np.float64).T
        elevation = np.arctan2(z, np.hypot(x, y))
        band = _bands(np.rad2deg(elevation))
        self._count = count = int(band.max()) + 1 if len(band) else 0
        self._low, self._high = np.full((2, count), [[np.inf], [-np.inf]])
        np.minimum.at(self._low, band, elevation)
        np.maximum.at(self._high, band, elevation)
        middle = (self._low + self._high) / 2
        # By columns: sine and cosine of a band's middle, half its height [rad].
        self._bands = np.stack([np.sin(middle), np.maximum(np.cos(middle), 1e-12), (self._high - self._low) / 2])
        self._columns = columns = max(FULL_SPANS * COLUMNS // max(FULL_SPANS, len(starts)), 1)
        rows = count * len(starts)
        row = band + count * np.arange(len(starts)).repeat(self.sizes)
        column = np.clip(_cell(np.arctan2(y, x) * (columns / (2 * np.pi))) + columns // 2, 0, columns - 1)
        order = np.lexsort((column, row))
        begins = np.searchsorted(row[order], np.arange(rows + 1))
        # Each row is stored twice, so that a window across the seam is one run as well.
        self._index = order.take(runs(begins[:-1].repeat(2), np.diff(begins).repeat(2)))
        filled = np.bincount(row * columns + column, minlength=rows * columns).reshape(rows, columns)
        before = np.cumsum(np.concatenate([0 * filled[:, :1], filled, filled], 1), axis=1)
        self._start = (2 * begins[:-1, None] + before).astype(np.int32).reshape(-1)
        self.rotation: np.ndarray = np.eye(3)
        self.count = len(local)
        """Number of directions."""

    def turned(self, rotation: np.ndarray) -> RayGrid:
        """The same directions in a frame that `rotation` (3, 3) turns to world axes; they share their data."""
        found = RayGrid.__new__(RayGrid)
        found.__dict__ = {**self.__dict__, "rotation": rotation}
        return found

    def near(self, axes: np.ndarray, half: np.ndarray, span: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """(index (k,), counts (m,)): every ray of a span in a cone, and some more, cone after cone.

        axes: (m, 3) float64, of any length, world axes; half: (m,) [rad], half the angle of each cone; from pi on, all
        rays. A ray is repeated for each cone that may contain it.
        """
        return self.near_local(apply(self.rotation.T, axes), half, np.full(len(axes), span))

    def near_local(self, axes: np.ndarray, half: np.ndarray, span: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same, with the axes in the grid's own frame, and a span (m,) for each cone."""
        counts, total = np.empty(len(axes), np.intp), 64 * len(axes) + 64
        while True:
            found = np.empty(total, np.intp)
            total = _in_cones(
                *(axes, half, span, self.middles, self.angles, self._low, self._high, self._bands),
                *(self._columns, self._index, self._start, found, counts),
            )
            if total <= len(found):
                return found[:total], counts


@compiled
def _in_cones(
    axes: np.ndarray,
    half: np.ndarray,
    span: np.ndarray,
    middles: np.ndarray,
    angles: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    bands: np.ndarray,
    columns: int,
    order: np.ndarray,
    start: np.ndarray,
    found: np.ndarray,
    counts: np.ndarray,
) -> int:
    """How many rays there are: those that fit into `found`, and their `counts` (m,). See `RayGrid.near_local`; low,
    high: (b,) [rad] the elevations of each band.
    """
    per_radian, total = columns / (2 * np.pi), 0
    for cone in range(len(axes)):
        counts[cone] = 0
        x, y, z, group, wide = axes[cone, 0], axes[cone, 1], axes[cone, 2], span[cone], half[cone] + MARGIN
        level = math.hypot(x, y)
        length = max(math.hypot(level, z), 1e-300)
        along = (x * middles[group, 0] + y * middles[group, 1] + z * middles[group, 2]) / length
        if math.acos(min(max(along, -1.0), 1.0)) > wide + angles[group]:
            continue
        elevation, centre = math.atan2(z, level), math.atan2(y, x) * per_radian
        sine, cosine = z / length, max(level / length, 1e-12)
        for band in range(len(low)):
            if high[band] < elevation - wide or low[band] > elevation + wide:
                continue
            # Half the azimuth of a cone in a band, by the spherical law of cosines.
            within = math.cos(min(wide + bands[2, band], np.pi)) - sine * bands[0, band] - ROUNDING
            share = min(max(within / (cosine * bands[1, band]), -1.0), 1.0)
            width = (math.acos(share) + MARGIN) * per_radian
            first = math.floor(centre - width)
            cells = min(math.floor(centre + width) - first, columns - 1)
            cell = (first + columns // 2) % columns + (group * len(low) + band) * (2 * columns + 1)
            begin, end = start[cell], start[cell + cells + 1]
            if total + end - begin <= len(found):
                for at in range(begin, end):
                    found[total + at - begin] = order[at]
            total += end - begin
            counts[cone] += end - begin
    return total


def _cone(directions: np.ndarray) -> tuple[np.ndarray, float]:
    """A unit vector (3,) float64 in the middle of directions (n, 3) and the largest angle to it [rad]."""
    lit = directions[directions.any(axis=1)].astype(np.float64)
    middle = lit.sum(axis=0)
    length = float(np.sqrt(middle @ middle))
    if not length > 1e-6 * max(1, len(lit)):  # all round, or no ray at all
        return np.array([0.0, 0.0, 1.0]), np.pi
    axis = middle / length
    return axis, float(np.arccos(np.clip(apply(axis[None], lit).min(), -1.0, 1.0)))


def _bands(elevation: np.ndarray) -> np.ndarray:
    """The band of each elevation [deg], numbered upwards; no band is empty."""
    for per_degree in BANDS_PER_DEGREE:
        found, band = np.unique(np.floor((elevation + BAND_EDGE_DEG) * per_degree), return_inverse=True)
        if len(found) <= MOST_BANDS:
            break
    return band


def _cell(azimuth: np.ndarray) -> np.ndarray:
    return np.asarray(np.floor(azimuth), np.int64)


def runs(start: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Every value in the runs start .. start + count - 1, run after run."""
    ends = count.cumsum()
    out = (start - ends + count).repeat(count)
    out += np.arange(len(out))
    return np.asarray(out)
