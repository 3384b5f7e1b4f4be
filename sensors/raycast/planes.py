"""Infinite planes, hit by formula: they reach as far as the sensor does."""

from __future__ import annotations

import numpy as np

from sensors.compiled import compiled

from .rays import COMMON


def cast_plane(height: float, offsets: np.ndarray | None, table: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Distance along each ray to a plane, from either side; inf if the ray does not hit it.

    height: signed, of the rays' common origin over the plane [m], computed in float64; offsets: (n, 3) float32 of
    single origins from it, or None; table: (n, 6) float32, its columns 3 to 5 the unit directions; normal: (3,) unit.
    Returns (n,) float32: t = -h / (d . n), with h the height of the origin.
    """
    return _distances(height, COMMON if offsets is None else offsets, table, normal.astype(np.float32))


@compiled(makes_arrays=True)
def _distances(height: float, offsets: np.ndarray, table: np.ndarray, normal: np.ndarray) -> np.ndarray:
    found, (x, y, z) = np.empty(len(table), np.float32), normal
    for ray in range(len(table)):
        own = min(ray, len(offsets) - 1)
        above = np.float32(height + (offsets[own, 0] * x + offsets[own, 1] * y + offsets[own, 2] * z))
        distance = -above / (table[ray, 3] * x + table[ray, 4] * y + table[ray, 5] * z)
        found[ray] = distance if distance > 0 else np.inf
    return found
