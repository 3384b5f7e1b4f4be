"""Constant false alarm rate detection by cell averaging, in any number of dimensions.

A cell is detected where its power exceeds a factor times the mean power of its training cells: those within `training`
cells beyond the `guard` cells around it, on every side. At an edge the cells that exist are averaged; axes that wrap
(velocity; the sine of angles of an aliasing array) have no edge. Richards, Fundamentals of Radar Signal Processing,
chapter 6.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sensors.compiled import compiled, inlined

MOST_PAIRS = 2_000_000
"""Pairs of cells that are looked at together."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of the window: training and guard cells on each side, and whether its ends meet."""

    training: int
    guard: int = 0
    wraps: bool = False


def noise_level(power: np.ndarray, axes: Sequence[Axis]) -> np.ndarray:
    """Mean power of each cell's training cells, float64 of the shape of `power`; 0 for a cell without any.

    A window longer than an axis that wraps counts each cell once.
    """
    outer = [axis.training + axis.guard for axis in axes]
    inner = [axis.guard for axis in axes]
    total = _boxes(power, outer, axes) - _boxes(power, inner, axes)
    total /= _training_cells_each(power.shape, tuple(axes))
    return np.asarray(np.maximum(total, 0.0, out=total))


def detect(power: np.ndarray, axes: Sequence[Axis], *, factor: float, least: float = 0.0) -> np.ndarray:
    """Which cells are detected, bool of the shape of `power`: above factor x noise level and not below `least`."""
    answer: np.ndarray = (power > factor * noise_level(power, axes)) & (power >= least)
    return answer


def noise_level_at(power: np.ndarray, cells: np.ndarray, axes: Sequence[Axis]) -> np.ndarray:
    """`noise_level` at some cells (k, 2) of an array of two axes, (k,)."""
    first, second = axes
    level = np.empty(len(cells))
    outer, inner = ((first.guard + more * first.training, second.guard + more * second.training) for more in (1, 0))
    _levels(power, cells, outer, inner, (first.wraps, second.wraps), level)
    return level


@inlined
def _span(at: int, half: int, length: int, wraps: bool) -> tuple[int, int]:
    """The first cell and the number of those within `half` of one; cells beyond the end begin at 0."""
    if not wraps:
        first = max(at - half, 0)
        return first, min(at + half + 1, length) - first
    return (0, length) if 2 * half + 1 >= length else ((at - half) % length, 2 * half + 1)


@inlined
def _box(power: np.ndarray, at: tuple[int, int], half: tuple[int, int], wraps: tuple[bool, bool]) -> tuple[float, int]:
    """Sum over the box of a cell, and how many cells it has."""
    rows, columns = power.shape
    (top, tall), (left, wide) = _span(at[0], half[0], rows, wraps[0]), _span(at[1], half[1], columns, wraps[1])
    total = 0.0
    for row in range(top, top + tall):
        for column in range(left, left + wide):
            total += power[row if row < rows else row - rows, column if column < columns else column - columns]
    return total, tall * wide


@compiled
def _levels(
    power: np.ndarray,
    cells: np.ndarray,
    outer: tuple[int, int],
    inner: tuple[int, int],
    wraps: tuple[bool, bool],
    level: np.ndarray,
) -> None:
    """Writes the mean power of the training cells of some cells (k, 2): those in the outer, not in the inner box."""
    for number in range(len(cells)):
        at = cells[number, 0], cells[number, 1]
        (total, count), (own, guards) = _box(power, at, outer, wraps), _box(power, at, inner, wraps)
        level[number] = max(total - own, 0.0) / max(count - guards, 1)


def _boxes(values: np.ndarray, halves: Sequence[int], axes: Sequence[Axis]) -> np.ndarray:
    """Sum over the box of each cell, axis by axis."""
    result = np.asarray(values, np.float64)
    if not any(halves):
        return result
    for number, (half, axis) in enumerate(zip(halves, axes, strict=True)):
        length = result.shape[number]
        if axis.wraps and 2 * half + 1 < length:
            ends = (slice(length - half, None), slice(0, half))
            before, after = (result[(slice(None),) * number + (end,)] for end in ends)
            padded = np.concatenate((before, result, after), axis=number) if half else result
            first, last = np.arange(length), np.arange(length) + 2 * half + 1
        elif axis.wraps:
            padded, first, last = result, np.zeros(length, int), np.full(length, length)
        else:
            cells = np.arange(length)
            padded, first, last = result, np.maximum(cells - half, 0), np.minimum(cells + half + 1, length)
        zero = np.zeros_like(np.take(padded, [0], axis=number))
        sums = np.concatenate((zero, np.cumsum(padded, axis=number)), axis=number)
        result = np.take(sums, last, axis=number) - np.take(sums, first, axis=number)
    return result


@functools.lru_cache(maxsize=8)
def _training_cells_each(shape: tuple[int, ...], axes: tuple[Axis, ...]) -> np.ndarray:
    """How many training cells each cell has, 1 for none; int64 of this shape."""
    outer, inner = ([axis.guard + more * axis.training for axis in axes] for more in (1, 0))
    found = np.maximum(_box_sizes(shape, outer, axes) - _box_sizes(shape, inner, axes), 1)
    found.flags.writeable = False
    return np.asarray(found)


def _box_sizes(shape: Sequence[int], halves: Sequence[int], axes: Sequence[Axis]) -> np.ndarray:
    """How many cells the box of each cell holds, int64."""
    sizes = np.ones((1,) * len(shape), np.int64)
    for number, (length, half, axis) in enumerate(zip(shape, halves, axes, strict=True)):
        cells = np.arange(length)
        along = np.minimum(cells + half, length - 1) - np.maximum(cells - half, 0) + 1
        if axis.wraps:
            along = np.full(length, min(2 * half + 1, length))
        sizes = sizes * along.reshape([-1 if each == number else 1 for each in range(len(shape))])
    return sizes


def sparse_noise_level(cells: np.ndarray, power: np.ndarray, shape: Sequence[int], axes: Sequence[Axis]) -> np.ndarray:
    """`noise_level` at the cells (k,) of an array of this shape, of two axes or more, that is 0 elsewhere.

    cells: (k,) int64, rising, numbers in C order. Windows longer than an axis that wraps count a cell once. Neighbours
    along the last axes lie side by side in the list, so that each step along the first ones looks at a run of it.
    """
    index = np.stack(np.unravel_index(cells, shape))
    outer, inner = [a.training + a.guard for a in axes], [a.guard for a in axes]
    last = max(1, len(shape) - 2)
    rest, length = math.prod(shape[last + 1 :]), shape[last]
    low = np.maximum(index[last] - outer[last], 0)
    high = np.minimum(index[last] + outer[last], length - 1) + 1
    if axes[last].wraps:
        low, high = np.zeros_like(low), np.full_like(high, length)
    total = np.zeros(len(cells))
    ways = [_steps(axis, half, size) for axis, half, size in zip(axes[:last], outer, shape, strict=False)]
    for steps in itertools.product(*ways):
        inside, before = np.ones(len(cells), bool), np.zeros(len(cells), np.int64)
        guarded = True
        for step, place, axis, size, guard in zip(steps, index, axes, shape, inner, strict=False):
            at = (place + step) % size if axis.wraps else place + step
            inside &= (at >= 0) & (at < size)
            before = before * size + at
            guarded &= (min(step % size, -step % size) if axis.wraps else abs(step)) <= guard
        begin, end = (np.searchsorted(cells, (before * length + ends) * rest) for ends in (low, high))
        counts = np.where(inside, end - begin, 0)
        share = np.cumsum(counts) // MOST_PAIRS
        for rows in np.split(np.arange(len(cells)), np.flatnonzero(np.diff(share)) + 1):
            one = np.repeat(rows, counts[rows])
            two = np.arange(len(one)) + np.repeat(begin[rows] - np.cumsum(counts[rows]) + counts[rows], counts[rows])
            near, own = np.ones(len(one), bool), np.full(len(one), guarded)
            for place, axis, size, wide, guard in list(zip(index, axes, shape, outer, inner, strict=True))[last:]:
                away = np.abs(place[one] - place[two])
                if axis.wraps:
                    away = np.minimum(away, size - away)
                near &= away <= wide
                own &= away <= guard
            near &= ~own
            total += np.bincount(one[near], power[two[near]], len(cells))
    return np.asarray(total / np.maximum(_counts(index, shape, axes), 1.0))


def _steps(axis: Axis, half: int, size: int) -> range:
    """The steps along an axis within a window, each cell once."""
    if axis.wraps and 2 * half + 1 >= size:
        return range(size)
    return range(-min(half, size - 1), min(half, size - 1) + 1)


def _counts(index: np.ndarray, shape: Sequence[int], axes: Sequence[Axis]) -> np.ndarray:
    """How many training cells each cell (4, k) has."""
    outer = inner = np.ones(index.shape[1])
    for row, axis, length in zip(index, axes, shape, strict=True):
        sizes = []
        for half in (axis.training + axis.guard, axis.guard):
            if axis.wraps:
                sizes.append(np.full(len(row), min(2 * half + 1, length)))
            else:
                sizes.append(np.minimum(row + half, length - 1) - np.maximum(row - half, 0) + 1)
        outer, inner = outer * sizes[0], inner * sizes[1]
    return np.asarray(outer - inner)
