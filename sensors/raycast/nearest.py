"""The nearest of several casts."""

from __future__ import annotations

from copy import copy

import numpy as np

from sensors.compiled import compiled

from .planes import above_plane, plane_distance
from .rays import COMMON, NOTHING, Hits, RayBundle, Spots
from .triangles import TriangleHits, TriangleScene

_NO_NORMALS = np.zeros((0, 3), np.float32)
_NO_SPOTS = Spots(np.zeros(0, np.uint32), np.zeros((0, 2), np.float32))


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
        self.with_normals = normals
        """Whether the normals are requested."""
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
        normals = self._normals if self.with_normals else None
        return Hits(distance, normals, self._number, self._surface_of, self._spots)

    def add_static(self, found: TriangleHits, kept: bool) -> None:
        """Adds the cast of all rays at static geometry, before any other; kept: whether the arrays are kept."""
        self._distance, self._normals, self._number = found.distance, found.normals, found.triangle
        if kept:
            self._distance, self._number = self._distance.copy(), self._number.copy()
            self._normals = self._normals.copy() if self.with_normals else None
        if self.with_spots and found.uv is not None:
            triangle = np.empty_like(found.triangle)
            _own_triangles(found.triangle, self._surface_of, self._starts, NOTHING, triangle)
            self._spots = Spots(triangle, found.uv.copy() if kept else found.uv)

    def add_plane(self, rays: RayBundle, origin: np.ndarray, normal: np.ndarray, surface: int) -> None:
        """Adds what all rays hit of an infinite plane through a point (3,) float64 [m]; normal: (3,) unit."""
        here = self.distance
        assert self._number is not None
        into, vectors = self._spots or _NO_SPOTS, _NO_NORMALS if self._normals is None else self._normals
        own = np.uint32(surface) + self._first, normal.astype(np.float32)
        for first, part in rays.each():
            height, offsets = float((part.origin - origin) @ normal), COMMON if part.offsets is None else part.offsets
            _add_plane(first, height, offsets, part.table, *own, here, self._number, vectors, into.triangle, NOTHING)

    def add_some(
        self,
        index: np.ndarray,
        distance: np.ndarray,
        surfaces: np.ndarray,
        normals: np.ndarray | None,
        spots: Spots | None = None,
    ) -> None:
        """Hits (k,) of the rays `index`, each of which may repeat, with the surfaces (k,) uint32; inf for a miss.

        normals: (k, 3) float32, unit, world axes, None if they are not requested; spots: None for no triangles.
        """
        here = self.distance
        assert self._number is not None
        into, own = self._spots or _NO_SPOTS, spots or _NO_SPOTS
        if self._spots is not None and spots is None:
            own = Spots(np.full(len(index), NOTHING), np.zeros((len(index), 2), np.float32))
        normal_of = _NO_NORMALS if self._normals is None or normals is None else self._normals
        _add(
            *(index, distance, surfaces + self._first, _NO_NORMALS if normals is None else normals),
            *(own.triangle, own.uv, here, self._number, normal_of, into.triangle, into.uv),
        )


@compiled
def _own_triangles(
    number: np.ndarray, surface_of: np.ndarray, starts: np.ndarray, nothing: np.uint32, triangle: np.ndarray
) -> None:
    """Writes the triangles (n,) of the surfaces' own meshes, of triangles (n,) of the scene; `nothing` stays so."""
    for ray in range(len(number)):
        triangle[ray] = number[ray]
        if number[ray] != nothing:
            triangle[ray] -= starts[surface_of[number[ray]]]


@compiled
def _add_plane(
    first: int,
    height: float,
    offsets: np.ndarray,
    table: np.ndarray,
    number: np.uint32,
    normal: np.ndarray,
    nearest: np.ndarray,
    number_of: np.ndarray,
    normal_of: np.ndarray,
    triangle_of: np.ndarray,
    nothing: np.uint32,
) -> None:
    above = above_plane(height, offsets, normal, np.int64(0))
    for ray in range(len(table)):
        if len(offsets) > 1:
            above = above_plane(height, offsets, normal, ray)
        distance, at = plane_distance(above, table, normal, ray), first + ray
        if not distance < nearest[at]:
            continue
        nearest[at], number_of[at] = distance, number
        if len(normal_of):
            for axis in range(3):
                normal_of[at, axis] = normal[axis]
        if len(triangle_of):
            triangle_of[at] = nothing


@compiled
def _add(
    index: np.ndarray,
    distance: np.ndarray,
    numbers: np.ndarray,
    normals: np.ndarray,
    triangle: np.ndarray,
    uv: np.ndarray,
    nearest: np.ndarray,
    number_of: np.ndarray,
    normal_of: np.ndarray,
    triangle_of: np.ndarray,
    uv_of: np.ndarray,
) -> None:
    """Writes hits (k,) that are nearer than the rays' former ones; arrays without rows are left out."""
    for hit in range(len(index)):
        ray = index[hit]
        if not distance[hit] < nearest[ray]:
            continue
        nearest[ray], number_of[ray] = distance[hit], numbers[hit]
        if len(normal_of):
            for axis in range(3):
                normal_of[ray, axis] = normals[hit, axis]
        if len(triangle_of):
            triangle_of[ray] = triangle[hit]
            uv_of[ray, 0], uv_of[ray, 1] = uv[hit, 0], uv[hit, 1]


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
