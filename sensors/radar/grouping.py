"""Values brought together by equal keys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sensors.compiled import compiled

_MIX = np.uint64(0x9E3779B97F4A7C15)
_HIGH = np.uint64(32)


class Groups:
    """Equal keys brought together. Neighbours have mostly one key, so that few keys are looked up."""

    def __init__(self, key: np.ndarray) -> None:
        """key: (k,) integers."""
        found, which = _numbered(key)
        order = np.argsort(found)
        self.keys = found[order]
        """The keys that occur, (n,), rising."""
        place = np.empty(len(order), np.int32)
        place[order] = np.arange(len(order))
        self.which = np.take(place, which)
        """Place in `keys` of each key, (k,) int32."""

    def __len__(self) -> int:
        return len(self.keys)

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Values (n,), one of each key, at all its places (k,)."""
        return np.asarray(np.take(values, self.which))

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Sums (n,) complex128 of values (k,), complex."""
        found = np.zeros(len(self), np.complex128)
        _add(self.which, values, found)
        return found

    def means(self, values: Sequence[np.ndarray], weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sums (n,) float64 of weights (k,), and means (len(values), n) by them of values (k,)."""
        total, found = np.zeros(len(self)), np.zeros((len(values), len(self)))
        _add(self.which, weight, total)
        for row, mean in zip(values, found, strict=True):
            _add_weighted(self.which, row, weight, mean)
        found /= np.maximum(total, 1e-300)
        return total, found


@compiled
def _slot(one: Any, keys: np.ndarray, slots: np.ndarray) -> Any:
    """The slot of a key in a table of open addresses: the one that has its number, or else is free (-1)."""
    last = len(slots) - 1
    at = np.int64((np.uint64(one) * _MIX) >> _HIGH) & last
    while slots[at] >= 0 and keys[slots[at]] != one:
        at = (at + 1) & last
    return at


@compiled
def _numbered(key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The different keys (n,) of (k,) integers, as they come, and the number of each key among them, (k,) int32."""
    runs = 1
    for place in range(1, len(key)):
        runs += key[place] != key[place - 1]
    size = 16
    while size < 2 * runs:
        size *= 2
    slots, keys, which = np.full(size, np.int32(-1)), np.empty(runs, key.dtype), np.empty(len(key), np.int32)
    count, number = 0, np.int32(0)
    for place in range(len(key)):
        one = key[place]
        if place == 0 or key[place - 1] != one:
            at = _slot(one, keys, slots)
            if slots[at] < 0:
                slots[at] = count
                keys[count] = one
                count += 1
            number = slots[at]
        which[place] = number
    return keys[:count].copy(), which


@compiled
def _add(which: np.ndarray, values: np.ndarray, sums: np.ndarray) -> None:
    """Adds values (k,) to the sums (n,) of their groups (k,)."""
    for place in range(len(which)):
        sums[which[place]] += values[place]


@compiled
def _add_weighted(which: np.ndarray, values: np.ndarray, weight: np.ndarray, sums: np.ndarray) -> None:
    """Adds values times weights (k,) to the sums (n,) of their groups (k,)."""
    for place in range(len(which)):
        sums[which[place]] += np.float64(values[place]) * weight[place]
