"""The rays of a radar: a fan over its field of view, and finer ones over what is small in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sensors.compiled import compiled, inlined

from .antenna import Antenna

FEW = 400
"""A mesh that fewer rays of the fan may meet gets rays of its own."""

MOST_EACH = 16_384
LEAST_EACH = 64


@dataclass(frozen=True, slots=True)
class Sampling:
    """How many rays a scan has.

    rays: about how many the fan has, None for what the radar says. stride: after a reflection every so many of them are
    followed on, across and up: what is far off by then is small, or has rays of its own. share: all meshes that get
    rays of their own have at most one for so many of the fan. neighbours: whether four rays of the fan on one flat
    patch tell what the radar sees between them (`sight.looks`), else a ray of its own does for each place.
    """

    rays: int | None = None
    stride: int = 2
    share: int = 8
    neighbours: bool = True


class Tubes(NamedTuple):
    """Rays as tubes that fill a solid angle, in the sensor frame; n of them.

    directions: (3, n) float64 unit. azimuth, elevation: (n,) sines of the angles. width, height: (n,) angles across and
    up [rad]. solid: (n,) solid angles [sr]. sends, hears: (n,) gains of the antennas along the rays. weight: (n,)
    solid x sends x hears. wide: (n,) how many tubes across, and up, each stands for once it was reflected. leads: (n,)
    bool, those that are followed then. angle: (n,) int32, the angle cells (`Grid.angles`). What is not said is float32.
    """

    directions: np.ndarray
    azimuth: np.ndarray
    elevation: np.ndarray
    width: np.ndarray
    height: np.ndarray
    solid: np.ndarray
    sends: np.ndarray
    hears: np.ndarray
    weight: np.ndarray
    wide: np.ndarray
    leads: np.ndarray
    angle: np.ndarray

    @classmethod
    def room(cls, count: int) -> Tubes:
        """Arrays for so many, to be filled (`fill`)."""
        kinds = [*[np.float32] * (len(cls._fields) - 3), np.bool_, np.int32]
        return cls(np.empty((3, count)), *(np.empty(count, kind) for kind in kinds))

    def part(self, first: int, end: int) -> Tubes:
        """Some of them; the arrays are parts of these."""
        return Tubes(*(each[..., first:end] for each in self))


@inlined
def angles_of(tubes: Tubes, row: Any) -> tuple[Any, Any, Any]:
    """Sines of azimuth and elevation of a tube, and its angle cell."""
    return np.float64(tubes.azimuth[row]), np.float64(tubes.elevation[row]), np.int64(tubes.angle[row])


def fill(
    tubes: Tubes,
    azimuth: tuple[float, float],
    elevation: tuple[float, float],
    across: int,
    antenna: Antenna,
    *,
    stride: int = 1,
) -> None:
    """Makes tubes, `across` in a row, of equal steps of azimuth and elevation [rad] between two ends.

    The middle of each step is a ray. stride: every so many are followed after a reflection, across and up.
    """
    up = len(tubes.solid) // across
    da, de = (azimuth[1] - azimuth[0]) / across, (elevation[1] - elevation[0]) / up
    a = azimuth[0] + (np.arange(across) + 0.5) * da
    e = elevation[0] + (np.arange(up) + 0.5) * de
    solid = da * (np.sin(e + de / 2) - np.sin(e - de / 2))
    lines, rows = (np.cos(a), np.sin(a)), (np.cos(e), np.sin(e), solid)
    _fill(lines, rows, da, de, stride, tubes)
    tubes.sends[:], tubes.hears[:] = antenna.gains(tubes.directions)
    np.multiply(tubes.solid, tubes.sends, out=tubes.weight)
    np.multiply(tubes.weight, tubes.hears, out=tubes.weight)


@compiled
def _fill(
    columns: tuple[np.ndarray, np.ndarray],
    rows: tuple[np.ndarray, np.ndarray, np.ndarray],
    da: float,
    de: float,
    stride: int,
    tubes: Tubes,
) -> None:
    """Writes tubes, but for gains and weights, row by row; columns: cosines and sines of azimuths, rows: those of
    elevations, and solid angles.
    """
    (ahead, side), (level, high, angle) = columns, rows
    at = 0
    for row in range(len(level)):
        for column in range(len(ahead)):
            tubes.directions[0, at] = level[row] * ahead[column]
            tubes.directions[1, at] = level[row] * side[column]
            tubes.directions[2, at] = high[row]
            tubes.azimuth[at], tubes.elevation[at], tubes.solid[at] = side[column], high[row], angle[row]
            tubes.width[at], tubes.height[at] = da * level[row], de
            tubes.wide[at], tubes.leads[at] = stride, row % stride == 0 and column % stride == 0
            at += 1


def windows(
    corners: np.ndarray, azimuth_limit: float, elevations: tuple[float, float], step: float, reach: float
) -> list[tuple[int, tuple[float, float], tuple[float, float]]]:
    """(number, azimuths, elevations) of the boxes that few rays of a fan meet, nearest first.

    corners: (s, 8, 3) float64 in the sensor frame [m]; NaN for what has no box. step: the fan's [rad].
    """
    x, y, z = np.moveaxis(corners, 2, 0)
    level = np.hypot(x, y)
    with np.errstate(invalid="ignore"):
        azimuth, elevation = np.arctan2(y, x), np.arctan2(z, level)
        ahead = (x.min(axis=1) > 0) & (level.min(axis=1) > 0)
        near = np.sqrt((corners.mean(axis=1) ** 2).sum(axis=1))
    low_a, high_a = (np.clip(f(azimuth, axis=1), -azimuth_limit, azimuth_limit) for f in (np.min, np.max))
    low_e, high_e = (np.clip(f(elevation, axis=1), *elevations) for f in (np.min, np.max))
    wide, tall = high_a - low_a, high_e - low_e
    chosen = ahead & (wide > 0) & (tall > 0) & (wide * tall < FEW * step**2) & (near < reach)
    order = np.flatnonzero(chosen)
    order = order[np.argsort(near[order], kind="stable")]
    return [(int(i), (float(low_a[i]), float(high_a[i])), (float(low_e[i]), float(high_e[i]))) for i in order]


def finer(
    found: list[tuple[int, tuple[float, float], tuple[float, float]]],
    tubes: Tubes,
    rays: int,
    antenna: Antenna,
    share: int,
) -> np.ndarray | None:
    """Fills tubes, after the first `rays` of the fan, with a grid over each window, of square steps as far as whole
    numbers of them allow; gives the numbers (n,) int32 of the windows of its rays, None for no window.

    Windows beyond their share (`Sampling`) are left out, and keep the rays of the fan.
    """
    budget = rays // share
    found = found[: max(0, budget // LEAST_EACH)]
    if not found:
        return None
    each = min(MOST_EACH, budget // len(found))
    counts, first = [], rays
    for _, azimuth, elevation in found:
        wide, tall = azimuth[1] - azimuth[0], elevation[1] - elevation[0]
        across = int(np.clip(round(float(np.sqrt(each * wide / tall))), 1, each))
        counts.append(across * max(1, each // across))
        fill(tubes.part(first, first + counts[-1]), azimuth, elevation, across, antenna)
        first += counts[-1]
    return np.repeat(np.array([number for number, *_ in found], np.int32), counts)
