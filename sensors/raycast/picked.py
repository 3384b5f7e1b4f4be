"""Casts some rays of a bundle at one scene."""

from __future__ import annotations

import numpy as np

from .nearest import Nearest
from .rays import RayBundle, Spots
from .triangles import TriangleScene


def cast_picked(
    rays: RayBundle,
    index: np.ndarray | None,
    start: np.ndarray,
    scene: TriangleScene,
    surface: np.ndarray,
    first: np.ndarray,
    threads: int,
    nearest: Nearest,
) -> None:
    """Adds the hits of rays in a scene whose triangles have the surfaces (t,) uint32.

    first: (t,) uint32, the scene's first triangle of the same surface.
    index: (k,) rays that may hit anything; None: all. start: (3,) float32 [m], the bundle's origin in the
    scene's frame.
    """
    if index is None:
        rays.start_at(start)
        table = rays.table
    elif len(index):
        table = _started(rays, index, start)
    else:
        return
    found = scene.cast(table, threads, uv=nearest.with_spots)
    spots = None
    if found.uv is not None:
        spots = Spots(found.triangle - first.take(found.triangle, mode="clip"), found.uv)
    target = np.arange(len(table)) if index is None else index
    nearest.add_some(target, found.distance, surface.take(found.triangle, mode="clip"), found.normals, spots)


def _started(rays: RayBundle, index: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The rays `index` (k, 6) float32 with their origins at `start` (3,), each with its own offset."""
    table = np.take(rays.table, index, axis=0, mode="clip")
    for axis in range(3):
        table[:, axis] = start[axis] if rays.offsets is None else rays.offsets[index, axis] + start[axis]
    return np.asarray(table)
