"""What comes back, put into the cells of a grid, one arrival after the other."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sensors.compiled import compiled, inlined

from .cells import Along
from .grouping import Sums, add

Ends = tuple[float, float]


class Bins(NamedTuple):
    """The cells of a grid (`Grid`), for loops over arrivals.

    range_m, velocity, azimuth, height: the cells along each axis. sides, levels: the ends within which the sines of
    azimuth and elevation are. meet: whether the first cell of azimuth, and of elevation, is also that of the other end.
    folds: whether sines beyond the ends come in again on the other side; wraps: whether ranges do. coupling: how many
    metres a range grows with each m/s, and m/s a velocity with each metre.
    """

    range_m: Along
    velocity: Along
    azimuth: Along
    height: Along
    sides: Ends
    levels: Ends
    meet: tuple[bool, bool]
    folds: bool
    wraps: bool
    coupling: tuple[float, float]


@inlined
def _folded(value: Any, low: float, high: float) -> Any:
    return (value - low) % (high - low) + low


@inlined
def whole(value: Any) -> Any:
    """The greatest whole number up to a value: `math.floor` calls a function on plain processors."""
    number = np.int64(value)
    return number - (value < number)


@inlined
def angle_cell(bins: Bins, azimuth: Any, height: Any) -> Any:
    """The number of the angle cell of sines of azimuth and elevation, -1 outside the grid; and the sines, folded."""
    (left, wide, columns), (lowest, tall, rows) = bins.azimuth, bins.height
    side, level = np.float64(azimuth), np.float64(height)
    if bins.folds:
        side = _folded(side, bins.sides[0], bins.sides[1])
        level = _folded(level, bins.levels[0], bins.levels[1])
    if not (bins.sides[0] <= side < bins.sides[1] and bins.levels[0] <= level < bins.levels[1]):
        return -1, side, level
    across, up = whole((side - left) / wide), whole((level - lowest) / tall)
    across = across % columns if bins.meet[0] else min(across, columns - 1)
    up = up % rows if bins.meet[1] else min(up, rows - 1)
    return across * rows + up, side, level


@inlined
def place(bins: Bins, range_m: Any, velocity: Any, angle: Any) -> Any:
    """The number of the cell of a range [m], a velocity [m/s] and an angle cell, -1 outside the grid; and the range and
    the velocity, folded.
    """
    (nearest, long, far), (slowest, wide, fast) = bins.range_m, bins.velocity
    farther, faster = bins.coupling
    away, rate = range_m + farther * velocity, velocity + faster * range_m
    if bins.wraps:
        away %= nearest + far * long
    limit = slowest + fast * wide
    if abs(rate) >= limit:
        rate = _folded(rate, -limit, limit)
    at = whole((away - nearest) / long)
    if angle < 0 or not 0 <= at < far:
        return -1, away, rate
    turn = min(max(whole((rate - slowest) / wide), 0), fast - 1)
    angles = bins.azimuth[2] * bins.height[2]
    return (turn * far + at) * angles + angle, away, rate


@inlined
def put(bins: Bins, sums: Sums, range_m: Any, velocity: Any, azimuth: Any, height: Any, angle: Any, power: Any) -> None:
    """Adds an arrival to the power of its cell, if it is in the grid; angle: the angle cell of its sines."""
    if bins.folds:
        _, azimuth, height = angle_cell(bins, azimuth, height)
    cell, range_m, velocity = place(bins, range_m, velocity, angle)
    if cell >= 0:
        add(sums, cell, power, range_m, velocity, azimuth, height)


@compiled
def put_all(bins: Bins, sums: Sums, values: np.ndarray, power: np.ndarray) -> None:
    """Adds arrivals (k,) to the powers of their cells; values: (4, k), ranges, velocities and sines."""
    for row in range(len(power)):
        angle, azimuth, height = angle_cell(bins, np.float64(values[2, row]), np.float64(values[3, row]))
        cell, range_m, velocity = place(bins, np.float64(values[0, row]), np.float64(values[1, row]), np.int64(angle))
        if cell >= 0:
            add(sums, cell, power[row], range_m, velocity, azimuth, height)


@compiled
def angle_cells(bins: Bins, azimuth: np.ndarray, height: np.ndarray, cells: np.ndarray) -> None:
    """Writes the numbers of the angle cells of sines (k,), -1 outside the grid."""
    for row in range(len(cells)):
        cells[row], _, _ = angle_cell(bins, np.float64(azimuth[row]), np.float64(height[row]))
