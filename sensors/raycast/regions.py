"""Which standing surfaces lie within the reach of rays; the others stay out of the scene that the rays are cast at."""

from __future__ import annotations

import math

import numpy as np

CELLS = 4
"""How many sides of a cell of space make the power of two below the reach. A sensor that moves gets another scene in
another cell only, and its reach is rounded up to whole sides; so its scene depends on nothing but its place.
"""
MOST_CELLS = 4096
"""Cells whose surfaces are remembered."""


class Regions:
    """The boxes around m surfaces, (m, 2, 3) float64 world [m]: the least and the greatest coordinates."""

    def __init__(self, boxes: np.ndarray) -> None:
        self._boxes = boxes
        whole = boxes[:, 0].min(axis=0, initial=np.inf), boxes[:, 1].max(axis=0, initial=-np.inf)
        self._low, self._high = (tuple(map(float, ends)) for ends in whole)
        self._known: dict[tuple[float, ...], bytes | None] = {}

    def within(self, origin: np.ndarray, reach: float) -> bytes | None:
        """Which surfaces may be hit within `reach` [m] of any place in the cell of `origin` (3,) [m].

        One byte for each, as of a bool array; None for all of them.
        """
        if not math.isfinite(reach):
            return None
        place = origin.tolist()
        farthest = sum(max(x - low, high - x) ** 2 for x, low, high in zip(place, self._low, self._high, strict=True))
        if not reach > 0 or farthest <= reach * reach:
            return None
        side = 2.0 ** math.floor(math.log2(reach)) / CELLS
        reach = math.ceil(reach / side) * side
        cell = reach, *(math.floor(x / side) for x in place)
        if cell not in self._known:
            if len(self._known) >= MOST_CELLS:
                self._known.clear()
            self._known[cell] = self._near(np.array(cell[1:]) * side, side, reach)
        return self._known[cell]

    def _near(self, corner: np.ndarray, side: float, reach: float) -> bytes | None:
        gaps = np.maximum(0.0, np.maximum(self._boxes[:, 0] - (corner + side), corner - self._boxes[:, 1]))
        near = (gaps * gaps).sum(axis=1) <= reach * reach
        return None if near.all() else near.tobytes()
