"""Meshes that deform, such as cloth: one scene of them all, built again after any of their points has moved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .nearest import Nearest, cast_picked
from .rays import RayBundle
from .triangles import TriangleScene
from .windows import RayGrid

if TYPE_CHECKING:
    from graph.sim.geometry.surfaces import Mesh

PointsOf = Callable[["Mesh", Any], np.ndarray]
"""A mesh, a state of the world (None: now) -> positions of its vertices, (n, 3) float64 [m], world."""

WIDE_RAD = np.deg2rad(60.0)
"""Half the angle of the cone about all of them, above which every ray is cast."""

MARGIN_RAD = 1e-4


class SoftMeshes:
    """The meshes that deform, each with its surface number."""

    def __init__(self, meshes: Sequence[tuple[int, Mesh]], points_of: PointsOf) -> None:
        self._meshes = meshes
        self._points_of = points_of
        self._built: tuple[tuple[bytes, ...], TriangleScene, np.ndarray, np.ndarray] | None = None

    def cast(self, rays: RayBundle, state: Any, skip: frozenset[int], threads: int, nearest: Nearest) -> None:
        """Adds hits with the meshes in a state of the world; skip: surfaces that are left out."""
        meshes = [(number, mesh) for number, mesh in self._meshes if number not in skip]
        if not meshes:
            return
        points = [np.asarray(self._points_of(mesh, state), np.float64) for _, mesh in meshes]
        scene, surface, first = self._scene(meshes, points, rays.origin)
        index = _window(rays, np.concatenate(points) - rays.origin)
        cast_picked(rays, index, np.zeros(3, np.float32), scene, surface, first, threads, nearest)

    def _scene(
        self, meshes: Sequence[tuple[int, Mesh]], points: Sequence[np.ndarray], origin: np.ndarray
    ) -> tuple[TriangleScene, np.ndarray, np.ndarray]:
        """The scene about the origin; the surface of each of its triangles, and the first of its mesh, (t,) uint32."""
        key = (origin.tobytes(), bytes(str([number for number, _ in meshes]), "ascii"), *(p.tobytes() for p in points))
        if self._built is None or self._built[0] != key:
            self._built = None  # the old scene is freed before the next is made
            starts = np.cumsum([0, *(len(each) for each in points)])
            triangles = [
                np.asarray(mesh.triangles, np.uint32) + np.uint32(start)
                for (_, mesh), start in zip(meshes, starts, strict=False)
            ]
            counts = [len(each) for each in triangles]
            surface = np.repeat(np.array([number for number, _ in meshes], np.uint32), counts)
            first = np.repeat(np.cumsum([0, *counts[:-1]], dtype=np.uint32), counts)
            vertices = (np.concatenate(points) - origin).astype(np.float32)
            self._built = key, TriangleScene(vertices, np.concatenate(triangles), warm=False), surface, first
        return self._built[1:]


def _window(rays: RayBundle, towards: np.ndarray) -> np.ndarray | None:
    """The rays that may hit something among these points (n, 3) [m, from the rays' origin]; None for all."""
    low, high = towards.min(axis=0), towards.max(axis=0)
    centre, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2 + rays.spread()
    distance = float(np.linalg.norm(centre))
    if distance <= radius:
        return None
    half = np.arcsin(radius / distance) + MARGIN_RAD + rays.swing
    if half > WIDE_RAD:
        return None
    grid = rays.grid if rays.grid is not None else RayGrid(rays.table[:, 3:6])
    index = grid.near(centre[None], np.array([half]), rays.span)[0] - rays.first
    return np.sort(index[(index >= 0) & (index < len(rays.table))])
