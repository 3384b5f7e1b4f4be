"""What tubes meet first, and what comes straight back of it: in single precision, of all tubes of a block at once.

The distance of a hit, and the height of the radar over the plane that is hit, give the cosine of incidence. That is
enough for what rough faces scatter, and to choose the few tubes whose phase counts: those near a mirror reflection, and
those that are followed on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sensors.compiled import compiled
from sensors.raycast.rays import NOTHING, Hits, RayBundle

from .images import Images
from .materials import Tables
from .planes import NO_PLANE
from .rays import Tubes
from .scattering import MIRROR, Arrivals
from .waves import FAINTEST, GRAZING, WAVE, Faces, Setting, Waves, with_hits

WIDEST = 6.0
"""Turns of phase over a tube up to which it counts for a flat face: inside a face wider ones cancel to nothing, and an
edge they cannot resolve."""

LEAST_M = np.float32(1e-12)
"""Distances below this [m] count as this."""

MIRRORS, BENDS, LEADS = 1, 2, 4
"""What becomes of a tube at its first face: it is near its mirror reflection; the surface is curved; it goes on."""

_NONE = np.zeros(0, np.int32)


@dataclass(slots=True)
class Beam:
    """Neighbouring tubes that were cast together, and what they meet; n of them, from `first` of all tubes on.

    bundle: their rays. angle: (n,) int64, their angle cells, None if they are not known. skip: (s + 1,) bool, surfaces
    whose hits do not count. owner: (n,) int32, the only surface whose hits count, None for all.
    """

    first: int
    bundle: RayBundle
    angle: np.ndarray | None
    skip: np.ndarray
    owner: np.ndarray | None
    hits: Hits

    def blocks(self, size: int, seen: float) -> Iterator[tuple[Beam, slice]]:
        """Its tubes in blocks, but for those in which none meets anything nearer than `seen` [m]."""
        count = len(self.hits.distance)
        for first in range(0, count, size):
            part = slice(first, min(first + size, count))
            if self.hits.distance[part].min() < seen:
                yield self, part


@dataclass(slots=True)
class Lit:
    """What some tubes of a beam meet.

    scattered: what rough faces send straight back. waves: (m,), those tubes whose phase counts; hit: (m,) of the beam,
    plane: (m,) that they meet, and kind: (m,) uint8, of `MIRRORS`, `BENDS` and `LEADS`.
    """

    scattered: Arrivals
    waves: Waves
    hit: np.ndarray
    plane: np.ndarray
    kind: np.ndarray


class Ahead(NamedTuple):
    """What a block of n tubes meets, of a beam of b.

    first_tube, first_hit: where the block starts among all tubes, and in the beam. direction: (3, b), of the beam's
    rays in the world's axes. distance: (n,) float32 [m]; face: (n,) that are met; owner: as in `Beam`, (0,) for None;
    skip: as there.
    """

    first_tube: int
    first_hit: int
    direction: np.ndarray
    distance: np.ndarray
    face: np.ndarray
    owner: np.ndarray
    skip: np.ndarray


class Limits(NamedTuple):
    """What a tube must keep to count. seen: farthest [m]; grazing: least cosine of incidence, mirror: near a mirror
    reflection; faintest: least amplitude of what is followed, if the radar follows anything.
    """

    seen: np.float32
    grazing: float
    mirror: float
    faintest: float
    follows: bool


class Scale(NamedTuple):
    """What the wavelength makes of a tube. received: of 4 m^2 at 1 m [W m^2]; turning: turns of phase, over `WIDEST`,
    on a way of 1 m.
    """

    received: np.float32
    turning: np.float32


class Found(NamedTuple):
    """Room for what a block of n tubes brings: rows of scattered power, and rows of waves whose phase counts.

    range_m, velocity, azimuth, height, power: (n,) float32, of `Arrivals`, and tube: (n,) int64 of the block. wave:
    (n,) of `WAVE`; hit, plane: (n,) int64, and kind: (n,) uint8, as in `Lit`.
    """

    range_m: np.ndarray
    velocity: np.ndarray
    azimuth: np.ndarray
    height: np.ndarray
    power: np.ndarray
    tube: np.ndarray
    wave: np.ndarray
    hit: np.ndarray
    plane: np.ndarray
    kind: np.ndarray

    @classmethod
    def room(cls, count: int) -> Found:
        """Arrays for so many, to be filled."""
        kinds = *[np.float32] * 5, np.int64, WAVE, np.int64, np.int64, np.uint8
        return cls(*(np.empty(count, kind) for kind in kinds))


def lit(setting: Setting, tubes: Tubes, beam: Beam, part: slice) -> Lit:
    """What some tubes of a beam meet. Cross section of rough faces 4 x share x area x cosine squared (Lambert)."""
    hits, faces, antenna = beam.hits, setting.faces, setting.antenna
    distance, plane = hits.distance[part], setting.planes.of_hits(hits, part)
    first, face = beam.first + part.start, plane
    if setting.deforms:
        single = np.flatnonzero((plane == NO_PLANE) & (hits.number[part] != NOTHING))
        point = tubes.directions[:, first + single].T * distance[single, None]
        face, faces = with_hits(setting, plane, hits, single + part.start, single, point)
    owner = _NONE if beam.owner is None else beam.owner[part]
    ahead = Ahead(first, part.start, beam.bundle.directions, distance, face, owner, beam.skip)
    linear = (faces.linear @ setting.rotation.T).astype(np.float32)
    limits = Limits(np.float32(setting.seen), GRAZING, MIRROR, FAINTEST, setting.bounces > 1)
    scale = Scale(np.float32(4.0 * antenna.receives), np.float32(2.0 / (WIDEST * antenna.wavelength)))
    found = Found.room(len(plane))
    scattered, special = _lit(ahead, tubes, faces, linear, setting.reflections.tables, limits, scale, found)
    back = Arrivals.of((column[:scattered] for column in found[:5]), 1)
    if beam.angle is not None:
        back.angle = beam.angle[part].take(found.tube[:scattered])
    wave, hit, plane, kind = (column[:special] for column in found[6:])
    return Lit(back, Waves(1, Images.none(), np.zeros(special, np.int32), wave), hit, plane, kind)


@compiled
def _lit(
    ahead: Ahead,
    tubes: Tubes,
    faces: Faces,
    linear: np.ndarray,
    tables: Tables,
    limits: Limits,
    scale: Scale,
    found: Found,
) -> tuple[int, int]:
    """Writes what is scattered, and the waves whose phase counts; counts both. linear: (b, 3) float32, the velocities
    of the bodies in the world's axes [m/s].
    """
    scattered = special = 0
    for row in range(len(ahead.distance)):
        way, face = max(ahead.distance[row], LEAST_M), ahead.face[row]
        tube, hit = ahead.first_tube + row, ahead.first_hit + row
        if not way < limits.seen:
            continue
        surface = faces.surface[face]
        if (len(ahead.owner) and ahead.owner[row] != surface) or ahead.skip[surface]:
            continue
        inverse = np.float32(1) / way
        cosine = min(np.float32(abs(faces.height[face])) * inverse, np.float32(1))
        table = faces.table[face] + min(int(cosine * tables.steps), tables.steps - 1)
        power = tables.diffuse[table] * cosine * tubes.weight[tube] * scale.received * inverse * inverse
        if power > 0:
            own, rate = faces.body[face], np.float32(0)
            for axis in range(3):
                rate += linear[own, axis] * ahead.direction[axis, hit]
            found.range_m[scattered], found.velocity[scattered], found.power[scattered] = way, rate, power
            found.azimuth[scattered], found.height[scattered] = tubes.azimuth[tube], tubes.elevation[tube]
            found.tube[scattered] = row
            scattered += 1
        if cosine <= limits.grazing:
            continue
        kind = 0
        if faces.curved[face]:
            kind = BENDS
        else:
            turns = max(tubes.width[tube], tubes.height[tube]) * way * scale.turning
            square = cosine * cosine
            if cosine > limits.mirror and turns * turns * (1 - square) < square:
                kind |= MIRRORS
            left = tables.amplitude[table]
            strong = left.real**2 + left.imag**2 > limits.faintest**2
            if limits.follows and tubes.wide[tube] > 0 and 0 <= face < faces.planes and strong:
                kind |= LEADS
        if kind:
            wave = found.wave[special]
            wave.row, wave.travelled, wave.field, wave.wide = tube, 0.0, 1.0, 1.0
            for axis in range(3):
                wave.direction[axis] = tubes.directions[axis, tube]
            found.hit[special], found.kind[special] = hit, kind
            found.plane[special] = face if face < faces.planes else -1
            special += 1
    return scattered, special
