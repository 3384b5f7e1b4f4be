"""The flat faces of everything that rays can hit: what a wave needs to know of the surface that a ray has met.

Rays find what is lit; where a wave goes on and with which phase is worked out on the planes of the triangles, in
float64, since float32 hits are off by more than the phase of a millimetre wave allows.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from dataclasses import dataclass

import numpy as np

from graph.sim.geometry.surfaces import Mesh, Plane
from sensors.raycast.rays import NOTHING, Hits
from sensors.raycast.standing import excluded
from sensors.raycast.world import CastWorld

NO_PLANE = -1
SMOOTH = np.cos(np.deg2rad(40.0))
"""Cosine of the angle between two neighbouring faces up to which they stand for one curved surface."""

STRAIGHT = 1e-3
"""Turn to the neighbours [rad] up to which a curved surface is straight along a direction."""

FLAT = 1.0 - 1e-8
"""Cosine from which on two faces are one plane."""

POLE = 8
"""More faces than these around a vertex make it a pole."""

SPREAD = 1.0 / 8.0
"""Share of the squared angles to the neighbours that a face's normals are spread by: the lobes of faces at equal steps
then add up to a curve without ripple (below 0.1 dB along one axis)."""

MOST_KEPT = 500_000
"""Triangles whose faces are kept for the next App with the same meshes."""

_HASH = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x27D4EB2F165667C5], np.uint64)


@dataclass(frozen=True, slots=True)
class Faces:
    """The planes of one mesh, in its frame; p of them.

    of_triangle: (m,) int32, the plane of each triangle. normal: (p, 3), offset: (p,) [m]: n . x = offset. middle:
    (p, 3) [m] of its area. axes: (p, 2, 3), two unit vectors in the plane. curved: (p,) bool, whether it is a piece of
    a curved surface; then spread: (p, 2, 2) covariance of the surface's normals [rad^2] and extent: (p, 2, 2) of its
    area [m^2], in the axes.
    """

    of_triangle: np.ndarray
    normal: np.ndarray
    offset: np.ndarray
    middle: np.ndarray
    axes: np.ndarray
    curved: np.ndarray
    spread: np.ndarray
    extent: np.ndarray


def faces_of(vertices: np.ndarray, triangles: np.ndarray) -> Faces:
    """The planes of a mesh: vertices (n, 3) float64 [m], triangles (m, 3)."""
    corners = vertices[triangles]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(doubled, axis=1)
    normals = doubled / np.where(twice, twice, 1.0)[:, None]
    centres = corners.mean(axis=1)
    offsets = np.einsum("ij,ij->i", normals, centres)
    keys = _hashed(np.rint(np.c_[normals * 1e4, offsets * 1e4]).astype(np.int64))
    _, of_triangle = np.unique(keys, return_inverse=True)
    count = int(of_triangle.max()) + 1

    def summed(values: np.ndarray) -> np.ndarray:
        flat = values.reshape(len(values), -1)
        columns = [np.bincount(of_triangle, flat[:, i], count) for i in range(flat.shape[1])]
        return np.stack(columns, 1).reshape(count, *values.shape[1:])

    area = np.maximum(summed(twice[:, None])[:, 0], 1e-300)
    normal = summed(doubled)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    middle = summed(centres * twice[:, None]) / area[:, None]
    arms = corners - middle[of_triangle][:, None]
    inner = np.einsum("mci,mcj->mij", arms, arms) + 9.0 * np.einsum(
        "mi,mj->mij", centres - middle[of_triangle], centres - middle[of_triangle]
    )
    moment = summed(inner * twice[:, None, None]) / (12.0 * area)[:, None, None]
    axes = _axes(normal)
    turned, neighbours = _turns(vertices, triangles, of_triangle, normal)
    share = SPREAD * np.minimum(1.0, 4.0 / np.maximum(neighbours, 1))
    return Faces(
        of_triangle.astype(np.int32),
        normal,
        np.einsum("ij,ij->i", normal, middle),
        middle,
        axes,
        neighbours > 0,
        _projected(turned, axes) * share[:, None, None],
        _projected(moment, axes),
    )


class _FacesByContent:
    """The faces of meshes that this process met last, by their content."""

    def __init__(self) -> None:
        self._found: OrderedDict[bytes, Faces] = OrderedDict()
        self._kept = 0

    def of(self, vertices: np.ndarray, triangles: np.ndarray) -> Faces:
        """As `faces_of`."""
        digest = hashlib.blake2b(np.ascontiguousarray(vertices).data, digest_size=32)
        digest.update(np.ascontiguousarray(triangles).data)
        key = digest.digest()
        found = self._found.pop(key, None)
        if found is None:
            found = faces_of(vertices, triangles)
            self._kept += len(triangles)
        self._found[key] = found
        while self._kept > MOST_KEPT and self._found:
            self._kept -= len(self._found.popitem(last=False)[1].of_triangle)
        return found


_FACES = _FacesByContent()


def _hashed(rows: np.ndarray) -> np.ndarray:
    """One uint64 for each row of up to four integers."""
    total = np.zeros(len(rows), np.uint64)
    for column, factor in zip(rows.T, _HASH, strict=False):
        total = (total ^ column.astype(np.uint64)) * factor
        total ^= total >> np.uint64(29)
    return total


def _axes(normal: np.ndarray) -> np.ndarray:
    """(p, 2, 3): two unit vectors across each normal."""
    helper = np.where(np.abs(normal[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(normal, helper)
    first /= np.maximum(np.linalg.norm(first, axis=1), 1e-300)[:, None]
    return np.stack((first, np.cross(normal, first)), 1)


def _projected(tensor: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """(p, 2, 2) of tensors (p, 3, 3) in the planes' axes."""
    return np.asarray(np.einsum("pai,pij,pbj->pab", axes, tensor, axes, optimize=True))


def _turns(
    vertices: np.ndarray, triangles: np.ndarray, plane: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sums over the smooth edges of each plane: (p, 3, 3) of the turns of the normal, each squared, and their (p,)
    number.
    """
    _, welded = np.unique(_hashed(np.rint(vertices * 1e6).astype(np.int64)), return_inverse=True)
    ends = np.sort(welded[triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)], axis=1)
    key = ends[:, 0].astype(np.int64) * (int(welded.max()) + 1) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    one, two = plane[order[same] // 3], plane[order[same + 1] // 3]
    cosine = np.einsum("ij,ij->i", normal[one], normal[two])
    smooth = (cosine > SMOOTH) & (cosine < FLAT)
    one, two = one[smooth], two[smooth]
    turn = normal[two] - normal[one]
    squared = turn[:, :, None] * turn[:, None]
    polar, around = _around_poles(welded[triangles], plane, normal)
    squared, of = np.concatenate((squared, squared, around)).reshape(-1, 9), np.concatenate((one, two, polar))
    count = len(normal)
    total = np.stack([np.bincount(of, column, count) for column in squared.T], 1)
    return total.reshape(count, 3, 3), np.bincount(of, minlength=count)


def _around_poles(corners: np.ndarray, plane: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Planes (k,) that meet many others in one vertex, as at a sphere's pole, and (k, 3, 3) the mean square of their
    turns to those: there a plane has no neighbour across an edge.

    corners: (m, 3) vertices of the triangles; plane: (m,) of each.
    """
    count = len(normal)
    vertex, of = np.divmod(np.unique(corners.astype(np.int64).ravel() * count + np.repeat(plane, 3)), count)
    _, vertex, number = np.unique(vertex, return_inverse=True, return_counts=True)
    many = np.flatnonzero(number[vertex] > POLE)
    poles, vertex = np.unique(vertex[many], return_inverse=True)
    of, number = of[many], number[poles]

    def mean(values: np.ndarray) -> np.ndarray:
        flat = values.reshape(len(values), int(np.prod(values.shape[1:])))
        columns = [np.bincount(vertex, column, len(poles)) / number for column in flat.T]
        return np.stack(columns, 1).reshape(len(poles), *values.shape[1:])

    own = normal[of]
    middle, square = mean(own)[vertex], mean(own[:, :, None] * own[:, None])[vertex]
    across = 2.0 * (own * middle).sum(axis=1) ** 2 / np.maximum((middle**2).sum(axis=1), 1e-300) - 1.0
    mixed = own[:, :, None] * middle[:, None]
    turns = square - mixed - np.swapaxes(mixed, 1, 2) + own[:, :, None] * own[:, None]
    smooth = np.flatnonzero(across > SMOOTH)
    return of[smooth], turns[smooth]


class WorldPlanes:
    """The planes of a cast world, numbered through all surfaces; where they are in one state of it.

    normal, offset, middle, axes: as `Faces` has them, in the world's axes [m]; curved, spread, extent, surface, body:
    of each plane. any_curved: whether any is.
    """

    def __init__(self, world: CastWorld) -> None:
        self._world = world
        faces = [_of_surface(surface) for surface in world.surfaces]
        counts = [len(each.normal) for each in faces]
        self._first = np.cumsum([0, *counts])
        self._faces = faces
        self._triangles = np.cumsum([0, *(len(each.of_triangle) for each in faces)])
        of_triangle = [first + each.of_triangle for first, each in zip(self._first, faces, strict=False)]
        self._of_triangle = np.concatenate(of_triangle or [np.zeros(0)]).astype(np.int64)
        self.surface = np.repeat(np.arange(len(faces), dtype=np.int32), counts)
        self._normal, self._offset, self._middle, self._axes = (
            np.concatenate([getattr(each, name) for each in faces] or [np.zeros(shape)])
            for name, shape in (("normal", (0, 3)), ("offset", 0), ("middle", (0, 3)), ("axes", (0, 2, 3)))
        )
        self.curved, self.spread, self.extent = (
            np.concatenate([getattr(each, name) for each in faces] or [np.zeros(shape, dtype)])
            for name, shape, dtype in (("curved", 0, bool), ("spread", (0, 2, 2), float), ("extent", (0, 2, 2), float))
        )
        self.any_curved = bool(self.curved.any())
        self.body = np.append(world.body_of[self.surface] if len(faces) else [], -1).astype(np.int64)
        self._moving = np.flatnonzero(self.body >= 0)
        self.normal, self.offset = self._normal.copy(), self._offset.copy()
        self.middle, self.axes = self._middle.copy(), self._axes.copy()
        self._poses: np.ndarray = np.zeros((0, 4, 4))
        self._lobes: dict[float, np.ndarray] = {}
        self._numbers: tuple[np.ndarray, np.ndarray] | None = None
        self._seen: dict[frozenset[str], np.ndarray] = {}

    @property
    def columns(self) -> np.ndarray:
        """The normals by axis, (3, p + 1); the last, which `NO_PLANE` finds, is 0."""
        return np.concatenate((self.normal.T, np.zeros((3, 1))), axis=1)

    def heights(self, point: np.ndarray) -> np.ndarray:
        """How far each plane is from a point (3,) [m, world] along its normal, (p + 1,); the last is 0."""
        return np.append(self.offset - self.normal @ point, 0.0)

    @property
    def bodies(self) -> np.ndarray:
        """The poses (b, 4, 4) of the bodies that the planes are placed for."""
        return self._poses

    def lobes(self, wavelength: float) -> np.ndarray:
        """(p, 2, 2) covariances [rad^2] of the lobes of curved faces, in their axes: the spread of the normals, and
        diffraction at the face's size; 0 of other faces.

        Where a face is so small that it and its neighbours are one to the wave, of size e and turn t with e t below
        wavelength / 2, sqrt(wavelength / (2 e t)) of them make up a Fresnel zone and diffract together.
        """
        if wavelength not in self._lobes:
            found = np.zeros((len(self.curved), 2, 2))
            rows = np.flatnonzero(self.curved)
            alone = wavelength**2 / (96.0 * np.pi) * np.linalg.inv(self.extent[rows] + 1e-12 * np.eye(2))
            wide, axes = np.linalg.eigh(alone)
            turned = np.einsum("pia,pij,pja->pa", axes, self.spread[rows], axes) / (2.0 * SPREAD)
            wide = np.where(turned > STRAIGHT**2, np.minimum(wide, np.sqrt(np.maximum(wide * turned, 0))), wide)
            found[rows] = self.spread[rows] + np.einsum("pia,pa,pja->pij", axes, wide, axes)
            self._lobes[wavelength] = found
        return self._lobes[wavelength]

    def at(self, poses: np.ndarray) -> WorldPlanes:
        """Places them for bodies at poses (b, 4, 4) float64 [m]."""
        rows = self._moving
        self._poses = poses
        if len(rows):
            pose = poses[self.body[rows]]
            turn = pose[:, :3, :3]
            self.normal[rows] = np.einsum("pij,pj->pi", turn, self._normal[rows])
            self.axes[rows] = np.einsum("pij,paj->pai", turn, self._axes[rows])
            self.middle[rows] = np.einsum("pij,pj->pi", turn, self._middle[rows]) + pose[:, :3, 3]
            self.offset[rows] = self._offset[rows] + np.einsum("pi,pi->p", self.normal[rows], pose[:, :3, 3])
        return self

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
        """The plane of each of the hits `rows` (k,), (k,) int64; `NO_PLANE` where none is known: of what deforms, and
        where nothing is hit.
        """
        number = hits.number[rows]
        found = np.take(self._table(hits), number, mode="clip")
        if hits.spots is not None:
            unknown = np.flatnonzero((found == NO_PLANE) & (number != NOTHING))
            triangle = hits.spots.triangle[rows][unknown]
            surface = np.take(hits.surface_of, number[unknown])
            rigid = np.flatnonzero((self._world.body_of[surface] >= 0) & ~self._world.deforming[surface])
            found[unknown[rigid]] = self._of_triangle[self._triangles[surface[rigid]] + triangle[rigid]]
        return np.asarray(found)

    def _table(self, hits: Hits) -> np.ndarray:
        """Number of a hit -> plane; `NO_PLANE` where a surface has several."""
        if self._numbers is None or self._numbers[0] is not hits.surface_of:
            surfaces = self._world.surfaces
            static = len(hits.surface_of) - len(surfaces) - 1
            parts = [
                self._first[number] + self._faces[number].of_triangle
                for number in np.unique(hits.surface_of[:static]).tolist()
            ]
            single = [
                int(self._first[number]) if isinstance(surface, Plane) else NO_PLANE
                for number, surface in enumerate(surfaces)
            ]
            table = np.concatenate([*parts, np.array([*single, NO_PLANE])]).astype(np.int64)
            self._numbers = hits.surface_of, table
        return self._numbers[1]


def planes_of(world: CastWorld) -> WorldPlanes:
    """The planes of a cast world, worked out once."""
    found: WorldPlanes | None = world.cache.get("planes")
    if found is None:
        found = world.cache["planes"] = WorldPlanes(world)
    return found


def _of_surface(surface: Mesh | Plane) -> Faces:
    if isinstance(surface, Mesh):
        if len(surface.triangles):
            return _FACES.of(np.asarray(surface.vertices, np.float64), np.asarray(surface.triangles, np.int64))
        normal, offset, middle = np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3))
    else:
        normal = np.asarray(surface.normal, np.float64)[None]
        middle = np.asarray(surface.origin, np.float64)[None]
        offset = (normal * middle).sum(axis=1)
    count = len(normal)
    square = np.zeros((count, 2, 2))
    return Faces(np.zeros(0, np.int32), normal, offset, middle, _axes(normal), np.zeros(count, bool), square, square)
