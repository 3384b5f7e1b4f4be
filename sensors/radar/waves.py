"""Rays of a radar on their way: the faces they meet, one after the other.

Each ray is a tube that fills a solid angle. Where it goes is worked out in float64 on the planes of the faces: float32
hits are off by more than the phase of a millimetre wave allows. Flat faces reflect tubes as mirrors do; curved and
rough ones end them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from sensors.motion.velocities import Velocities
from sensors.raycast.rays import Hits, RayBundle
from sensors.raycast.world import CastWorld

from .antenna import Antenna
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


@dataclass(slots=True)
class Waves:
    """Tubes before a stretch of their way; k of them, vectors (3, k) float64 in the world's axes, from the radar [m].

    row: of the tube. start, direction: of the stretch. across, up: the tube's tangents, mirrored as it was. travelled:
    [m]. field: what the faces left of it, complex. key: (k,) uint64, of the faces. rate: of the way [m/s].
    """

    row: np.ndarray
    start: np.ndarray
    direction: np.ndarray
    across: np.ndarray
    up: np.ndarray
    travelled: np.ndarray
    field: np.ndarray
    key: np.ndarray
    rate: np.ndarray

    def at(self, rows: np.ndarray) -> Waves:
        """Some of them."""
        return Waves(*(_rows(getattr(self, each.name), rows) for each in fields(Waves)))


@dataclass(slots=True)
class Met:
    """Faces that waves meet: k of them, vectors (3, k).

    length: [m] of the stretch, way: in all. back: unit from the radar to it, out: [m] of that. normal: towards
    where the wave comes from. table: place in the reflection tables. speed: of the point as the radar sees it [m/s],
    None where nothing moves.
    """

    waves: Waves
    length: np.ndarray
    way: np.ndarray
    back: np.ndarray
    out: np.ndarray
    plane: np.ndarray
    normal: np.ndarray
    cosine: np.ndarray
    table: np.ndarray
    speed: np.ndarray | None

    def at(self, rows: np.ndarray) -> Met:
        """Some of them."""
        found: dict[str, Any] = {each.name: getattr(self, each.name) for each in fields(Met)[1:]}
        for name, one in found.items():
            found[name] = None if one is None else _rows(one, rows)
        return Met(self.waves.at(rows), **found)

    @property
    def point(self) -> np.ndarray:
        """Where, (3, k), from the radar [m]."""
        return np.asarray(self.waves.start + self.waves.direction * self.length)

    def rate(self) -> np.ndarray:
        """Half the rate (k,) [m/s] of the way in and straight back."""
        if self.speed is None:
            return self.waves.rate / 2.0
        return np.asarray((self.waves.rate + _dot(self.speed, self.waves.direction + self.back)) / 2.0)


def met_faces(setting: Setting, tubes: Tubes, bundle: RayBundle, skip: np.ndarray | None = None) -> Iterator[Met]:
    """The faces that tubes meet, whose rays are those of the bundle: first ones, then those after each reflection.

    skip: (s,) bool, surfaces that only the tubes meet that own them.
    """
    hits = setting.world.cast(bundle, setting.poses, normals=True)
    row = np.flatnonzero(hits.distance < setting.reach * 1.01)
    if skip is not None and skip.any():
        surface, owner = hits.surfaces(row), tubes.owner[row]
        row = row[np.where(owner < 0, ~np.take(skip, surface), owner == surface)]
    direction = setting.pose[:3, :3] @ tubes.directions[:, row]
    zero = np.broadcast_to(0.0, (3, len(row)))
    waves = Waves(
        *(row, zero, direction, zero, zero, zero[0]),
        *(np.broadcast_to(np.complex64(1), len(row)), np.broadcast_to(np.uint64(0), len(row)), zero[0]),
    )
    for bounce in range(1, setting.bounces + 1):
        met = _meet(setting, waves, hits, row, straight=bounce == 1)
        if not len(met.way):
            return
        yield met
        if bounce == setting.bounces:
            return
        waves = _reflected(setting, tubes, met, first=bounce == 1)
        if not len(waves.row):
            return
        hits = _cast_on(setting, waves)
        row = np.flatnonzero(hits.distance < 2.0 * setting.reach)
        waves = waves.at(row)


def in_sight(setting: Setting, out: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Whether the radar sees points (3, k) [m from it] at distances (k,), in unit directions (3, k)."""
    table = np.zeros((len(out), 6), np.float32)
    table[:, 3:6] = back.T
    hits = setting.world.cast(RayBundle(setting.pose[:3, 3], table, exclude=setting.exclude), setting.poses)
    return np.asarray(hits.distance > out * (1 - 1e-6) - SIGHT_M)


def tangents(setting: Setting, tubes: Tubes, waves: Waves, *, first: bool) -> tuple[np.ndarray, np.ndarray]:
    """The tangents of waves (3, k); before the first face those of the tubes."""
    if not first:
        return waves.across, waves.up
    across, up = tubes.tangents(waves.row)
    rotation = setting.pose[:3, :3]
    return rotation @ across, rotation @ up


def _meet(setting: Setting, waves: Waves, hits: Hits, row: np.ndarray, *, straight: bool) -> Met:
    """Where waves meet faces; straight: they come from the radar itself. row: (k,) the hits of the waves."""
    origin = setting.pose[:3, 3]
    distance = hits.distance[row].astype(np.float64)
    near = waves.start + waves.direction * distance
    planes = setting.planes
    plane = planes.of_hits(hits, row, lambda some: near[:, some].T + origin)
    known = plane != NO_PLANE
    normal = np.stack([np.take(column, np.maximum(plane, 0)) for column in planes.columns])
    height = planes.offset[np.maximum(plane, 0)] - origin @ normal
    if not known.all():
        assert hits.normals is not None
        unknown = np.flatnonzero(~known)
        normal[:, unknown] = hits.normals[row[unknown]].T
        height[unknown] = _dot(normal[:, unknown], near[:, unknown])
    slope = _dot(normal, waves.direction)
    if not straight:
        height = height - _dot(normal, waves.start)
    with np.errstate(divide="ignore", invalid="ignore"):
        length = height / slope
    way = length if straight else waves.travelled + length
    keep = np.flatnonzero((np.abs(slope) > GRAZING) & (length > 0) & (way < 2 * setting.reach))
    if len(keep) < len(way):
        waves, plane, row, normal = waves.at(keep), plane[keep], row[keep], normal[:, keep]
        length, way, slope = length[keep], way[keep], slope[keep]
    out, back = length, waves.direction
    if not straight:
        point = waves.start + waves.direction * length
        out = np.sqrt(_dot(point, point))
        back = point / np.maximum(out, 1e-9)
    surface = hits.surfaces(row)
    cosine = np.abs(slope)
    normal *= -np.sign(slope)
    table = setting.reflections.index(surface, cosine)
    met = Met(waves, length, way, back, out, plane, normal, cosine, table, None)
    met.speed = _speeds(setting, surface, met)
    return met


def _speeds(setting: Setting, surface: np.ndarray, met: Met) -> np.ndarray | None:
    measured = setting.velocities(surface, lambda: met.point.astype(np.float32), setting.pose[:3, 3], setting.poses)
    if measured is None:
        return None
    rows, speeds = measured
    found = np.zeros((3, len(surface)))
    found[:, rows] = speeds.T
    return found


def _reflected(setting: Setting, tubes: Tubes, met: Met, *, first: bool) -> Waves:
    """Waves after flat faces, as far as they are not too faint."""
    left = met.waves.field * setting.reflections.coherent(met.table)
    flat = (met.plane != NO_PLANE) & ~setting.planes.curved[np.maximum(met.plane, 0)]
    if first:
        flat &= tubes.leads[met.waves.row]
    keep = np.flatnonzero(flat & (np.abs(left) > FAINTEST))
    met = met.at(keep)
    waves = met.waves
    across, up = tangents(setting, tubes, waves, first=first)
    direction = _mirrored(waves.direction, met.normal)
    rate = waves.rate
    if met.speed is not None:
        rate = rate + _dot(met.speed, waves.direction - direction)
    return Waves(
        waves.row,
        met.point,
        direction,
        _mirrored(across, met.normal),
        _mirrored(up, met.normal),
        met.way,
        left[keep],
        face_keys(met),
        rate,
    )


def face_keys(met: Met) -> np.ndarray:
    """(k,) uint64 of the faces on the way, whatever their order; unknown faces are like no other."""
    number = np.where(met.plane != NO_PLANE, met.plane, met.waves.row + _OWN).astype(np.uint64)
    return np.asarray(met.waves.key + (number + np.uint64(1)) * _MIX)


def _cast_on(setting: Setting, waves: Waves) -> Hits:
    """What waves meet next."""
    table = np.zeros((len(waves.row), 6), np.float32)
    table[:, 3:6] = waves.direction.T
    offsets = (waves.start + LIFT_M * waves.direction).T.astype(np.float32)
    bundle = RayBundle(setting.pose[:3, 3], table, offsets, setting.exclude)
    return setting.world.cast(bundle, setting.poses, normals=True)


def _rows(array: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Some rows of (..., k); one value for all stays one."""
    if array.strides[-1] == 0:
        return np.broadcast_to(array[..., :1], (*array.shape[:-1], len(rows)))
    return np.take(array, rows, axis=-1)


def _mirrored(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    return np.asarray(vectors - 2.0 * _dot(vectors, normal) * normal)


def _dot(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Dot products (k,) of vectors (3, k)."""
    return np.asarray(one[0] * two[0] + one[1] * two[1] + one[2] * two[2])
