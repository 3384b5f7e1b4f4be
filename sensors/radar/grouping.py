"""Values brought together by equal keys."""

from __future__ import annotations

from collections.abc import Sequence

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
        return np.repeat(self._run, np.diff(self._starts, append=self._length))

    def sum(self, values: np.ndarray) -> np.ndarray:
        """Sums (n,) float64 of values (k,)."""
        if not self._length:
            return np.zeros(0)
        return np.bincount(self._run, np.add.reduceat(values, self._starts, dtype=np.float64), len(self.keys))

    def means(self, values: Sequence[np.ndarray], weight: np.ndarray, total: np.ndarray) -> np.ndarray:
        """Means (len(values), n) float64 of values (k,) by weight (k,), whose sums are total (n,)."""
        found = np.empty((len(values), len(self)))
        for row, out in zip(values, found, strict=True):
            if row.strides[0] == 0:  # one value for all
                out[:] = row[0] if len(row) else 0.0
            else:
                np.divide(self.sum(row * weight), np.maximum(total, 1e-300), out=out)
        return found
