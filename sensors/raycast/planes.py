"""Infinite planes, hit by formula: they reach as far as the sensor does."""

from __future__ import annotations

from typing import Any

import numpy as np

from sensors.compiled import compiled, inlined

from .rays import COMMON


def cast_plane(height: float, offsets: np.ndarray | None, table: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Distance along each ray to a plane, from either side; inf if the ray does not hit it.

    height: signed, of the rays' common origin over the plane [m], computed in float64; offsets: (n, 3) float32 of
    single origins from it, or None; table: (n, 6) float32, its columns 3 to 5 the unit directions; normal: (3,) unit.
    Returns (n,) float32: t = -h / (d . n), with h the height of the origin.
    """
    found = np.empty(len(table), np.float32)
    _distances(height, COMMON if offsets is None else offsets, table, normal.astype(np.float32), found)
    return found


@inlined
def above_plane(height: float, offsets: np.ndarray, normal: np.ndarray, ray: Any) -> Any:
    """Height of a ray's origin over a plane [m]; as `cast_plane` takes them."""
    own = min(ray, len(offsets) - 1)
    along = offsets[own, 0] * normal[0] + offsets[own, 1] * normal[1] + offsets[own, 2] * normal[2]
    return np.float32(height + along)


@inlined
def plane_distance(above: Any, table: np.ndarray, normal: np.ndarray, ray: Any) -> Any:
    """Distance [m] along a ray to a plane that its origin is so high above, inf if the ray does not hit it."""
    distance = -above / (table[ray, 3] * normal[0] + table[ray, 4] * normal[1] + table[ray, 5] * normal[2])
    return distance if distance > 0 else np.float32(np.inf)


@compiled
def _distances(height: float, offsets: np.ndarray, table: np.ndarray, normal: np.ndarray, found: np.ndarray) -> None:
    for ray in range(len(table)):
        found[ray] = plane_distance(above_plane(height, offsets, normal, ray), table, normal, ray)
