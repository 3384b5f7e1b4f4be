"""The flat faces of everything that rays can hit: what a wave needs to know of the surface that a ray has met.

Rays find what is lit; where a wave goes on and with which phase is worked out on the planes of the triangles, in
float64, since float32 hits are off by more than the phase of a millimetre wave allows.
"""

from __future__ import annotations

import numpy as np

from graph.sim.geometry.surfaces import Mesh, Plane
from sensors.compiled import compiled
from sensors.raycast.rays import NOTHING, Hits
from sensors.raycast.standing import excluded
from sensors.raycast.world import CastWorld

from .faces import FACES_BY_CONTENT, SPREAD, Faces, patches, plane_axes

NO_PLANE = -1

FADED = 20.0
"""Squared angle from the middle of a lobe, over the lobe's variance, beyond which it counts no more (e^-10)."""

STRAIGHT = 1e-3
"""Turn to the neighbours [rad] up to which a curved surface is straight along a direction."""


class WorldPlanes:
    """The planes of a cast world, numbered through all surfaces; where they are in one state of it.

    normal, offset, middle, axes: as `Faces` has them, in the world's axes [m]; curved, spread, extent, bend, surface,
    body: of each plane. patch: (p,), the first plane of the flat patch that it is part of. any_curved: whether any is.
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
        self.curved = np.concatenate([each.curved for each in faces] or [np.zeros(0, bool)])
        self.spread, self.extent, self.bend = (
            np.concatenate([getattr(each, name) for each in faces] or [np.zeros((0, 2, 2))])
            for name in ("spread", "extent", "bend")
        )
        self.any_curved = bool(self.curved.any())
        self.body = np.append(world.body_of[self.surface] if len(faces) else [], -1).astype(np.int64)
        low, high = (
            np.concatenate([getattr(each, end) for each in faces] or [np.zeros((0, 3))]) for end in ("low", "high")
        )
        self.patch = patches(self._normal, self._offset, self.body[:-1], low, high)
        self._moving = np.flatnonzero(self.body >= 0)
        self.normal, self.offset = self._normal.copy(), self._offset.copy()
        self.middle, self.axes = self._middle.copy(), self._axes.copy()
        self._poses: np.ndarray = np.zeros((0, 4, 4))
        self._lobes: dict[float, np.ndarray] = {}
        self._straight: dict[float, np.ndarray] = {}
        self._widths: dict[float, tuple[np.ndarray, ...]] = {}
        self._numbers: tuple[np.ndarray, np.ndarray] | None = None
        self._seen: dict[frozenset[str], np.ndarray] = {}

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
            flat = turned <= STRAIGHT**2
            bare = flat & ~flat[:, ::-1]
            along = np.zeros((len(self.curved), 2))
            along[rows] = np.einsum("pia,pa->pi", axes, bare / np.sqrt(2.0 * np.pi * wide))
            self._straight[wavelength], self._lobes[wavelength] = along, found
        return self._lobes[wavelength]

    def straight(self, wavelength: float) -> np.ndarray:
        """(p, 2) vectors in the axes of faces, along which a curved surface is straight: of length 2 L / wavelength for
        a face of length L, so that its lobe is sinc squared of their product with the sines off the normal; else 0.
        """
        self.lobes(wavelength)
        return self._straight[wavelength]

    def widths(self, wavelength: float) -> tuple[np.ndarray, ...]:
        """Squared angles (p,) [rad^2] from a face's normal within which its surface may send anything, (p,) squares of
        how much it bends [rad^2/m^2], and of the length [m^2] along which it is straight, else 0.
        """
        if wavelength not in self._widths:
            bend = (self.bend**2).sum(axis=(1, 2))
            lobes, size = (np.trace(each, axis1=1, axis2=2) for each in (self.lobes(wavelength), self.extent))
            straight = (self.straight(wavelength) ** 2).sum(axis=1) * (wavelength / 2.0) ** 2
            self._widths[wavelength] = FADED * lobes + 6.0 * bend * size, bend, straight
        return self._widths[wavelength]

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
        """The plane of each of the hits `rows` (k,), (k,) int32; `NO_PLANE` where none is known: of what deforms, and
        where nothing is hit.
        """
        number = hits.number[rows]
        found = np.empty(len(number), np.int32)
        _look_up(self._table(hits), number, found)
        if hits.spots is not None:
            unknown = np.flatnonzero((found == NO_PLANE) & (number != NOTHING))
            triangle = hits.spots.triangle[rows][unknown]
            surface = np.take(hits.surface_of, number[unknown])
            rigid = np.flatnonzero((self._world.body_of[surface] >= 0) & ~self._world.deforming[surface])
            found[unknown[rigid]] = self._of_triangle[self._triangles[surface[rigid]] + triangle[rigid]]
        return found

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
            table = np.concatenate([*parts, np.array([*single, NO_PLANE])]).astype(np.int32)
            self._numbers = hits.surface_of, table
        return self._numbers[1]


@compiled
def _look_up(table: np.ndarray, number: np.ndarray, found: np.ndarray) -> None:
    """The entries of a table by their numbers (k,); those beyond it find the last."""
    last = len(table) - 1
    for row in range(len(number)):
        found[row] = table[min(int(number[row]), last)]


def planes_of(world: CastWorld) -> WorldPlanes:
    """The planes of a cast world, worked out once."""
    found: WorldPlanes | None = world.cache.get("planes")
    if found is None:
        found = world.cache["planes"] = WorldPlanes(world)
    return found


def _of_surface(surface: Mesh | Plane) -> Faces:
    if isinstance(surface, Mesh):
        if len(surface.triangles):
            return FACES_BY_CONTENT.of(
                np.asarray(surface.vertices, np.float64), np.asarray(surface.triangles, np.int64)
            )
        normal, offset, middle = np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3))
    else:
        normal = np.asarray(surface.normal, np.float64)[None]
        middle = np.asarray(surface.origin, np.float64)[None]
        offset = (normal * middle).sum(axis=1)
    count = len(normal)
    square, axes, curved = np.zeros((count, 2, 2)), plane_axes(normal), np.zeros(count, bool)
    return Faces(np.zeros(0, np.int32), normal, offset, middle, axes, curved, square, square, square, middle, middle)
