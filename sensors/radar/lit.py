"""What tubes meet first, and what comes straight back of it: in single precision, of all tubes of a block at once.

The distance of a hit, and the height of the radar over the plane that is hit, give the cosine of incidence. That is
enough for what rough faces scatter, and to choose the few tubes whose phase counts: those near a mirror reflection, and
those that are followed on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sensors.compiled import compiled
from sensors.raycast.rays import NOTHING, Hits
from sensors.vectors import dot, row_of

from .bins import Bins, put
from .grouping import Sums
from .images import Images
from .planes import NO_PLANE
from .rays import Tubes, angles_of
from .scattering import MIRROR, WIDEST, Arrivals, Fields, arrived, reflect_back
from .setting import Setting, Space, height_of, with_hits
from .waves import FAINTEST, GRAZING, MET, Met, Sent, Wave, echo_of, meets, send_on, strength, write

LEAST_M = np.float32(1e-12)
"""Distances below this [m] count as this."""

_NONE = np.zeros(0, np.int32)


@dataclass(slots=True)
class Beam:
    """Neighbouring tubes that were cast together, and what they meet; n of them, from `first` of all tubes on.

    skip: (s + 1,) bool, surfaces whose hits do not count. owner: (n,) int32, the only surface whose hits count, None
    for all.
    """

    first: int
    skip: np.ndarray
    owner: np.ndarray | None
    hits: Hits


@dataclass(slots=True)
class Lit:
    """What comes back of the faces that tubes meet first, what is sent on, and what of them is curved.

    scattered: by rough faces; fields: of flat ones near a mirror reflection. plane: (n,) int32, which each tube meets.
    """

    scattered: Sums
    fields: Arrivals
    sent: Sent
    curved: Met
    plane: np.ndarray


class Ahead(NamedTuple):
    """What a block of n tubes meets; first: where it starts among all tubes.

    distance: (n,) float32 [m]; face: (n,) that are met; owner: as in `Beam`, (0,) for None; skip: as there.
    """

    first: int
    distance: np.ndarray
    face: np.ndarray
    owner: np.ndarray
    skip: np.ndarray


class LitRoom(NamedTuple):
    """Room for what a block of n tubes brings; met: (n,) of `MET`, the curved faces."""

    scattered: Sums
    fields: Fields
    sent: Sent
    met: np.ndarray

    @classmethod
    def of(cls, setting: Setting, leads: np.ndarray) -> LitRoom:
        """For tubes (n,), of which these lead on; made by the main thread, whose memory is used again."""
        count, on = len(leads), int(np.count_nonzero(leads)) if setting.bounces > 1 else 0
        met = np.empty(count if setting.planes.any_curved else 0, MET)
        return cls(Sums.room(count), Fields.room(count), Sent.room(on), met)


def lit(setting: Setting, bins: Bins, tubes: Tubes, beam: Beam, part: slice, room: LitRoom) -> Lit:
    """What becomes of some tubes of a beam."""
    hits, faces, images = beam.hits, setting.faces, Images.none()
    distance, plane = hits.distance[part], setting.planes.of_hits(hits, part)
    first, face = beam.first + part.start, plane
    if setting.deforms:
        single = np.flatnonzero((plane == NO_PLANE) & (hits.number[part] != NOTHING))
        point = tubes.directions[:, first + single].T * distance[single, None]
        face, faces = with_hits(setting, plane, hits, single + part.start, single, point)
    owner = _NONE if beam.owner is None else beam.owner[part]
    ahead = Ahead(first, distance, face, owner, beam.skip)
    turning = np.float32(2.0 / (WIDEST * setting.antenna.wavelength))
    fields, sent, bent = _lit(ahead, tubes, setting.space(faces), images, turning, bins, room)
    met = Met(1, images, setting.faces, room.met[:bent])
    return Lit(room.scattered, arrived(room.fields.first(fields)), room.sent.first(sent), met, plane)


@compiled
def _lit(
    ahead: Ahead, tubes: Tubes, space: Space, images: Images, turning: Any, bins: Bins, room: LitRoom
) -> tuple[int, int, int]:
    """Adds what is scattered; writes fields, waves that are sent on, and curved faces that are met, and counts each.

    turning: turns of phase, over `WIDEST`, on a way of 1 m. Without room for waves none is followed.
    """
    faces, tables, seen, received = space.faces, space.tables, np.float32(space.seen), np.float32(space.received)
    fields = sent = bent = np.int64(0)  # a plain 0 is a type of its own, for which parts are compiled once more
    known, surface, first, flat = np.int64(-2), np.int64(0), np.int64(0), False
    height, speed = np.float32(0), (0.0, 0.0, 0.0)
    for row in range(len(ahead.distance)):
        way, face = max(ahead.distance[row], LEAST_M), np.int64(ahead.face[row])
        tube = ahead.first + row
        if not way < seen:
            continue
        if face != known:  # neighbours meet mostly one face
            known, surface, first = face, np.int64(faces.surface[face]), np.int64(faces.table[face])
            flat, height = not faces.curved[face], np.float32(abs(height_of(faces, face)))
            speed = row_of(faces.linear, faces.body[face])
        if (len(ahead.owner) and ahead.owner[row] != surface) or ahead.skip[surface]:
            continue
        inverse = np.float32(1) / way
        cosine = min(height * inverse, np.float32(1))
        table = first + min(int(cosine * tables.steps), tables.steps - 1)
        power = tables.diffuse[table] * cosine * tubes.weight[tube] * received * inverse * inverse
        towards = tubes.directions[0, tube], tubes.directions[1, tube], tubes.directions[2, tube]
        if power > 0:
            side, level, angle = angles_of(tubes, tube)
            put(bins, room.scattered, np.float64(way), dot(speed, towards), side, level, angle, np.float64(power))
        if cosine <= GRAZING:
            continue
        mirrors = leads = False
        if flat:
            if cosine > MIRROR:
                turns = max(tubes.width[tube], tubes.height[tube]) * way * turning
                square = cosine * cosine
                mirrors = turns * turns * (1 - square) < square
            if len(room.sent.waves) > 0 and tubes.leads[tube] and 0 <= face < faces.planes:
                leads = bool(strength(tables.amplitude[table]) > FAINTEST**2)
            if not (mirrors or leads):
                continue
        wave = Wave(tube, towards, np.float32(1), 0.0, np.complex64(1), np.int64(0))
        touch = meets(space, images, wave, face)
        if touch.way <= 0:
            continue
        if leads and send_on(space, wave, touch, room.sent, sent):
            sent += 1
        if mirrors or not flat:
            echo = echo_of(space, images, wave, touch)
            if not flat:
                write(room.met, bent, wave, touch, echo)
                bent += 1
            elif reflect_back(space, images, tubes, wave, touch, echo, tubes.hears[tube], room.fields, fields):
                fields += 1
    return int(fields), int(sent), int(bent)
