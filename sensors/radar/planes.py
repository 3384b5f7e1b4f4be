"""The flat faces of everything that rays can hit: what a wave needs to know of the surface that a ray has met.

Rays find what is lit; where a wave goes on and with which phase is worked out on the planes of the triangles, in
float64, since float32 hits are off by more than the phase of a millimetre wave allows.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from typing import NamedTuple

import numpy as np

from graph.base.sharing import Shared
from graph.sim.geometry.surfaces import Mesh, Plane
from sensors.compiled import compiled, inlined
from sensors.raycast.rays import NO_SURFACE, Hits
from sensors.raycast.standing import excluded
from sensors.raycast.world import CastWorld, once_a_world

from .faces import SPREAD, Faces, faces_of, patches, plane_axes
from .images import plane_keys
from .tensors import form, principal, symmetric

NO_PLANE = -1

FADED = 20.0
"""Squared angle from the middle of a lobe, over the lobe's variance, beyond which it counts no more (e^-10)."""

STRAIGHT = 1e-3
"""Turn to the neighbours [rad] up to which a curved surface is straight along a direction."""

MOST_TOGETHER = 50_000
"""Triangles of meshes that are worked out together: their numbers stay in the cache."""

MOST_KEPT = 500_000
"""Triangles whose faces are kept for the next App with the same meshes."""


class Curves(NamedTuple):
    """Planes (p,) as pieces of curved surfaces, in the axes of their bodies, for one wavelength.

    middle, axes, extent, bend: as in `Faces`. lobes: (p, 2, 2) covariances [rad^2] of the lobes, in the planes' axes:
    the spread of the normals, and diffraction at the face's size. straight: (p, 2) along which a surface is straight,
    of length 2 L / wavelength for a face of length L, so that its lobe is sinc squared of the product with the sines
    off the normal; else 0. reach: (p, 3), squared angle [rad^2] from the normal within which the surface may send
    anything, square of how much it bends [rad^2/m^2], and of the length [m^2] along which it is straight.
    """

    middle: np.ndarray
    axes: np.ndarray
    extent: np.ndarray
    bend: np.ndarray
    lobes: np.ndarray
    straight: np.ndarray
    reach: np.ndarray


class Joined:
    """The planes of surfaces, numbered through all of them, in the axes of their bodies; one more for nothing.

    first, triangles: (s + 1,), the first plane and the first triangle of each surface. of_triangle: the plane of each
    triangle. The rest as in `WorldPlanes`.
    """

    def __init__(self, faces: Sequence[Faces], body_of: np.ndarray) -> None:
        counts = [len(each.normal) for each in faces]
        self.first = np.cumsum([0, *counts])
        self.triangles = np.cumsum([0, *(len(each.of_triangle) for each in faces)])
        of_triangle = [first + each.of_triangle for first, each in zip(self.first, faces, strict=False)]
        self.of_triangle = np.concatenate(of_triangle or [np.zeros(0)]).astype(np.int64)
        nothing = _endless(np.zeros((1, 3)), np.zeros((1, 3)))

        def of_all(name: str) -> np.ndarray:
            return np.concatenate([getattr(each, name) for each in (*faces, nothing)])

        self.normal, self.offset, self.curved = of_all("normal"), of_all("offset"), of_all("curved")
        self.surface = np.append(np.repeat(np.arange(len(faces), dtype=np.int32), counts), np.int32(NO_SURFACE))
        self.body = np.append(body_of[self.surface[:-1]] if len(faces) else [], -1).astype(np.int64)
        low, high = of_all("low")[:-1], of_all("high")[:-1]
        self.patch = patches(self.normal[:-1], self.offset[:-1], self.body[:-1], low, high)
        self.key = np.append(plane_keys(self.patch), np.uint64(0))
        self.any_curved = bool(self.curved.any())
        self._shapes = [of_all(name) for name in ("middle", "axes", "extent", "bend", "spread")]
        self._curves: dict[float, Curves] = {}

    def curves(self, wavelength: float) -> Curves:
        """The planes as pieces of curved surfaces.

        Where a face is so small that it and its neighbours are one to the wave, of size e and turn t with e t below
        wavelength / 2, sqrt(wavelength / (2 e t)) of them make up a Fresnel zone and diffract together.
        """
        if wavelength not in self._curves:
            middle, axes, extent, bend, spread = self._shapes
            lobes, straight, reach = (np.zeros((len(spread), *shape)) for shape in ((2, 2), (2,), (3,)))
            found = Curves(middle, axes, extent, bend, lobes, straight, reach)
            _widen(wavelength, self.curved, spread, found)
            self._curves[wavelength] = found
        return self._curves[wavelength]


_shared: Shared[bytes, Joined] = Shared()


def joined(surfaces: Sequence[Mesh | Plane], faces: Sequence[Faces], body_of: np.ndarray) -> Joined:
    """The planes of surfaces (s,), their faces (s,), that bodies (s,) carry: those of another App of this process if it
    has them.
    """
    digest = sha256(np.asarray(body_of, np.int64).tobytes())
    for one in surfaces:
        digest.update(one.unique_key if isinstance(one, Mesh) else np.array([one.normal, one.origin]).tobytes())
    return _shared.of(digest.digest(), lambda: Joined(faces, body_of))


class _FacesByContent:
    """The faces of meshes that this process met last, by their content."""

    def __init__(self) -> None:
        self._found: OrderedDict[bytes, Faces] = OrderedDict()
        self._kept = 0

    def of(self, meshes: Sequence[Mesh]) -> list[Faces]:
        """As `faces_of`."""
        keys = [mesh.unique_key for mesh in meshes]
        found = {key: self._found.pop(key) for key in set(keys) & self._found.keys()}
        missing = {key: mesh for key, mesh in zip(keys, meshes, strict=True) if key not in found}
        for some in _batches(missing):
            shapes = [(np.asarray(one.vertices, np.float64), one.triangles.astype(np.int64)) for one in some.values()]
            found.update(zip(some, faces_of(shapes), strict=True))
        self._kept += sum(len(mesh.triangles) for mesh in missing.values())
        self._found.update((key, found[key]) for key in keys)
        while self._kept > MOST_KEPT and self._found:
            self._kept -= len(self._found.popitem(last=False)[1].of_triangle)
        return [found[key] for key in keys]


def _batches(meshes: Mapping[bytes, Mesh]) -> Iterator[dict[bytes, Mesh]]:
    """Meshes by their keys, as many at a time as have `MOST_TOGETHER` triangles, or one."""
    some: dict[bytes, Mesh] = {}
    count = 0
    for key, mesh in meshes.items():
        if some and count + len(mesh.triangles) > MOST_TOGETHER:
            yield some
            some, count = {}, 0
        some[key] = mesh
        count += len(mesh.triangles)
    if some:
        yield some


FACES_BY_CONTENT = _FacesByContent()


class WorldPlanes:
    """The planes of a cast world, numbered through all surfaces, in the axes of their bodies; one more for nothing.

    normal, offset, curved: as `Faces` has them; surface, body: of each; key: (p + 1,) uint64 of the flat patches that
    they are part of (`plane_keys`); patch: (p,), the first plane of each patch. any_curved: whether any is.
    """

    def __init__(self, world: CastWorld) -> None:
        self._world = world
        self._faces = _faces_of(world.surfaces)
        self._joined = known = joined(world.surfaces, self._faces, world.body_of[: len(self._faces)])
        self.normal, self.offset, self.curved = known.normal, known.offset, known.curved
        self.surface, self.body, self.patch, self.key = known.surface, known.body, known.patch, known.key
        self.any_curved, self.curves = known.any_curved, known.curves
        rigid = (world.body_of >= 0) & ~world.deforming[: len(world.body_of)]
        self._begins = np.where(rigid, known.triangles[: len(rigid)], -1)
        self._numbers: tuple[np.ndarray, np.ndarray] | None = None
        self._seen: dict[frozenset[str], np.ndarray] = {}

    def bodies_seen(self, exclude: frozenset[str]) -> np.ndarray:
        """The numbers (m,) of the bodies that carry anything that is not excluded."""
        if exclude not in self._seen:
            world = self._world
            carry = [
                body
                for surface, body in zip(world.surfaces, world.body_of.tolist(), strict=False)
                if body >= 0 and not excluded(str(surface.path), exclude)
            ]
            self._seen[exclude] = np.unique(np.array(carry, np.int64))
        return self._seen[exclude]

    def of_hits(self, hits: Hits, rows: np.ndarray | slice) -> np.ndarray:
        """The plane of each of the hits `rows` (k,), (k,) int32; `NO_PLANE` where none is known: of what deforms, and
        where nothing is hit.
        """
        number = hits.number[rows]
        found = np.empty(len(number), np.int32)
        triangle = number if hits.spots is None else hits.spots.triangle[rows]
        begins = self._begins if hits.spots is not None else np.full_like(self._begins, -1)
        _look_up(self._table(hits), number, found, hits.surface_of, triangle, begins, self._joined.of_triangle)
        return found

    def _table(self, hits: Hits) -> np.ndarray:
        """Number of a hit -> plane; `NO_PLANE` where a surface has several."""
        known = self._numbers  # other threads may set it
        if known is None or known[0] is not hits.surface_of:
            surfaces = self._world.surfaces
            static = len(hits.surface_of) - len(surfaces) - 1
            parts = [
                self._joined.first[number] + self._faces[number].of_triangle
                for number in np.unique(hits.surface_of[:static]).tolist()
            ]
            single = [
                int(self._joined.first[number]) if isinstance(surface, Plane) else NO_PLANE
                for number, surface in enumerate(surfaces)
            ]
            table = np.concatenate([*parts, np.array([*single, NO_PLANE])]).astype(np.int32)
            self._numbers = known = hits.surface_of, table
        return known[1]


@compiled
def _look_up(
    table: np.ndarray,
    number: np.ndarray,
    found: np.ndarray,
    surface_of: np.ndarray,
    triangle: np.ndarray,
    begins: np.ndarray,
    of_triangle: np.ndarray,
) -> None:
    """Writes the plane of each hit by its number (k,), from a table whose last entry serves all numbers beyond it.

    Where the table has `NO_PLANE`, the triangle (k,) of the surface decides. begins: (s,), the place of a surface's
    first triangle in `of_triangle`, below 0 for surfaces that are not moving rigid meshes.
    """
    last = len(table) - 1
    for row in range(len(number)):
        at = min(int(number[row]), last)
        found[row] = table[at]
        if found[row] == NO_PLANE and at < last:
            begin = begins[surface_of[at]]
            if begin >= 0:
                found[row] = of_triangle[begin + np.int64(triangle[row])]


@compiled
def _widen(wavelength: float, curved: np.ndarray, spread: np.ndarray, curves: Curves) -> None:
    """Fills in the lobes of curved faces, where they are straight, and their reach."""
    for face in range(len(curved)):
        if not curved[face]:
            continue
        lobe = symmetric(spread, face)
        sizes, along = principal(symmetric(curves.extent, face), 1e-12)
        across = -along[1], along[0]
        size, other = 1.0 / sizes[0], 1.0 / sizes[1]
        first, second = form(lobe, along) / (2.0 * SPREAD), form(lobe, across) / (2.0 * SPREAD)
        alone = wavelength**2 / (96.0 * math.pi)
        wide, tall = _together(alone * size, first), _together(alone * other, second)
        lobe = (
            lobe[0] + wide * along[0] ** 2 + tall * across[0] ** 2,
            lobe[1] + wide * along[0] * along[1] + tall * across[0] * across[1],
            lobe[2] + wide * along[1] ** 2 + tall * across[1] ** 2,
        )
        curves.lobes[face, 0, 0], curves.lobes[face, 1, 1] = lobe[0], lobe[2]
        curves.lobes[face, 0, 1] = curves.lobes[face, 1, 0] = lobe[1]
        flat, level = first <= STRAIGHT**2, second <= STRAIGHT**2
        length = 1.0 / math.sqrt(2.0 * math.pi * (wide if flat else tall)) if flat != level else 0.0
        for axis in range(2):
            curves.straight[face, axis] = length * (along[axis] if flat else across[axis])
        bend = 0.0
        for row in range(2):
            for column in range(2):
                bend += curves.bend[face, row, column] ** 2
        extent = curves.extent[face, 0, 0] + curves.extent[face, 1, 1]
        curves.reach[face, 0] = FADED * (lobe[0] + lobe[2]) + 6.0 * bend * extent
        curves.reach[face, 1], curves.reach[face, 2] = bend, (length * wavelength / 2.0) ** 2


@inlined
def _together(alone: float, turned: float) -> float:
    """Squared width [rad^2] of a lobe, `alone` that of a face by itself, whose surface turns by so much [rad^2]."""
    return min(alone, math.sqrt(alone * turned)) if turned > STRAIGHT**2 else alone


@once_a_world
def planes_of(world: CastWorld) -> WorldPlanes:
    """The planes of a cast world, worked out once."""
    return WorldPlanes(world)


def _faces_of(surfaces: Sequence[Mesh | Plane]) -> list[Faces]:
    """The faces of each surface."""
    found = iter(FACES_BY_CONTENT.of([one for one in surfaces if isinstance(one, Mesh) and len(one.triangles)]))
    return [_without_ends(one) if isinstance(one, Plane) or not len(one.triangles) else next(found) for one in surfaces]


def _without_ends(surface: Mesh | Plane) -> Faces:
    if isinstance(surface, Mesh):  # without triangles
        return _endless(np.zeros((0, 3)), np.zeros((0, 3)))
    return _endless(np.asarray(surface.normal, np.float64)[None], np.asarray(surface.origin, np.float64)[None])


def _endless(normal: np.ndarray, middle: np.ndarray) -> Faces:
    """Planes without ends through points, both (p, 3)."""
    count = len(normal)
    square, curved, offset = np.zeros((count, 2, 2)), np.zeros(count, bool), (normal * middle).sum(axis=1)
    axes = plane_axes(normal)
    return Faces(np.zeros(0, np.int32), normal, offset, middle, axes, curved, square, square, square, middle, middle)
