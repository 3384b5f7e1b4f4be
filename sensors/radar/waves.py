"""Rays of a radar on their way: the faces they meet, one after the other.

Each ray is a tube that fills a solid angle. Where it goes is worked out in float64 on the planes of the faces: float32
hits are off by more than the phase of a millimetre wave allows. Flat faces reflect tubes as mirrors do; curved and
rough ones end them. After mirrors a ray goes on as if it came from the radar's image in them, so that the length of its
way is that to one plane.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from graph.sim.geometry.surfaces import Mesh
from sensors.motion.velocities import Velocities
from sensors.raycast.rays import Hits, RayBundle
from sensors.raycast.world import CastWorld

from .antenna import Antenna
from .grouping import Groups
from .materials import Reflections
from .planes import NO_PLANE, WorldPlanes
from .rays import Tubes

GRAZING = 1e-6
"""Cosine of incidence below which a face is not met."""

FAINTEST = 0.02
"""Amplitude, of what was sent, below which a wave is not followed."""

LIFT_M = 2e-4
"""Reflected rays start so high above the face that they leave."""

SIGHT_M = 5e-3
"""A point is in sight if a ray to it comes so near."""

_MIX = np.uint64(0x9E3779B97F4A7C15)
_OWN = 1 << 40


@dataclass(slots=True)
class Setting:
    """What waves travel in, in one state.

    pose: (4, 4) float64 sensor to world [m]. poses: the state, for the caster (None: now). reach: farthest range [m].
    bounces: most faces on a way. exclude: prims that are not there.
    """

    world: CastWorld
    planes: WorldPlanes
    reflections: Reflections
    velocities: Velocities
    antenna: Antenna
    reach: float
    bounces: int
    pose: np.ndarray
    poses: Any = None
    exclude: frozenset[str] = frozenset()

    @property
    def seen(self) -> float:
        """Beyond this distance from the radar [m] nothing counts: a way there and back is longer than its range."""
        return self.reach * 1.01

    @property
    def rotation(self) -> np.ndarray:
        """(3, 3) sensor to world."""
        return self.pose[:3, :3]


@dataclass(frozen=True, slots=True)
class Images:
    """The radar as mirrors show it, one image for each order of faces that tubes have met; c of them.

    place: (c, 3) float64 from the radar [m], world axes. turn: (c, 3, 3), what the mirrors make of directions. key:
    (c,) uint64 of the faces, whatever their order.
    """

    place: np.ndarray
    turn: np.ndarray
    key: np.ndarray

    @classmethod
    def none(cls) -> Images:
        """The radar itself."""
        return cls(np.zeros((1, 3)), np.eye(3)[None], np.zeros(1, np.uint64))

    def beyond(self, image: np.ndarray, normal: np.ndarray, height: np.ndarray, plane: np.ndarray) -> Images:
        """The images of some of them, by their numbers, in planes: normals (m, 3) and heights (m,) over the radar."""
        place, turn = self.place[image], self.turn[image]
        away = height - (normal * place).sum(axis=1)
        return Images(
            place + 2.0 * away[:, None] * normal,
            turn - 2.0 * normal[:, :, None] * np.einsum("ci,cij->cj", normal, turn)[:, None],
            self.key[image] + _plane_key(plane),
        )


@dataclass(slots=True)
class _Rows:
    """Columns (k,) and vectors (3, k) of k rows; None where a column is absent."""

    def at(self, rows: np.ndarray, taken: dict[int, np.ndarray] | None = None) -> Any:
        """Some of the rows, (m,). An array that serves two columns still does; taken: what was taken of them so far."""
        taken = {} if taken is None else taken
        found: dict[str, Any] = {}
        for each in fields(self):
            one = getattr(self, each.name)
            if isinstance(one, _Rows):
                one = one.at(rows, taken)
            elif isinstance(one, np.ndarray):
                if id(one) not in taken:
                    taken[id(one)] = _taken(one, rows)
                one = taken[id(one)]
            found[each.name] = one
        return type(self)(**found)


@dataclass(slots=True)
class Waves(_Rows):
    """Tubes before a stretch of their way; k of them, vectors (3, k) float64 in the world's axes [m].

    row: (k,) of the tube. direction: of the stretch. travelled: [m]. field: what the faces left of it, complex64.
    rate: of the way so far [m/s], None for 0. image: (k,) number of the radar's image that they come from, None before
    the first face.
    """

    row: np.ndarray
    direction: np.ndarray
    images: Images
    travelled: np.ndarray | None = None
    field: np.ndarray | None = None
    rate: np.ndarray | None = None
    image: np.ndarray | None = None

    def left(self, coherent: np.ndarray) -> np.ndarray:
        """What is left (k,) complex64 of the waves after one more face, by its reflection (k,)."""
        return coherent if self.field is None else self.field * coherent


@dataclass(slots=True)
class Met(_Rows):
    """Faces that waves meet: k of them, vectors (3, k).

    way: [m] in all. back: unit from the radar to it, out: [m] of that. plane: its number, `NO_PLANE` where it is not
    known. normal: of the plane. slope: its component along the wave. table: place in the reflection tables. speed: of
    the point as the radar sees it [m/s], None where nothing moves.
    """

    waves: Waves
    way: np.ndarray
    back: np.ndarray
    out: np.ndarray
    plane: np.ndarray
    normal: np.ndarray
    slope: np.ndarray
    cosine: np.ndarray
    table: np.ndarray
    speed: np.ndarray | None

    def __len__(self) -> int:
        return len(self.way)

    @property
    def range_m(self) -> np.ndarray:
        """Half the way (k,) [m] there and straight back."""
        return self.way if self.out is self.way else np.asarray((self.way + self.out) / 2.0)

    def rate(self) -> np.ndarray:
        """Half the rate (k,) [m/s] of the way in and straight back."""
        return self._rates(self.back, 2.0)

    def rate_again(self) -> np.ndarray:
        """The rate (k,) [m/s] of the way in, which is also the way back."""
        return self._rates(None, 1.0)

    def _rates(self, back: np.ndarray | None, share: float) -> np.ndarray:
        before = self.waves.rate
        if self.speed is None:
            return np.broadcast_to(0.0, len(self)) if before is None else before / share
        rate = dot(self.speed, self.waves.direction)
        if back is self.waves.direction:
            rate *= 2.0
        elif back is not None:
            rate += dot(self.speed, back)
        if before is not None:
            rate += before
        return np.asarray(rate / share)


def first_waves(
    setting: Setting, tubes: Tubes, bundle: RayBundle, skip: np.ndarray | None, directions: np.ndarray
) -> tuple[Waves, Hits, np.ndarray]:
    """Waves as tubes leave the radar, what they meet, and the rows (k,) of those that meet anything.

    The bundle has the tubes' rays; directions: (3, n) float64, of them in the world's axes. skip: (s,) bool, surfaces
    that tubes do not meet first; None: they first meet the surface that owns them, or nothing.
    """
    hits = _cast(setting, bundle)
    row = np.flatnonzero(hits.distance < setting.seen)
    if skip is None:
        row = row[np.take(tubes.owner, row) == hits.surfaces(row)]
    elif skip.any():
        row = row[~np.take(skip, hits.surfaces(row))]
    return Waves(np.arange(len(tubes.solid)), directions, Images.none()), hits, row


def next_waves(setting: Setting, parts: list[tuple[Waves, np.ndarray]]) -> tuple[Waves, Hits, np.ndarray]:
    """The same after a reflection; parts: what `reflected` gives."""
    waves, start = _together(parts)
    hits = _cast_on(setting, waves.direction, start)
    assert waves.travelled is not None
    return waves, hits, np.flatnonzero(hits.distance < 2.0 * setting.reach - waves.travelled)


def in_sight(setting: Setting, out: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Whether the radar sees points (3, k) [m from it] at distances (k,), in unit directions (3, k)."""
    bundle = RayBundle(setting.pose[:3, 3], _table(back), exclude=setting.exclude, reach=setting.seen)
    hits = setting.world.cast(bundle, setting.poses)
    return np.asarray(hits.distance > out * (1 - 1e-6) - SIGHT_M)


def tangents(setting: Setting, tubes: Tubes, waves: Waves) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors (3, k) across and up of tubes, mirrored as the waves were."""
    both = [setting.rotation @ one for one in tubes.tangents(waves.row)]
    if waves.image is not None:
        turn = np.take(waves.images.turn, waves.image, axis=0)
        both = [np.einsum("kij,jk->ik", turn, one) for one in both]
    return both[0], both[1]


def face_keys(met: Met) -> np.ndarray:
    """(k,) uint64 of the faces on the way, whatever their order; unknown faces are like no other."""
    key = _plane_key(np.where(met.plane != NO_PLANE, met.plane, met.waves.row + _OWN))
    waves = met.waves
    return key if waves.image is None else np.asarray(key + np.take(waves.images.key, waves.image))


def meet(setting: Setting, waves: Waves, hits: Hits, row: np.ndarray) -> Met:
    """The faces that waves meet; row: (k,) the hits of the waves."""
    origin, planes, image = setting.pose[:3, 3], setting.planes, waves.image
    place = None if image is None else np.stack([np.take(c, image) for c in waves.images.place.T])

    def near(some: Any = slice(None)) -> np.ndarray:
        """Where some of the hits are by their distance, (3, m) from the radar."""
        length = hits.distance[row[some]].astype(np.float64)
        if place is None or waves.travelled is None:
            return np.asarray(waves.direction[:, some] * length)
        return np.asarray(place[:, some] + waves.direction[:, some] * (waves.travelled[some] + length))

    plane = planes.of_hits(hits, row)
    unknown = np.flatnonzero(plane == NO_PLANE)
    normal = np.stack([np.take(column, plane) for column in planes.columns])  # the last is that of no plane
    height = np.take(planes.heights(origin), plane)
    if len(unknown):
        assert hits.normals is not None
        normal[:, unknown] = hits.normals[row[unknown]].T
        height[unknown] = dot(normal[:, unknown], near(unknown))
    slope = dot(normal, waves.direction)
    if place is not None:
        height -= dot(normal, place)
    with np.errstate(divide="ignore", invalid="ignore"):
        way = height / slope
    cosine = np.abs(slope)
    before = 0.0 if waves.travelled is None else waves.travelled
    kept = (cosine > GRAZING) & (way > before) & (way < 2 * setting.reach)
    out, back = way, waves.direction
    if place is not None:
        point = waves.direction * way
        point += place
        out = np.sqrt(dot(point, point))
        back = point / np.maximum(out, 1e-9)
    surface = hits.surfaces(row)
    met = Met(waves, way, back, out, plane, normal, slope, cosine, setting.reflections.index(surface, cosine), None)
    if not kept.all():
        keep = np.flatnonzero(kept)
        met, surface, row = met.at(keep), surface[keep], row[keep]
    met.speed = _speeds(setting, surface, met)
    deforming = np.flatnonzero(setting.world.deforming[surface])
    if len(deforming):
        speed = np.zeros((3, len(surface))) if met.speed is None else met.speed
        speed[:, deforming] += _speeds_within(setting, surface[deforming], hits, row[deforming])
        met.speed = speed
    return met


def _speeds(setting: Setting, surface: np.ndarray, met: Met) -> np.ndarray | None:
    def levers() -> np.ndarray:
        return np.asarray(met.back * met.out, np.float32)

    measured = setting.velocities(surface, levers, setting.pose[:3, 3], setting.poses)
    if measured is None:
        return None
    rows, speeds = measured
    if len(rows) == len(surface):
        return np.ascontiguousarray(speeds.T, np.float64)
    found = np.zeros((3, len(surface)))
    for column, speed in zip(found, speeds.T, strict=True):
        column[rows] = speed
    return found


def _speeds_within(setting: Setting, surface: np.ndarray, hits: Hits, row: np.ndarray) -> np.ndarray:
    """Velocities (3, k) of points on meshes that deform: those of the triangles' corners, by their shares."""
    assert hits.spots is not None
    found = np.zeros((3, len(row)))
    for number in np.unique(surface).tolist():
        some = np.flatnonzero(surface == number)
        mesh, spot = setting.world.surfaces[number], hits.spots
        assert isinstance(mesh, Mesh)
        corners = np.asarray(mesh.triangles)[spot.triangle[row[some]]]
        second, third = spot.uv[row[some]].T.astype(np.float64)
        velocities = setting.world.vertex_velocities(number, setting.poses)[corners]
        shares = np.stack((1.0 - second - third, second, third), 1)
        found[:, some] = np.einsum("kc,kcj->jk", shares, velocities)
    return found


def reflected(setting: Setting, tubes: Tubes, met: Met) -> tuple[Waves, np.ndarray]:
    """Waves after flat faces, as far as they are not too faint, and where they start (3, m) from the radar."""
    planes = setting.planes
    flat = met.plane != NO_PLANE
    if planes.any_curved:
        flat &= ~planes.curved[met.plane]
    if met.waves.image is None:
        flat &= tubes.leads[met.waves.row]
    rows = np.flatnonzero(flat)
    before = met.waves.field
    left = setting.reflections.coherent(met.table[rows])
    if before is not None:
        left = left * before[rows]
    strong = np.flatnonzero(np.abs(left) > FAINTEST)
    met, left = met.at(rows[strong]), left[strong]
    waves = met.waves
    number = met.plane.astype(np.int64)
    if waves.image is not None:
        number += waves.image * len(planes.normal)
    groups = Groups(number)
    image, plane = np.divmod(groups.keys, len(planes.normal))
    images = waves.images.beyond(image, planes.normal[plane], planes.heights(setting.pose[:3, 3])[plane], plane)
    direction = waves.direction - 2.0 * met.slope * met.normal
    rate = waves.rate
    if met.speed is not None:
        rate = dot(met.speed, waves.direction) - dot(met.speed, direction) + (0.0 if rate is None else rate)
    return Waves(waves.row, direction, images, met.way, left, rate, groups.which), met.back * met.out


def _together(parts: list[tuple[Waves, np.ndarray]]) -> tuple[Waves, np.ndarray]:
    """Waves of several blocks, after a reflection, and their starts (3, k), as one."""
    if len(parts) == 1:
        return parts[0]
    waves = [wave for wave, _ in parts]
    moves = any(wave.rate is not None for wave in waves)
    images = [wave.images for wave in waves]
    offsets = np.cumsum([0, *(len(each.key) for each in images)])
    found = Waves(
        np.concatenate([wave.row for wave in waves]),
        np.concatenate([wave.direction for wave in waves], axis=1),
        Images(*(np.concatenate([getattr(each, one.name) for each in images]) for one in fields(Images))),
        np.concatenate([wave.travelled for wave in waves]),
        np.concatenate([wave.field for wave in waves]),
        np.concatenate([np.zeros(len(w.row)) if w.rate is None else w.rate for w in waves]) if moves else None,
        np.concatenate([wave.image + offset for wave, offset in zip(waves, offsets, strict=False)]),
    )
    return found, np.concatenate([start for _, start in parts], axis=1)


def _cast_on(setting: Setting, direction: np.ndarray, start: np.ndarray) -> Hits:
    """What waves meet next."""
    offsets = np.empty((len(start[0]), 3), np.float32)
    for axis in range(3):
        offsets[:, axis] = start[axis] + LIFT_M * direction[axis]
    bundle = RayBundle(setting.pose[:3, 3], _table(direction), offsets, setting.exclude, setting.seen)
    return _cast(setting, bundle)


def _cast(setting: Setting, bundle: RayBundle) -> Hits:
    return setting.world.cast(bundle, setting.poses, normals=True, spots=setting.planes.by_spots)


def _table(direction: np.ndarray) -> np.ndarray:
    """The table of rays in these directions (3, k)."""
    table = np.empty((direction.shape[1], 6), np.float32)
    for axis in range(3):
        table[:, 3 + axis] = direction[axis]
    return table


def _plane_key(plane: np.ndarray) -> np.ndarray:
    return np.asarray((plane.astype(np.uint64) + np.uint64(1)) * _MIX)


def _taken(array: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Some rows of (k,) or of vectors (3, k)."""
    if array.ndim == 1:
        return np.take(array, rows)
    found = np.empty((len(array), len(rows)), array.dtype)
    for column, out in zip(array, found, strict=True):
        np.take(column, rows, out=out)
    return found


def dot(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Dot products (k,) of vectors (3, k)."""
    total = one[0] * two[0]
    total += one[1] * two[1]
    total += one[2] * two[2]
    return np.asarray(total)
