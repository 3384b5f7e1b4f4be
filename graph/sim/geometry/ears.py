"""Triangulates concave polygons by ear clipping (mapbox_earcut), each in its best-fitting plane."""

from __future__ import annotations

import mapbox_earcut
import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats

Integers = NDArray[np.int64]


def clip_ears(corners: Floats) -> Integers:
    """(f, n, 3) corners of polygons to (f, n - 2, 3) corner numbers, with the winding of the polygon.

    Corners on a straight line get triangles too, so that neighbouring faces meet at every corner. If there are fewer
    than n - 2 triangles, as for a polygon that crosses itself or repeats a corner, (0, 0, 0) fills the rest.
    """
    flat = _flat(corners)
    count, size = flat.shape[:2]
    out = np.zeros((count, size - 2, 3), np.int64)
    ring = np.array([size], np.uint32)
    for polygon, triangles in zip(flat, out, strict=True):
        cut = mapbox_earcut.triangulate_float64(polygon, ring).reshape(-1, 3)
        triangles[: len(cut)] = cut
    return out


def _flat(corners: Floats) -> Floats:
    """(f, n, 3) to (f, n, 2): without the axis closest to the normal, counter-clockwise."""
    relative = corners - corners[:, :1]
    normal = np.cross(relative, np.roll(relative, -1, axis=1)).sum(axis=1)
    drop = np.argmax(np.abs(normal), axis=1)
    u, v = (drop + 1) % 3, (drop + 2) % 3
    picked = np.stack([u, v], axis=1)[:, None, :]
    flat = np.take_along_axis(relative, np.broadcast_to(picked, (*relative.shape[:2], 2)), axis=2)
    flat[..., 1] *= np.where(np.take_along_axis(normal, drop[:, None], axis=1) > 0, 1.0, -1.0)
    return np.ascontiguousarray(flat)
