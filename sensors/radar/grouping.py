"""Values brought together by equal keys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sensors.compiled import compiled, inlined

_MIX = np.uint64(0x9E3779B97F4A7C15)
_HIGH = np.uint64(32)

FEW = 1024
"""Slots of a table that is still nearly empty: so few stay in the cache."""


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

    def means(self, values: np.ndarray | Sequence[np.ndarray], weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sums (n,) float64 of weights (k,), and means (4, n) by them of four values (k,)."""
        sums = np.zeros((5, len(self)))
        _add_weighted(self.which, np.asarray(values, np.float64), np.asarray(weight, np.float64), sums)
        return sums[0], sums[1:] / np.maximum(sums[0], 1e-300)


class Sums(NamedTuple):
    """Powers, and four values weighted by them, added up by key one after the other (`add`); room for n keys.

    slots: (2^m,) int32, a table of open addresses, of which a part is used; -1 where it is free. keys: (n,) int64.
    sums: (n, 5) float64, of the power and of power times value. state: (3,) int64, how many keys there are, the place
    of the latest, and how many slots are used.
    """

    slots: np.ndarray
    keys: np.ndarray
    sums: np.ndarray
    state: np.ndarray

    @classmethod
    def room(cls, most: int) -> Sums:
        """For so many keys, of which none is there yet."""
        slots = np.empty(max(1 << (2 * most).bit_length(), FEW), np.int32)
        slots[:FEW] = -1
        return cls(slots, np.empty(most, np.int64), np.empty((most, 5)), np.array([0, 0, FEW]))

    @classmethod
    def merged(cls, parts: Sequence[Sums], more: int) -> Sums:
        """Several as one, with room for more keys."""
        sums = cls.room(sum(int(part.state[0]) for part in parts) + more)
        for part in parts:
            _merge(sums, part)
        return sums

    @property
    def found(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The keys (m,), their powers (m,) and means (4, m) of their values."""
        count = int(self.state[0])
        sums = self.sums[:count].T
        return self.keys[:count], sums[0], sums[1:] / np.maximum(sums[0], 1e-300)


@inlined
def _slot(one: Any, keys: np.ndarray, slots: np.ndarray, size: Any) -> Any:
    """The slot of a key in a table of open addresses of this size: the one that has its number, or is free (-1)."""
    mask = size - 1
    at = np.int64((np.uint64(one) * _MIX) >> _HIGH) & mask
    while slots[at] >= 0 and keys[slots[at]] != one:
        at = (at + 1) & mask
    return at


@inlined
def _widen(sums: Sums) -> None:
    """Uses twice as many slots."""
    size = 2 * sums.state[2]
    sums.state[2] = size
    for slot in range(size):
        sums.slots[slot] = -1
    for number in range(sums.state[0]):
        sums.slots[_slot(sums.keys[number], sums.keys, sums.slots, size)] = number


@inlined
def _place(sums: Sums, key: Any) -> Any:
    """The place of a key, a new one if it is not there yet."""
    keys, count, at = sums.keys, sums.state[0], sums.state[1]
    if count == 0 or keys[at] != key:  # neighbours have mostly one key
        slot = _slot(key, keys, sums.slots, sums.state[2])
        at = np.int64(sums.slots[slot])
        if at < 0:
            at = count
            sums.slots[slot], keys[at], sums.state[0] = at, key, count + 1
            for axis in range(5):
                sums.sums[at, axis] = 0.0
            if 2 * count > sums.state[2]:
                _widen(sums)
        sums.state[1] = at
    return at


@inlined
def add(sums: Sums, key: Any, power: Any, first: Any, second: Any, third: Any, fourth: Any) -> None:
    """Adds a power and four values to the sums of a key."""
    at, share = _place(sums, key), np.float64(power)
    sums.sums[at, 0] += share
    sums.sums[at, 1] += share * first
    sums.sums[at, 2] += share * second
    sums.sums[at, 3] += share * third
    sums.sums[at, 4] += share * fourth


@compiled
def _merge(sums: Sums, more: Sums) -> None:
    for row in range(more.state[0]):
        at = _place(sums, more.keys[row])
        for axis in range(5):
            sums.sums[at, axis] += more.sums[row, axis]


@compiled(makes_arrays=True)
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
            at = _slot(one, keys, slots, size)
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
def _add_weighted(which: np.ndarray, values: np.ndarray, weight: np.ndarray, sums: np.ndarray) -> None:
    """Adds weights (k,) to the sums (5, n) of their groups (k,), and four values (4, k) times them."""
    for row in range(len(which)):
        group, share = which[row], weight[row]
        sums[0, group] += share
        for axis in range(4):
            sums[1 + axis, group] += share * values[axis, row]
