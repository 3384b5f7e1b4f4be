"""The nearest of several casts."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy

import numpy as np

from .rays import NOTHING, Hits, Spots
from .triangles import TriangleHits


class Nearest:
    """Keeps the nearest hit of each ray; an earlier one wins a tie, so the order of the casts is part of the result.

    A hit is kept as a number, which the static cast gives for free: first come the triangles of the static scene, then
    all surfaces. So a surface is looked up only on request.
    """

    def __init__(
        self, count: int, surface_of: np.ndarray, starts: np.ndarray, triangles: int, *, normals: bool, spots: bool
    ) -> None:
        """surface_of: (t + s + 1,) int32, the surface of the t static triangles, the s surfaces, and `NO_SURFACE`.

        starts: (s,) uint32, the first static triangle of each surface.
        """
        self._count = count
        self._surface_of, self._starts, self._first = surface_of, starts, np.uint32(triangles)
        self._with_normals = normals
        self.with_spots = spots
        """Whether the places on the surfaces are requested."""
        self._spots: Spots | None = None
        self._distance: np.ndarray | None = None
        self._normals: np.ndarray | None = None
        self._number: np.ndarray | None = None

    @property
    def distance(self) -> np.ndarray:
        """(n,) float32, inf without a hit."""
        if self._distance is None:
            self._distance = np.full(self._count, np.inf, np.float32)
            self._normals = np.zeros((self._count, 3), np.float32)
            self._number = np.full(self._count, NOTHING, np.uint32)
            if self.with_spots:
                self._spots = Spots(self._number.copy(), np.zeros((self._count, 2), np.float32))
        return self._distance

    def some(self, rows: slice) -> Nearest:
        """The part for some rays, numbered from 0: what is added to it is added here."""
        distance = self.distance
        assert self._number is not None
        part = copy(self)
        part._distance, part._number, part._count = distance[rows], self._number[rows], len(distance[rows])
        part._normals = None if self._normals is None else self._normals[rows]
        part._spots = None if self._spots is None else self._spots.some(rows)
        return part

    def hits(self) -> Hits:
        """The nearest of all added hits."""
        distance = self.distance
        assert self._number is not None
        normals = self._normals if self._with_normals else None
        return Hits(distance, normals, self._number, self._surface_of, self._spots)

    def add_static(self, found: TriangleHits, kept: bool) -> None:
        """Adds the cast of all rays at static geometry, before any other; kept: whether the arrays are kept."""
        self._distance, self._normals, self._number = found.distance, found.normals, found.triangle
        if kept:
            self._distance, self._number = self._distance.copy(), self._number.copy()
            self._normals = self._normals.copy() if self._with_normals else None
        if self.with_spots and found.uv is not None:
            surface = self._surface_of.take(found.triangle, mode="clip")
            start = self._starts.take(surface, mode="clip")
            triangle = np.where(found.triangle == NOTHING, NOTHING, found.triangle - start)
            self._spots = Spots(triangle, found.uv.copy() if kept else found.uv)

    def add_plane(self, distance: np.ndarray, normal: np.ndarray, surface: int) -> None:
        """Distances (n,) of all rays to one flat surface."""
        nearer = distance < self.distance
        assert self._number is not None
        np.copyto(self.distance, distance, where=nearer)
        np.copyto(self._number, np.uint32(surface) + self._first, where=nearer)
        if self._with_normals:
            assert self._normals is not None
            for axis in range(3):  # five times as fast as rows of three
                np.copyto(self._normals[:, axis], np.float32(normal[axis]), where=nearer)
        if self._spots is not None:
            np.copyto(self._spots.triangle, NOTHING, where=nearer)

    def add_some(
        self,
        index: np.ndarray,
        distance: np.ndarray,
        surfaces: np.ndarray,
        normals: Callable[[np.ndarray], np.ndarray],
        spots: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
        *,
        once: bool = False,
    ) -> None:
        """Hits of the rays `index` (k,), each of which may repeat unless `once`, with the surfaces (k,) uint32.

        normals: gives the unit normals (m, 3), world axes, of some of them, in ascending order; spots: their triangles
        and uv (`Spots`).
        """
        rows = np.flatnonzero(distance < self.distance.take(index))
        distance, index = distance.take(rows), index.take(rows)
        if once:
            self.distance[index] = distance
        else:
            np.minimum.at(self.distance, index, distance)
            won = np.flatnonzero(distance == self.distance.take(index))
            index, rows = index.take(won), rows.take(won)
        last_first = slice(None, None, -1)  # of equals the first is written last
        self._mark(index[last_first], surfaces.take(rows[last_first]))
        if self._with_normals:
            assert self._normals is not None
            self._normals[index[last_first]] = normals(rows)[last_first]
        if self._spots is not None:
            triangle, uv = spots(rows)
            self._spots.triangle[index[last_first]], self._spots.uv[index[last_first]] = (
                triangle[last_first],
                uv[last_first],
            )

    def _mark(self, rows: np.ndarray, surfaces: np.ndarray | np.uint32) -> None:
        assert self._number is not None
        self._number[rows] = surfaces + self._first


def turn_each(vectors: np.ndarray, turns: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """Vectors (n, 3), each by its mesh's rotation; turns: (3, 3, m) float32 of all meshes. Column by column."""
    out = np.empty(vectors.shape, np.float32)
    columns = np.ascontiguousarray(vectors.T)
    for row in range(3):
        turned = np.take(turns[row, 0], owner) * columns[0]
        for axis in (1, 2):
            turned += np.take(turns[row, axis], owner) * columns[axis]
        out[:, row] = turned
    return out
