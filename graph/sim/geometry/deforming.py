"""Surfaces that deform: their vertices follow the points of a prim whose shape physics changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats

_CHUNK = 5_000_000


class Following:
    """Vertices (n, 3), each at a constant offset from the nearest of the points (p, 3) in their initial positions."""

    def __init__(self, vertices: Floats, points: Floats) -> None:
        self._nearest = _nearest(vertices, points)
        self._offsets: Floats = vertices - points[self._nearest]

    def vertices(self, points: Floats) -> Floats:
        """(n, 3) the vertices for the present points."""
        out: Floats = points[self._nearest] + self._offsets
        return out

    def velocities(self, points: Floats) -> Floats:
        """(n, 3) of the vertices, from those of the points (p, 3)."""
        out: Floats = points[self._nearest]
        return out


def _nearest(vertices: Floats, points: Floats) -> NDArray[np.intp]:
    """The number of the point nearest to each vertex."""
    out = np.empty(len(vertices), dtype=np.intp)
    rows = max(_CHUNK // max(len(points), 1), 1)
    square = (points**2).sum(axis=1)
    for low in range(0, len(vertices), rows):
        part = vertices[low : low + rows]
        out[low : low + rows] = np.argmin(square - 2 * part @ points.T, axis=1)
    return out
