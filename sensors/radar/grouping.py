"""Values brought together by equal keys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


class Groups:
    """Equal keys brought together: neighbours first, so that only one key of a run is sorted.

    What neighbouring rays meet has mostly one key, so runs are long.
    """

    def __init__(self, key: np.ndarray) -> None:
        """key: (k,) of any sortable dtype."""
        differs = np.ones(len(key), bool)
        np.not_equal(key[1:], key[:-1], out=differs[1:])
        self._starts = np.flatnonzero(differs)
        self._length = len(key)
        self.keys, self._run = np.unique(key[self._starts], return_inverse=True)
        """The keys that occur, (n,), rising."""

    def __len__(self) -> int:
        return len(self.keys)

    @property
    def which(self) -> np.ndarray:
        """Place in `keys` of each key, (k,) int64."""
        return self.spread(np.arange(len(self.keys)))

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Values (n,), one of each key, at all its places (k,)."""
        return np.repeat(values[self._run], np.diff(self._starts, append=self._length))

    def sums(self, values: np.ndarray, within: type[np.complexfloating[Any, Any]] | None = None) -> list[np.ndarray]:
        """Sums (n,) float64 of the real and the imaginary parts of values (k,).

        within: the type to sum runs in, where their parts cancel; None: that of the values.
        """
        if not self._length:
            return [np.zeros(0), np.zeros(0)]
        runs = np.add.reduceat(values, self._starts, dtype=within)
        return [np.bincount(self._run, part, len(self.keys)) for part in (runs.real, runs.imag)]

    def means(self, values: Sequence[np.ndarray], weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sums (n,) float64 of weights (k,), and means (len(values), n) by them of values (k,)."""
        found = np.empty((len(values), len(self)))
        varying = []
        for place, row in enumerate(values):
            if row.strides[0]:
                varying.append(place)
            else:  # one value for all
                found[place] = row[0] if len(row) else 0.0
        total, *sums = self._weighted([None, *(values[place] for place in varying)], weight)
        for place, one in zip(varying, sums, strict=True):
            np.divide(one, np.maximum(total, 1e-300), out=found[place])
        return total, found

    def _weighted(self, values: Sequence[np.ndarray | None], weight: np.ndarray) -> list[np.ndarray]:
        """Sums (n,) of values (k,) times weights; None is 1. Two at once: a run costs more than its length."""
        found: list[np.ndarray] = []
        both = np.empty(len(weight), np.result_type(weight, np.complex64))
        both.imag = 0.0
        for first in range(0, len(values), 2):
            for row, part in zip(values[first : first + 2], (both.real, both.imag), strict=False):
                if row is None:
                    part[:] = weight
                else:
                    np.multiply(row, weight, out=part, casting="same_kind")
            found += self.sums(both)
        return found[: len(values)]
