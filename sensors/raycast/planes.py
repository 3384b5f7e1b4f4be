"""Infinite planes, hit by formula: they reach as far as the sensor does."""

from __future__ import annotations

import numpy as np


def cast_plane(
    distance_to_plane: float, offsets: np.ndarray | None, directions: np.ndarray, normal: np.ndarray
) -> np.ndarray:
    """Distance along each ray to a plane, from either side; inf if the ray does not hit it.

    distance_to_plane: signed height [m] of the rays' common origin over the plane, computed in float64; offsets:
    (n, 3) float32 of single origins from it, or None; directions: (3, n) float32 unit; normal: (3,) unit.
    Returns (n,) float32: t = -h / (d . n), with h the height of the origin.
    """
    approach = _dot(directions, normal)
    height: np.ndarray | float = distance_to_plane
    if offsets is not None:
        height = distance_to_plane + _dot(offsets.T, normal).astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.divide(np.float32(-1.0) * np.asarray(height, np.float32), approach, dtype=np.float32)
    distance[~(distance > 0)] = np.inf
    return np.asarray(distance)


def _dot(vectors: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Dot products of vectors (3, n), by axis, without terms that are zero: exact for planes along the axes."""
    total: np.ndarray | None = None
    for column in np.flatnonzero(axis):
        term = vectors[column] * np.float32(axis[column])
        total = term if total is None else np.add(total, term, out=total)
    assert total is not None
    return total
