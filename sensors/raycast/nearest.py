"""The nearest of several casts."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .rays import NO_SURFACE, Hits
from .triangles import TriangleHits

SurfaceOf = Callable[[np.ndarray], np.ndarray]


class Nearest:
    """Keeps the nearest hit of each ray; an earlier one wins a tie, so the order of the casts is part of the result."""

    def __init__(self, count: int, *, normals: bool, surfaces: bool) -> None:
        self._count = count
        self._with_normals, self._with_surfaces = normals, surfaces
        self._distance: np.ndarray | None = None
        self._normals: np.ndarray | None = None
        self._surface = np.full(count, NO_SURFACE, np.int32) if surfaces else None

    @property
    def distance(self) -> np.ndarray:
        """(n,) float32, inf where nothing was hit yet."""
        if self._distance is None:
            self._distance = np.full(self._count, np.inf, np.float32)
            self._normals = np.zeros((self._count, 3), np.float32)
        return self._distance

    def hits(self) -> Hits:
        """What is nearest of all that was added."""
        distance = self.distance
        return Hits(distance, self._normals if self._with_normals else None, self._surface)

    def add(self, found: TriangleHits, surface_of: SurfaceOf) -> None:
        """A cast of all rays."""
        if self._distance is None:
            self._distance, self._normals = found.distance, found.normals
            if self._surface is not None:
                self._surface = surface_of(found.triangle)
        elif self._with_normals or self._with_surfaces:
            rows = np.flatnonzero(found.distance < self._distance)
            self._take(rows, found, rows, surface_of)
        else:
            np.minimum(self._distance, found.distance, out=self._distance)

    def add_rows(self, index: np.ndarray, found: TriangleHits, surface_of: SurfaceOf) -> None:
        """A cast of the rays `index`, each at most once."""
        rows = np.flatnonzero(found.distance < self.distance[index])
        self._take(index[rows], found, rows, surface_of)

    def add_bodies(
        self, index: np.ndarray, owner: np.ndarray, found: TriangleHits, rotations: np.ndarray, surfaces: np.ndarray
    ) -> None:
        """A cast of the rays `index`, a ray once for each `owner`, in the owners' frames.

        rotations: (m, 3, 3) float32 of the owners, to turn normals into the world; surfaces: (m,) of the owners.
        """
        rows = np.flatnonzero(found.distance < self.distance[index])
        distance, index = found.distance[rows], index[rows]
        np.minimum.at(self.distance, index, distance)
        if not (self._with_normals or self._with_surfaces):
            return
        won = np.flatnonzero(distance == self.distance[index])
        index, rows = index[won], rows[won]
        if self._surface is not None:
            self._surface[index] = surfaces[owner[rows]]
        if self._normals is not None and self._with_normals:
            self._normals[index] = turn_each(found.normals[rows], rotations[owner[rows]])

    def add_surface(self, distance: np.ndarray, normal: np.ndarray, surface: int) -> None:
        """Distances of all rays to one flat surface."""
        rows = np.flatnonzero(distance < self.distance)
        self.distance[rows] = distance[rows]
        if self._normals is not None and self._with_normals:
            self._normals[rows] = normal.astype(np.float32)
        if self._surface is not None:
            self._surface[rows] = surface

    def _take(self, target: np.ndarray, found: TriangleHits, rows: np.ndarray, surface_of: SurfaceOf) -> None:
        self.distance[target] = found.distance[rows]
        if self._normals is not None and self._with_normals:
            self._normals[target] = np.take(found.normals, rows, axis=0, mode="clip")
        if self._surface is not None:
            self._surface[target] = surface_of(found.triangle[rows])


def turn_each(vectors: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Vectors (n, 3), each by its own rotation (n, 3, 3), column by column."""
    out = np.empty(vectors.shape, np.float32)
    for row in range(3):
        np.multiply(vectors[:, 0], rotations[:, row, 0], out=out[:, row])
        for column in (1, 2):
            out[:, row] += vectors[:, column] * rotations[:, row, column]
    return out
