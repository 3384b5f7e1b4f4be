"""Fields and powers of one group, of a face, a corner or a curved surface, within what a radar resolves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from sensors.compiled import compiled, inlined

from .grouping import Groups
from .scattering import Arrivals

ZONES = 8.0
"""Fresnel zones across which fields of one face add up at least."""

FLAT_TOP = 0.35
"""Share of a cell's size from its middle within which fields belong to it alone."""

_MIX = np.uint64(0xC2B2AE3D27D4EB4F)
_HIGH = np.uint64(29)


def added(found: Arrivals, widths: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Powers (m,) and values (4, m) of fields that add up: in each group all that lie within a cell's size.

    widths: of the cells of range, velocity, sines of azimuth and elevation. Sizes are counted from the middle of the
    group, not from the edges of cells: a target that the radar does not resolve is one, wherever it is. In angle they
    are at least `ZONES` Fresnel zones, which a mirror reflection needs to form, and neighbours share what lies between
    them, so that no edge is made where none is.
    """
    assert found.field is not None
    assert found.zone is not None
    which, middle = _in_groups(found)
    key, row, weight = _cells(which, middle, found.values, ZONES * found.zone, tuple(widths), FLAT_TOP)
    groups, field = Groups(key), np.take(found.field, row) * weight
    sums = groups.sums(field)
    squared = sums.real**2 + sums.imag**2
    # Where a face reflects as a mirror, the fields that do not cancel tell the place; else the strongest do.
    means, places = np.zeros((2, 5, len(groups)))
    _add_places(groups.which, row, found.values, field, sums / np.maximum(squared, 1e-300), means, places)
    means, places = (each[1:] / np.maximum(each[0], 1e-300) for each in (means, places))
    near = np.abs(places - means) < np.array(widths)[:, None] / 2
    return squared, np.where(near, places, means)


def gathered(found: Arrivals, widths: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Powers (m,) and values (4, m) of powers that add up: in each group all that lie within a cell's size.

    As `added`: a curved target that the radar does not resolve is one, also on the edge of a cell.
    """
    nowhere = np.zeros_like(found.power)
    which, middle = _in_groups(found)
    key, *_ = _cells(which, middle, found.values, nowhere, tuple(widths), 1.0)
    return Groups(key).means(found.values, found.power)


def _in_groups(found: Arrivals) -> tuple[np.ndarray, np.ndarray]:
    """The group (k,) of each, by number, and the middles (4, n) of the groups."""
    groups = Groups(found.group)
    return groups.which, groups.means(found.values, found.power)[1]


@inlined
def _joined(key: Any, number: float) -> Any:
    """A key for both a key and a whole number."""
    key = (key ^ np.uint64(np.int64(number))) * _MIX
    return key ^ (key >> _HIGH)


@inlined
def _beside(place: float, flat_top: float) -> tuple[float, float]:
    """The whole number beside a place, and its share of what is there: 0 within `flat_top` of the nearest one."""
    whole = np.rint(place)
    off = place - whole
    if abs(off) <= flat_top:
        return whole, 0.0
    near = min((abs(off) - flat_top) / (1.0 - 2.0 * flat_top), 0.5)
    return whole + math.copysign(1.0, off), math.sin(math.pi / 2.0 * near) ** 2


@compiled(makes_arrays=True)
def _cells(
    which: np.ndarray,
    middle: np.ndarray,
    values: np.ndarray,
    least: np.ndarray,
    widths: tuple[float, ...],
    flat_top: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Keys (m,) uint64 of the cells about the middles (4, n) of their groups (k,) in which values (4, k) lie, with
    their rows (m,) and the shares (m,) float32 that belong there: up to four of each row, of the two angles.

    widths: of the four; least: (k,) of the angles' cells.
    """
    keys = np.empty(4 * len(which), np.uint64)
    rows = np.empty(4 * len(which), np.int64)
    shares = np.empty(4 * len(which), np.float32)
    count = 0
    for row in range(len(which)):
        group = which[row]
        key = _joined(_joined(np.uint64(0), group), np.rint((values[0, row] - middle[0, group]) / widths[0]))
        key = _joined(key, np.rint((values[1, row] - middle[1, group]) / widths[1]))
        across = (values[2, row] - middle[2, group]) / max(least[row], widths[2])
        up = (values[3, row] - middle[3, group]) / max(least[row], widths[3])
        side, aside = _beside(across, flat_top)
        above, over = _beside(up, flat_top)
        for place, share in ((np.rint(across), 1.0 - aside), (side, aside)):
            if share > 0.0:
                column = _joined(key, place)
                for level, part in ((np.rint(up), 1.0 - over), (above, over)):
                    if part > 0.0:
                        keys[count], rows[count], shares[count] = _joined(column, level), row, share * part
                        count += 1
    return keys[:count], rows[:count], shares[:count]


@compiled
def _add_places(
    which: np.ndarray,
    rows: np.ndarray,
    values: np.ndarray,
    field: np.ndarray,
    part: np.ndarray,
    means: np.ndarray,
    places: np.ndarray,
) -> None:
    """Adds to the sums (5, n) of groups the weights of fields (m,), and the values (4, k) of their rows times these.

    Weights are the power of a field, for `means`, and its share of the group's sum, for `places`; part: (n,), the sum
    over its power.
    """
    for at in range(len(which)):
        group, row, one, whole = which[at], rows[at], field[at], part[which[at]]
        power = one.real * one.real + one.imag * one.imag
        share = one.real * whole.real + one.imag * whole.imag
        means[0, group] += power
        places[0, group] += share
        for axis in range(4):
            means[1 + axis, group] += power * values[axis, row]
            places[1 + axis, group] += share * values[axis, row]
