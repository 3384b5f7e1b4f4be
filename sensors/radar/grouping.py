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
        """key: (k,) int64 or uint64."""
        keys, self.which = _numbered(key.view(np.int64))
        """Place in `keys` of each key, (k,) int32."""
        self.keys = keys.view(key.dtype)
        """The keys that occur, (n,), as they come first."""

    def __len__(self) -> int:
        return len(self.keys)

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Sums (n,) complex128 of values (k,), complex."""
        found = np.zeros(len(self), np.complex128)
        _add(self.which, values, found)
        return found

    def means(self, values: Sequence[np.ndarray], weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sums (n,) float64 of weights (k,), and means (4, n) by them of four values (k,)."""
        total, means = np.zeros(len(self)), np.zeros((len(self), 4))
        first, second, third, fourth = values
        _add_weighted(self.which, first, second, third, fourth, weight, total, means)
        return total, means.T / np.maximum(total, 1e-300)


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
    """The different keys (n,) of (k,) int64, as they come, and the number of each key among them, (k,) int32."""
    runs = 1
    for place in range(1, len(key)):
        runs += key[place] != key[place - 1]
    size = 16
    while size < 2 * runs:
        size *= 2
    slots, keys, which = np.full(size, np.int32(-1)), np.empty(runs, np.int64), np.empty(len(key), np.int32)
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
    for row in range(len(which)):
        sums[which[row]] += values[row]


@compiled
def _add_weighted(
    which: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
    third: np.ndarray,
    fourth: np.ndarray,
    weight: np.ndarray,
    total: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Adds weights (k,) to the totals (n,) of their groups (k,), and four values (k,) times them to the sums (n, 4)."""
    for row in range(len(which)):
        group, share = which[row], np.float64(weight[row])
        total[group] += share
        sums[group, 0] += share * first[row]
        sums[group, 1] += share * second[row]
        sums[group, 2] += share * third[row]
        sums[group, 3] += share * fourth[row]
