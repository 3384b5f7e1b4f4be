"""Cells of a radar's measurement: range, folded velocity, and angles evenly in the sine."""

from __future__ import annotations

import math

import numpy as np

from graph.base.records import dataclass

Along = tuple[float, float, int]
"""Lowest value, width of a cell, and count."""


@dataclass(frozen=True, slots=True)
class Cells:
    """Equal cells from `low` to `high`; values are in the unit of the axis (m, m/s, or the sine of an angle)."""

    low: float
    high: float
    count: int

    @classmethod
    def of_resolution(cls, low: float, high: float, resolution: float) -> Cells:
        """As many cells of one resolution as cover low to high; the last may reach beyond it."""
        count = max(1, math.ceil((high - low) / resolution - 1e-9))
        return cls(low, low + count * resolution, count)

    @property
    def width(self) -> float:
        """Width of a cell."""
        return (self.high - self.low) / self.count

    @property
    def along(self) -> Along:
        """The cells for loops over values."""
        return self.low, self.width, self.count

    def centre(self, index: np.ndarray) -> np.ndarray:
        """Value in the middle of each cell, float64."""
        answer: np.ndarray = self.low + (np.asarray(index, np.float64) + 0.5) * self.width
        return answer
