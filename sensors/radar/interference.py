"""Fields and powers of one group, of a face, a corner or a curved surface, within what a radar resolves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .grouping import Groups
from .scattering import Arrivals

ZONES = 8.0
"""Fresnel zones across which fields of one face add up at least."""

FLAT_TOP = 0.35
"""Share of a cell's size from its middle within which fields belong to it alone."""

_MIX = np.uint64(0xC2B2AE3D27D4EB4F)


def added(
    found: Arrivals, values: Sequence[np.ndarray], widths: Sequence[float]
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Powers (m,) and values (4 of (m,)) of fields that add up: in each group all that lie within a cell's size.

    values: range, velocity, sines of azimuth and elevation, (k,) each; widths: of the cells of each. Sizes are counted
    from the middle of the group, not from the edges of cells: a target that the radar does not resolve is one, wherever
    it is. In angle they are at least `ZONES` Fresnel zones, which a mirror reflection needs to form, and neighbours
    share what lies between them, so that no edge is made where none is.
    """
    assert found.field is not None
    assert found.group is not None
    assert found.zone is not None
    field = found.field
    groups = Groups(found.group)
    _, middle = groups.means(values, found.power)
    away = [row - groups.spread(mean) for row, mean in zip(values, middle.astype(np.float32), strict=True)]
    key = groups.which.astype(np.uint64)
    for width, offset in zip(widths[:2], away[:2], strict=True):
        key = _joined(key, np.rint(offset / width))
    row: np.ndarray | None = None  # None: one after the other
    zones = np.float32(ZONES) * found.zone
    for width, offset in zip(widths[2:], away[2:], strict=True):
        key, row, field = _shared(key, row, field, offset / np.maximum(zones, np.float32(width)))
    groups = Groups(key)
    real, imaginary = groups.sums(field, np.complex128)
    squared = real**2 + imaginary**2
    # Where a face reflects as a mirror, the fields that do not cancel tell the place; else the strongest do.
    power = field.real**2 + field.imag**2
    least = np.maximum(squared, 1e-300)
    share = field.real * groups.spread(real / least) + field.imag * groups.spread(imaginary / least)
    if row is not None:
        values = [each if each.strides[0] == 0 else np.take(each, row) for each in values]
    (_, means), (_, places) = groups.means(values, power), groups.means(values, share)
    near = np.abs(places - means) < np.array(widths)[:, None] / 2
    return squared, list(np.where(near, places, means))


def gathered(
    found: Arrivals, values: Sequence[np.ndarray], widths: Sequence[float]
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Powers (m,) and values (4 of (m,)) of powers that add up: in each group all that lie within a cell's size.

    As `added`: a curved target that the radar does not resolve is one, also on the edge of a cell.
    """
    assert found.group is not None
    groups = Groups(found.group)
    _, middle = groups.means(values, found.power)
    key = groups.which.astype(np.uint64)
    for width, row, mean in zip(widths, values, middle, strict=True):
        key = _joined(key, np.rint((row - groups.spread(mean)) / width))
    total, means = Groups(key).means(values, found.power)
    return total, list(means)


def _shared(
    key: np.ndarray, row: np.ndarray | None, field: np.ndarray, place: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
    """Fields by whole places; what lies far from one goes to both neighbours, with weights that add up to 1.

    row: of each, in `place`; None: one after the other.
    """
    if row is not None:
        place = np.take(place, row)
    whole = np.rint(place)
    off = place - whole
    some = np.flatnonzero(np.abs(off) > FLAT_TOP)
    if not len(some):
        return _joined(key, whole), row, field
    beside = np.clip((np.abs(off[some]) - FLAT_TOP) / (1.0 - 2.0 * FLAT_TOP), 0.0, 0.5)
    weight = np.sin(np.pi / 2 * beside) ** 2
    given = field[some] * weight.astype(np.float32)
    kept = field.copy()
    kept[some] -= given
    shared = some if row is None else row[some]
    places = np.concatenate((whole, whole[some] + np.sign(off[some])))
    return (
        _joined(np.concatenate((key, key[some])), places),
        np.concatenate((np.arange(len(field)) if row is None else row, shared)),
        np.concatenate((kept, given)),
    )


def _joined(key: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Keys of what has equal keys and equal whole numbers; the keys themselves where all numbers are 0."""
    if not number.any():
        return key
    key = (key ^ number.astype(np.int64).view(np.uint64)) * _MIX
    return np.asarray(key ^ (key >> np.uint64(29)))
