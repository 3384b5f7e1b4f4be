"""What waves meet after a reflection, what comes back of it, and what is sent on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sensors.compiled import compiled
from sensors.raycast.rays import NOTHING, Hits, RayBundle

from .bins import Bins
from .grouping import Sums
from .images import Images
from .planes import NO_PLANE
from .rays import Tubes
from .scattering import MIRROR, Arrivals, Fields, arrived, reflect_back, scatter_again, scatter_back
from .setting import Faces, Setting, Space, with_hits
from .waves import MET, Met, Sent, Waves, dot, meets, row_of, sends_on, wave_of, write

SIGHT_M = 5e-3
"""A point is in sight if a ray to it comes so near."""


class Facing(NamedTuple):
    """Faces ahead that send something straight back if nothing is in between, m of them.

    wave, face: (m,) int64, their numbers. mirrors: (m,) bool, those that are flat and near a mirror reflection. curved:
    (m,) int64, place among the curved faces that are met, -1 of others. out: (m,) [m] from the radar; rays: (m, 6)
    float32, there; back: (m, 3) float32, the same in the sensor's axes.
    """

    wave: np.ndarray
    face: np.ndarray
    mirrors: np.ndarray
    curved: np.ndarray
    out: np.ndarray
    rays: np.ndarray
    back: np.ndarray

    @classmethod
    def room(cls, count: int) -> Facing:
        """For so many faces."""
        wave, face, curved = np.empty((3, count), np.int64)
        rays, back = np.empty((count, 6), np.float32), np.empty((count, 3), np.float32)
        return cls(wave, face, np.empty(count, bool), curved, np.empty(count), rays, back)

    def first(self, count: int) -> Facing:
        """So many of them."""
        return Facing(*(each[:count] for each in self))


@dataclass(slots=True)
class Again:
    """What some waves meet after a reflection: what comes back the way that they came, what goes on, what is curved,
    and what of it the radar may see.
    """

    scattered: Sums
    sent: Sent
    curved: Met
    facing: Facing


class AgainRoom(NamedTuple):
    """Room for what some waves meet after a reflection; met: (k,) of `MET`, the curved faces."""

    scattered: Sums
    sent: Sent
    met: np.ndarray
    facing: Facing

    @classmethod
    def of(cls, setting: Setting, bounce: int, count: int) -> AgainRoom:
        """For so many waves before that face; made by the main thread, whose memory is used again."""
        met = np.empty(count if setting.planes.any_curved else 0, MET)
        sent = Sent.room(count if bounce < setting.bounces else 0)
        return cls(Sums.room(count), sent, met, Facing.room(count))


def again(setting: Setting, tubes: Tubes, waves: Waves, hits: Hits, part: slice, bins: Bins, room: AgainRoom) -> Again:
    """What some waves meet, and what becomes of them."""
    faces, face = _faces(setting, tubes, waves, hits, part)
    distance, images, goes_on = hits.distance[part], waves.images, waves.bounce < setting.bounces
    space = setting.space(faces)
    on, bent, ahead = _again(waves.each, part.start, distance, face, images, tubes, space, bins, goes_on, room)
    curved = Met(waves.bounce, images, faces, room.met[:bent])
    return Again(room.scattered, room.sent.first(on), curved, room.facing.first(ahead))


def in_sight(setting: Setting, facing: Sequence[Facing]) -> list[np.ndarray]:
    """Whether the radar sees faces, (m,) bool each."""
    ends = np.cumsum([0, *(len(each.out) for each in facing)])
    if not ends[-1]:
        return [np.zeros(0, bool)] * len(facing)
    rays, out = (np.concatenate([getattr(each, name) for each in facing]) for name in ("rays", "out"))
    bundle = RayBundle(setting.pose[:3, 3], rays, exclude=setting.exclude, reach=setting.seen)
    seen = setting.world.cast(bundle, setting.poses).distance > out * (1 - 1e-6) - SIGHT_M
    return np.split(seen, ends[1:-1])


def straight_back(
    setting: Setting, tubes: Tubes, waves: Waves, met: Met, facing: Facing, seen: np.ndarray, bins: Bins
) -> tuple[Sums, Arrivals]:
    """What comes straight back of faces that are seen; met: with their faces; seen: (m,) bool."""
    count = len(facing.wave)
    gains = setting.antenna.gains(facing.back.T)
    sums, fields = Sums.room(2 * count), Fields.room(count)
    space = setting.space(met.faces)
    count = _straight_back(waves.each, facing, seen, *gains, waves.images, tubes, space, bins, sums, fields)
    return sums, arrived(fields.first(count))


def _faces(setting: Setting, tubes: Tubes, waves: Waves, hits: Hits, part: slice) -> tuple[Faces, np.ndarray]:
    """The faces that waves may meet, and the number (k,) of that which each of some meets."""
    plane = setting.planes.of_hits(hits, part)
    if not setting.deforms:
        return setting.faces, plane
    single = np.flatnonzero((plane == NO_PLANE) & (hits.number[part] != NOTHING))
    some, rows = waves.each[part][single], single + part.start
    images, image = waves.images, some["image"]
    direction = np.einsum("kij,jk->ki", images.turn[image], tubes.directions[:, some["row"]])
    length = hits.distance[rows] + some["travelled"]
    point = images.place[image] + direction * length[:, None]
    face, faces = with_hits(setting, plane, hits, rows, single, point)
    return faces, face


@compiled
def _again(
    waves: np.ndarray,
    first: int,
    distance: np.ndarray,
    face: np.ndarray,
    images: Images,
    tubes: Tubes,
    space: Space,
    bins: Bins,
    goes_on: bool,
    room: AgainRoom,
) -> tuple[int, int, int]:
    """Writes what is sent on of waves (k,) from `first` on, the curved faces that are met, and what faces the radar;
    counts each. distance: (k,) [m], to their hits; face: (k,) that are met there.
    """
    facing = room.facing
    on = bent = ahead = 0
    for at in range(len(face)):
        if not distance[at] < space.longest - waves[first + at].travelled:
            continue
        wave = wave_of(waves, first + at, tubes, images)
        touch = meets(space, images, wave, face[at])
        if touch.way <= 0:
            continue
        scatter_again(space, tubes, wave, touch, bins, room.scattered)
        if goes_on and sends_on(space, wave, touch, room.sent, on):
            on += 1
        curved = touch.face < space.faces.planes and space.faces.curved[touch.face]
        if curved:
            write(room.met, bent, wave, touch)
            bent += 1
        if touch.rise * touch.slope > 0 and touch.back[0] > 0 and touch.way + touch.out < 2.0 * space.seen:
            middle = math.sqrt(max(2.0 + 2.0 * dot(wave.direction, touch.back), 0.0))
            mirror = abs(touch.slope) + abs(touch.rise) > MIRROR * middle
            if mirror or curved or space.tables.diffuse[touch.table] > 0:
                facing.wave[ahead], facing.face[ahead], facing.out[ahead] = first + at, touch.face, touch.out
                facing.mirrors[ahead], facing.curved[ahead] = mirror and not curved, bent - 1 if curved else -1
                for axis in range(3):
                    facing.rays[ahead, 3 + axis] = dot(row_of(space.rotation, axis), touch.back)
                    facing.back[ahead, axis] = touch.back[axis]
                ahead += 1
    return on, bent, ahead


@compiled
def _straight_back(
    waves: np.ndarray,
    facing: Facing,
    seen: np.ndarray,
    sends: np.ndarray,
    hears: np.ndarray,
    images: Images,
    tubes: Tubes,
    space: Space,
    bins: Bins,
    sums: Sums,
    fields: Fields,
) -> int:
    """Adds what rough faces send straight back, writes the fields of flat ones, and counts these.

    sends, hears: (m,) gains of the ways there.
    """
    count = 0
    for at in range(len(seen)):
        if seen[at]:
            wave = wave_of(waves, facing.wave[at], tubes, images)
            touch = meets(space, images, wave, facing.face[at])
            scatter_back(space, tubes, wave, touch, sends[at], hears[at], bins, sums)
            if facing.mirrors[at] and reflect_back(space, images, tubes, wave, touch, hears[at], fields, count):
                count += 1
    return count
