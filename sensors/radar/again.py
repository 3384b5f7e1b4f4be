"""What waves meet after a reflection, what comes back of it, and what is sent on."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sensors.compiled import compiled
from sensors.raycast.rays import NOTHING, Hits
from sensors.vectors import dot, row_of

from .bins import Bins
from .grouping import Sums
from .planes import NO_PLANE
from .rays import Tubes
from .scattering import MIRROR, Arrivals, Fields, arrived, reflect_back, scatter_again, scatter_back
from .setting import Faces, Setting, Space, with_hits
from .sight import HIDDEN, SIGHT_M, UNKNOWN, Sights, looks
from .waves import MET, Met, Sent, Waves, echo_of, meets, send_on, wave_of, write


class Facing(NamedTuple):
    """Faces ahead that send something straight back if nothing is in between, m of them.

    wave, face: (m,) int64, their numbers. mirrors: (m,) bool, those that are flat and near a mirror reflection. curved:
    (m,) int64, place among the curved faces that are met, -1 of others. out: (m,) [m] from the radar; back: (m, 3)
    float32, the direction there in the sensor's axes. ray: (m,) int64, place among `rays`, -1 of those of which it is
    known that the radar sees them (`sight.looks`). rays: (r, 6) float32, there, as those of a `RayBundle`.
    """

    wave: np.ndarray
    face: np.ndarray
    mirrors: np.ndarray
    curved: np.ndarray
    out: np.ndarray
    back: np.ndarray
    ray: np.ndarray
    rays: np.ndarray

    @classmethod
    def room(cls, count: int) -> Facing:
        """Uninitialised arrays for `count` faces."""
        wave, face, curved, ray = np.empty((4, count), np.int64)
        rays, back = np.empty((count, 6), np.float32), np.empty((count, 3), np.float32)
        return cls(wave, face, np.empty(count, bool), curved, np.empty(count), back, ray, rays)

    def first(self, count: int, rays: int) -> Facing:
        """The first `count` faces and rays, as views."""
        return Facing._make((*(each[:count] for each in self[:-1]), self.rays[:rays]))

    def seen(self, distance: np.ndarray) -> np.ndarray:
        """Whether the radar sees them, (m,) bool; distance: (r,) [m], to what the rays meet."""
        found = self.ray < 0
        asked = np.flatnonzero(~found)
        found[asked] = distance > self.out[asked] * (1 - 1e-6) - SIGHT_M
        return found


class AgainRoom(NamedTuple):
    """Room for what waves may meet after a reflection: what comes back the way that they came, what goes on, the curved
    faces (k,) of `MET`, and what of it all the radar may see.
    """

    scattered: Sums
    sent: Sent
    curved: np.ndarray
    facing: Facing

    @classmethod
    def room(cls, setting: Setting, waves: Waves) -> AgainRoom:
        """For what these meet."""
        count, goes_on = len(waves.each), waves.bounce < setting.bounces
        curved = np.empty(count if setting.planes.any_curved else 0, MET)
        return cls(Sums.room(count), Sent.room(count if goes_on else 0), curved, Facing.room(count))


class Again(NamedTuple):
    """What waves meet after a reflection, as `AgainRoom`; the faces that they may meet."""

    scattered: Sums
    sent: Sent
    curved: Met
    facing: Facing
    faces: Faces


def again(setting: Setting, tubes: Tubes, waves: Waves, hits: Hits, bins: Bins, sights: Sights) -> Again:
    """What waves meet, and what becomes of them."""
    faces, face = _faces(setting, tubes, waves, hits)
    room, space = AgainRoom.room(setting, waves), setting.space(faces)
    sent, bent, *facing = _again(waves, hits.distance, face, tubes, space, bins, sights, room)
    met = Met(waves.bounce, waves.images, setting.faces, room.curved[:bent])
    return Again(room.scattered, room.sent.first(sent), met, room.facing.first(*facing), faces)


def straight_back(
    setting: Setting, tubes: Tubes, waves: Waves, found: Again, seen: np.ndarray, bins: Bins
) -> tuple[Sums, Arrivals]:
    """What comes straight back of faces that are seen; seen: (m,) bool."""
    facing, count = found.facing, len(found.facing.wave)
    gains = setting.antenna.gains(facing.back.T)
    sums, fields, space = Sums.room(2 * count), Fields.room(count), setting.space(found.faces)
    count = _straight_back(waves, facing, seen, *gains, tubes, space, bins, sums, fields)
    return sums, arrived(fields.first(count))


def _faces(setting: Setting, tubes: Tubes, waves: Waves, hits: Hits) -> tuple[Faces, np.ndarray]:
    """The faces that waves may meet, and the number (k,) of that which each meets."""
    plane = setting.planes.of_hits(hits, slice(None))
    if not setting.deforms:
        return setting.faces, plane
    single = np.flatnonzero((plane == NO_PLANE) & (hits.number != NOTHING))
    some, images, image = waves.each[single], waves.images, waves.image[single]
    direction = np.einsum("kij,jk->ki", images.turn[image], tubes.directions[:, some["row"]])
    length = hits.distance[single] + some["travelled"]
    point = images.place[image] + direction * length[:, None]
    face, faces = with_hits(setting, plane, hits, single, single, point)
    return faces, face


@compiled
def _again(
    waves: Waves,
    distance: np.ndarray,
    face: np.ndarray,
    tubes: Tubes,
    space: Space,
    bins: Bins,
    sights: Sights,
    found: AgainRoom,
) -> tuple[int, int, int, int]:
    """Adds what is scattered; writes what is sent on of waves (k,), the curved faces that are met, what faces the
    radar, and the rays there, and counts each. distance: (k,) [m], to their hits; face: (k,) that are met there.
    Without room for waves none is sent on.
    """
    facing = found.facing
    on = bent = ahead = asked = np.int64(0)
    for at in range(len(face)):
        if not distance[at] < space.longest - waves.each[at].travelled:
            continue
        wave = wave_of(waves, at, tubes)
        touch = meets(space, waves.images, wave, np.int64(face[at]))
        if touch.way <= 0:
            continue
        echo = echo_of(space, waves.images, wave, touch)
        scatter_again(space, tubes, wave, touch, echo, bins, found.scattered)
        if len(found.sent.waves) > 0 and send_on(space, wave, touch, found.sent, on):
            on += 1
        curved = touch.face < space.faces.planes and space.faces.curved[touch.face]
        if curved:
            write(found.curved, bent, wave, touch, echo)
            bent += 1
        if echo.rise * touch.slope > 0 and echo.back[0] > 0 and touch.way + echo.out < 2.0 * space.seen:
            middle = math.sqrt(max(2.0 + 2.0 * dot(wave.direction, echo.back), 0.0))
            mirror = abs(touch.slope) + abs(echo.rise) > MIRROR * middle
            if not (mirror or curved or space.tables.diffuse[touch.table] > 0):
                continue
            known = looks(sights, space.faces, touch.face, echo.back, echo.out)
            if known != HIDDEN:
                facing.wave[ahead], facing.face[ahead], facing.out[ahead] = at, touch.face, echo.out
                facing.mirrors[ahead], facing.curved[ahead] = mirror and not curved, bent - 1 if curved else -1
                facing.back[ahead, 0], facing.back[ahead, 1], facing.back[ahead, 2] = echo.back
                facing.ray[ahead] = -1
                if known == UNKNOWN:
                    facing.ray[ahead] = asked
                    for axis in range(3):
                        facing.rays[asked, 3 + axis] = dot(row_of(space.rotation, axis), echo.back)
                    asked += 1
                ahead += 1
    return int(on), int(bent), int(ahead), int(asked)


@compiled
def _straight_back(
    waves: Waves,
    facing: Facing,
    seen: np.ndarray,
    sends: np.ndarray,
    hears: np.ndarray,
    tubes: Tubes,
    space: Space,
    bins: Bins,
    sums: Sums,
    fields: Fields,
) -> int:
    """Adds what rough faces send straight back, writes the fields of flat ones, and counts these.

    sends, hears: (m,) gains of the ways there.
    """
    count, images = np.int64(0), waves.images
    for at in range(len(seen)):
        if seen[at]:
            wave = wave_of(waves, facing.wave[at], tubes)
            touch = meets(space, images, wave, facing.face[at])
            echo = echo_of(space, images, wave, touch)
            scatter_back(space, tubes, wave, touch, echo, sends[at], hears[at], bins, sums)
            if facing.mirrors[at] and reflect_back(space, images, tubes, wave, touch, echo, hears[at], fields, count):
                count += 1
    return int(count)
