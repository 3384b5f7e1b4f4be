"""What tubes meet first, and what comes straight back of it: in single precision, of all tubes of a block at once.

The distance of a hit, and the height of the radar over the plane that is hit, give the cosine of incidence. That is
enough for what rough faces scatter, and to choose the few tubes whose phase counts: those near a mirror reflection, and
those that are followed on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sensors.compiled import compiled
from sensors.raycast.rays import NOTHING, Hits, RayBundle

from .images import Images
from .materials import STEPS
from .planes import NO_PLANE
from .rays import Tubes
from .scattering import MIRROR, Arrivals
from .waves import FAINTEST, GRAZING, WAVE, Setting, Waves, with_hits

WIDEST = 6.0
"""Turns of phase over a tube up to which it counts for a flat face: inside a face wider ones cancel to nothing, and an
edge they cannot resolve."""

LEAST_M = np.float32(1e-12)
"""Distances below this [m] count as this."""

NOTHING_KNOWN = -1
"""Where the surface is found that has no number."""

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


def lit(setting: Setting, tubes: Tubes, beam: Beam, part: slice) -> Lit:
    """What some tubes of a beam meet. Cross section of rough faces 4 x share x area x cosine squared (Lambert)."""
    hits, faces = beam.hits, setting.faces
    distance, plane = hits.distance[part], setting.planes.of_hits(hits, part)
    face = plane
    straight, tubes = tubes.directions, tubes.part(beam.first + part.start, beam.first + part.stop)
    if setting.deforms:
        single = np.flatnonzero((plane == NO_PLANE) & (hits.number[part] != NOTHING))
        point = tubes.directions[:, single].T * distance[single, None]
        face, faces = with_hits(setting, plane, hits, single + part.start, single, point)
    scattered, rough = np.empty((5, len(plane)), np.float32), np.empty(len(plane), np.int64)
    waves, kinds = np.empty(len(plane), WAVE), np.empty(len(plane), np.uint8)
    met, planes = np.empty(len(plane), np.int64), np.empty(len(plane), np.int64)
    antenna, reflections = setting.antenna, setting.reflections
    owner = _NONE if beam.owner is None else beam.owner[part]
    linear = (faces.linear @ setting.rotation.T).astype(np.float32)
    received, turning = np.float32(4.0 * antenna.receives), np.float32(2.0 / (WIDEST * antenna.wavelength))
    limits = np.float32(setting.seen), GRAZING, MIRROR, FAINTEST
    # fmt: off
    found, special = _lit(
        distance, face, owner, beam.skip, setting.surfaces, setting.curved,
        faces.height, faces.table, faces.body, linear, reflections.diffuse, reflections.amplitude, STEPS,
        beam.bundle.directions, straight, tubes.azimuth, tubes.elevation,
        tubes.weight, tubes.width, tubes.height, tubes.wide, received, turning, limits, setting.bounces > 1,
        beam.first + part.start, part.start, scattered, rough, waves, met, planes, kinds,
    )
    # fmt: on
    back = Arrivals.of(scattered[:, :found], 1)
    if beam.angle is not None:
        back.angle = beam.angle[part].take(rough[:found])
    started = Waves(1, Images.none(), np.zeros(special, np.int32), waves[:special])
    return Lit(back, started, met[:special], planes[:special], kinds[:special])


@compiled
def _lit(
    distance: np.ndarray,
    faces: np.ndarray,
    owner: np.ndarray,
    skip: np.ndarray,
    surfaces: np.ndarray,
    curved: np.ndarray,
    heights: np.ndarray,
    tables: np.ndarray,
    body: np.ndarray,
    linear: np.ndarray,
    diffuse: np.ndarray,
    amplitude: np.ndarray,
    steps: int,
    direction: np.ndarray,
    straight: np.ndarray,
    azimuth: np.ndarray,
    elevation: np.ndarray,
    weight: np.ndarray,
    width: np.ndarray,
    height: np.ndarray,
    wide: np.ndarray,
    received: np.float32,
    turning: np.float32,
    limits: tuple[np.float32, float, float, float],
    follows: bool,
    first_tube: int,
    first_hit: int,
    scattered: np.ndarray,
    rough: np.ndarray,
    waves: np.ndarray,
    hits: np.ndarray,
    planes: np.ndarray,
    kinds: np.ndarray,
) -> tuple[int, int]:
    """Writes what is scattered (5, n), of which rows, and the waves whose phase counts, with their kinds; counts
    both. direction: (3, n) in the world's axes, straight: in the sensor's; received: of 4 m^2 at 1 m [W m^2]; turning:
    turns of phase, over `WIDEST`, on a way of 1 m.
    """
    found = special = 0
    seen, grazing, mirror, faintest = limits
    known = len(curved) - 1
    for row in range(len(distance)):
        way, face = max(distance[row], LEAST_M), faces[row]
        if not way < seen:
            continue
        surface = surfaces[face] if face < known else NOTHING_KNOWN
        if (len(owner) and owner[row] != surface) or skip[surface]:
            continue
        inverse = np.float32(1) / way
        cosine = min(np.float32(abs(heights[face])) * inverse, np.float32(1))
        table = tables[face] + min(int(cosine * steps), steps - 1)
        power = diffuse[table] * cosine * weight[row] * received * inverse * inverse
        if power > 0:
            own, rate = body[face], np.float32(0)
            for axis in range(3):
                rate += linear[own, axis] * direction[axis, first_hit + row]
            scattered[0, found], scattered[1, found], scattered[4, found] = way, rate, power
            scattered[2, found], scattered[3, found], rough[found] = azimuth[row], elevation[row], row
            found += 1
        if cosine <= grazing:
            continue
        kind = 0
        if face < known and curved[face]:
            kind = BENDS
        else:
            turns = max(width[row], height[row]) * way * turning
            square = cosine * cosine
            if cosine > mirror and turns * turns * (1 - square) < square:
                kind |= MIRRORS
            left = amplitude[table]
            if follows and wide[row] > 0 and 0 <= face < known and left.real**2 + left.imag**2 > faintest**2:
                kind |= LEADS
        if kind:
            wave = waves[special]
            wave.row, wave.travelled, wave.field, wave.wide = first_tube + row, 0.0, 1.0, 1.0
            for axis in range(3):
                wave.direction[axis] = straight[axis, first_tube + row]
            hits[special], planes[special], kinds[special] = first_hit + row, face if face < known else -1, kind
            special += 1
    return found, special
