"""What faces send back to the radar: physical optics of flat ones, the spread lobes of curved ones, rough ones.

The tubes on one flat face, and along one set of faces for a corner, add up as fields: over a tube's footprint the phase
is linear, and its integral a product of two sinc functions, so tubes may be many wavelengths wide. In angular form the
field of a tube is gain x reflection x solid angle x (way in / way back) x exp(-j k way), near and far (Ling, Chou and
Lee, "Shooting and bouncing rays", IEEE Trans. AP-37 (1989) 194-205).

A tube that meets a face of a curved surface has a lobe about the normal there, spread over the angles to the face's
neighbours, as geometrical optics of the curved surface does; a rough one scatters part of the power by Lambert's law.
Both add up as powers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from .planes import FADED, NO_PLANE
from .rays import Tubes
from .waves import Met, Setting, dot, face_keys, tangential

MIRROR = 0.7
"""Least cosine between a face's normal and the middle of the ways in and back: physical optics is good to about 40 deg
from the mirror reflection, and what it gives beyond is far below the lobe."""


WIDEST = 6.0
"""Turns of phase over a tube up to which it counts for a flat face: inside a face wider ones cancel to nothing, and an
edge they cannot resolve."""


SIDE_LOBES = 8.0 * np.pi
"""Over the squared width of a tube times that of 2 L / wavelength: twice a tube is then one deviation of the lobe."""


@dataclass(slots=True)
class Arrivals:
    """Single contributions to what is received, k of them.

    range_m: half the way [m]. velocity: half its rate [m/s], positive where it grows. azimuth, height: sines of azimuth
    and elevation that it arrives from. power: (k,) [W]. field: (k,) complex [sqrt(W)], where they add up as fields;
    zone: (k,) angles that the first Fresnel zone takes up then [rad]. group: (k,) uint64, equal for fields that add up,
    and for the powers of one curved surface. angle: (k,) int64, the angle cells, if they are known (`Grid.angles`).
    bounces: faces on the way.
    """

    range_m: np.ndarray
    velocity: np.ndarray
    azimuth: np.ndarray
    height: np.ndarray
    power: np.ndarray
    field: np.ndarray | None = None
    group: np.ndarray | None = None
    zone: np.ndarray | None = None
    angle: np.ndarray | None = None
    bounces: int = 1

    def __post_init__(self) -> None:
        for name in ("range_m", "velocity", "azimuth", "height", "power"):
            setattr(self, name, np.ascontiguousarray(getattr(self, name), np.float32))

    @property
    def values(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """What cells are of: range, velocity, sines of azimuth and elevation."""
        return self.range_m, self.velocity, self.azimuth, self.height

    @classmethod
    def together(cls, parts: list[Arrivals]) -> Arrivals:
        """Several of the same bounce and kind as one."""
        if len(parts) == 1:
            return parts[0]
        names = [one.name for one in fields(cls) if isinstance(getattr(parts[0], one.name), np.ndarray)]
        columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        return cls(**columns, bounces=parts[0].bounces)


def again(setting: Setting, tubes: Tubes, met: Met) -> Iterator[Arrivals]:
    """What rough faces, met after others, send back along the way on which the wave came."""
    if not setting.reflections.scatters:
        return
    power = _scattered(setting, tubes.weight, tubes, met)
    power *= met.cosine * _passed(met)
    power /= (met.way**2).astype(np.float32)
    power *= met.way < setting.seen
    yield _with_power(met.way, met.rate_again(), *_own(tubes, met), power)


def rough(setting: Setting, tubes: Tubes, met: Met) -> Iterator[Arrivals]:
    """What rough faces, met after others, send straight back: by the two ways in both orders."""
    if not setting.reflections.scatters:
        return
    row, rate, antenna = met.waves.row, met.rate(), setting.antenna
    back = met.back.astype(np.float32)
    sent = _scattered(setting, tubes.solid, tubes, met)
    sent *= (np.abs(met.rise) / met.out**2).astype(np.float32)
    first, second = sent * np.take(tubes.sends, row), sent * np.take(tubes.hears, row)
    yield _with_power(met.range_m, rate, _azimuth(back), back[2], first * antenna.hears(back))
    yield _with_power(met.range_m, rate, *_own(tubes, met), second * antenna.sends(back))


def _scattered(setting: Setting, solid: np.ndarray, tubes: Tubes, met: Met) -> np.ndarray:
    """What faces that scatter by Lambert's law send along their normals and receive at 1 m [W m^2], (k,) float32.

    Cross section 4 x share x area x cosines in and back. solid: (n,) of the tubes [sr], times gains.
    """
    sent = setting.reflections.diffuse(met.table) * np.take(solid, met.waves.row)
    sent *= np.take(tubes.wide, met.waves.row) ** 2
    sent *= np.float32(4.0 * setting.antenna.receives)
    left = met.waves.field
    return np.asarray(sent if left is None else sent * (left.real**2 + left.imag**2))


def _own(tubes: Tubes, met: Met) -> tuple[np.ndarray, np.ndarray]:
    """Sines (k,) of the azimuths and elevations of the tubes."""
    return np.take(tubes.azimuth, met.waves.row), np.take(tubes.elevation, met.waves.row)


def _with_power(
    range_m: np.ndarray, velocity: np.ndarray, azimuth: np.ndarray, height: np.ndarray, power: np.ndarray
) -> Arrivals:
    """Arrivals, of those rows that have any power."""
    rows = np.flatnonzero(power)

    def some(one: np.ndarray) -> np.ndarray:
        return one[: len(rows)] if one.strides[0] == 0 else np.take(one, rows).astype(np.float32, copy=False)

    return Arrivals(some(range_m), some(velocity), some(azimuth), some(height), some(power))


def curved(setting: Setting, tubes: Tubes, met: Met) -> Iterator[Arrivals]:
    """What faces of curved surfaces send straight back; after mirrors by the two ways in both orders."""
    met = _bent(setting, tubes, met, met.back)
    if not len(met):
        return
    row, antenna = met.waves.row, setting.antenna
    power = _glint(setting, tubes, met, _middle_ways(setting, met)) / met.out**2
    back, group = met.back.astype(np.float32), _surface_keys(setting, met)
    range_m, rate = met.range_m, met.rate()
    first = power * np.take(tubes.sends, row) * antenna.hears(back)
    yield Arrivals(range_m, rate, _azimuth(back), back[2], first, group=group)
    if met.waves.image is not None:
        second = power * np.take(tubes.hears, row) * antenna.sends(back)
        yield Arrivals(range_m, rate, *_own(tubes, met), second, group=group)


def curved_again(setting: Setting, tubes: Tubes, met: Met) -> Iterator[Arrivals]:
    """What faces of curved surfaces, met after mirrors, send back along the way on which the wave came."""
    met = _bent(setting, tubes, met, met.waves.direction)
    if not len(met):
        return
    power = _glint(setting, tubes, met, -met.waves.direction) * _passed(met) / met.way**2
    power *= np.take(tubes.sends, met.waves.row) * np.take(tubes.hears, met.waves.row)
    power *= met.way < setting.seen
    yield Arrivals(met.way, met.rate_again(), *_own(tubes, met), power, group=_surface_keys(setting, met))


def _bent(setting: Setting, tubes: Tubes, met: Met, back: np.ndarray) -> Met:
    """Those that meet faces of curved surfaces within reach of their lobes; back: (3, k), the ways back."""
    planes = setting.planes
    rows = np.flatnonzero((met.plane != NO_PLANE) & planes.curved[met.plane])
    met, back = met.at(rows), back[:, rows]
    ways = 1.0 + dot(met.waves.direction, back)
    sine = ways / 2.0 - (met.slope + dot(met.normal, back)) ** 2 / 4.0
    row, (wide, bend) = met.waves.row, planes.widths(setting.antenna.wavelength)
    solid = np.take(tubes.width, row) * np.take(tubes.height, row) * (_wide(tubes, met) ** 2 * FADED / 2.0)
    reach = np.take(wide, met.plane)
    reach += solid * (1.0 / 3.0 + np.take(bend, met.plane) * met.way**2 / met.cosine)
    found: Met = met.at(np.flatnonzero(sine < reach))
    return found


def _glint(setting: Setting, tubes: Tubes, met: Met, ways: np.ndarray) -> np.ndarray:
    """What faces of curved surfaces receive at 1 m [W m^2] (k,), at gain 1; ways: (3, k), the middles of both ways.

    The integral of the lobe over all directions is pi x area, however wide it is. Each tube meets the surface where the
    normal has turned by `bend` from that of the face, and counts as a lobe of at least half its own footprint's turn:
    however many tubes meet a face, they add up to the surface. Where this is straight, as along a cylinder, the lobe is
    that of a line, sinc squared, as far as tubes are narrow enough to tell its side lobes.
    """
    planes, row, plane = setting.planes, met.waves.row, met.plane
    axes, bend = planes.axes[plane], planes.bend[plane]
    place = (setting.rotation @ (met.back * met.out)).T + setting.pose[:3, 3] - planes.middle[plane]
    across = np.einsum("pai,ip->pa", axes, setting.rotation @ ways)
    across -= np.einsum("pab,pbi,pi->pa", bend, axes, place) * dot(ways, met.normal)[:, None]
    wide = _wide(tubes, met) ** 2
    solid = tubes.width[row] * tubes.height[row] * wide
    spread = planes.lobes(setting.antenna.wavelength)[plane] + (solid / 12.0)[:, None, None] * np.eye(2)
    spread += np.einsum("pab,pcb->pac", bend, bend) * (solid * met.way**2 / (4.0 * met.cosine))[:, None, None]
    inverse = np.linalg.inv(spread)
    straight = np.take(planes.straight(setting.antenna.wavelength), plane, axis=0)
    straight *= (SIDE_LOBES * solid * (straight**2).sum(axis=1) < 1.0)[:, None]
    along, length = (straight * across).sum(axis=1), (straight**2).sum(axis=1)
    across -= straight * (along / np.maximum(length, 1e-300))[:, None]
    lobe = np.exp(-0.5 * np.einsum("pa,pab,pb->p", across, inverse, across)) * np.sqrt(np.linalg.det(inverse))
    lobe *= np.sinc(along) ** 2
    left = np.abs(met.waves.left(setting.reflections.coherent(met.table))) ** 2
    return np.asarray(setting.antenna.receives * left * tubes.solid[row] * wide * lobe / (2.0 * met.cosine))


def _passed(met: Met) -> np.ndarray | np.float32:
    """The share of the power (k,) that mirrors on the way in leave of a wave that passes them once more."""
    left = met.waves.field
    return np.float32(1.0) if left is None else np.asarray(left.real**2 + left.imag**2)


def _surface_keys(setting: Setting, met: Met) -> np.ndarray:
    """(k,) uint64 of the surface that sends back and of the mirrors on the way."""
    waves, key = met.waves, np.take(setting.surfaces, met.plane).astype(np.uint64)
    return key if waves.image is None else np.asarray(key + np.take(waves.images.key, waves.image))


def _middle_ways(setting: Setting, met: Met) -> np.ndarray:
    """The middles (3, k) between the ways in and back; of small faces from where their middles are.

    Over a face of less than a Fresnel zone the wave is flat; over a larger one each tube counts by itself.
    """
    ways = -(met.waves.direction + met.back) / 2.0
    if met.waves.image is None:
        small = np.flatnonzero(
            12.0 * setting.planes.extent[met.plane].max(axis=(1, 2)) < setting.antenna.wavelength * met.out
        )
        towards = (setting.pose[:3, 3] - setting.planes.middle[met.plane[small]]) @ setting.rotation
        ways[:, small] = (towards / np.linalg.norm(towards, axis=1)[:, None]).T
    return np.asarray(ways)


def flat(setting: Setting, tubes: Tubes, met: Met) -> Iterator[Arrivals]:
    """Flat faces: each tube's field.

    The way is worked out in float64, down to a fraction of a wave; amplitudes and phases then are float32.
    """
    if not len(met):
        return
    row, antenna, direction, back = met.waves.row, setting.antenna, met.waves.direction, met.back
    wide = _wide(tubes, met)
    size = np.take(tubes.solid, row) * wide**2
    size *= np.float32(math.sqrt(antenna.power) / (4.0 * math.pi))
    gain = np.take(tubes.sends, row)
    turning = met.way / (met.slope * -antenna.wavelength)
    if back is direction:
        azimuth, height = _own(tubes, met)
        size *= np.sqrt(gain * np.take(tubes.hears, row))
        vectors = met.normal * (2.0 * turning)
    else:
        local = back.astype(np.float32)
        azimuth, height = _azimuth(local), local[2]
        size *= np.sqrt(gain * antenna.hears(local)) * (met.way / met.out).astype(np.float32)
        turning *= 1.0 + dot(back, direction)
        vectors = met.normal * turning + back * (met.way / antenna.wavelength)
    for angle, growth in zip((tubes.width, tubes.height), tangential(tubes, met.waves, vectors), strict=True):
        size *= _sinc(growth * (wide * np.take(angle, row)))
    way = met.way + met.out
    waves = way / antenna.wavelength
    turn = ((np.rint(waves) - waves) * (2.0 * np.pi)).astype(np.float32)
    left = met.waves.left(setting.reflections.coherent(met.table)) * size
    field = np.empty_like(left)
    np.cos(turn, out=field.real)
    np.sin(turn, out=field.imag)
    field *= left
    power = field.real**2 + field.imag**2
    range_m, rate = met.range_m.astype(np.float32), met.rate()
    found = Arrivals(range_m, rate if met.coming is None else rate.astype(np.float32), azimuth, height, power)
    found.field, found.group = field, face_keys(setting, met)
    found.zone = np.sqrt((antenna.wavelength / way).astype(np.float32))
    yield found


def _sinc(turns: np.ndarray) -> np.ndarray:
    """sin(pi x) / (pi x) of x (k,) float32; `np.sinc` without its special case for 0."""
    half = turns * np.float32(np.pi)
    half += np.float32(1e-20)
    return np.asarray(np.sin(half) / half)


def _wide(tubes: Tubes, met: Met) -> np.ndarray | np.float32:
    """How many tubes across each stands for, (k,) float32."""
    return np.float32(1.0) if met.waves.image is None else np.take(tubes.wide, met.waves.row)


def mirrored(setting: Setting, met: Met) -> np.ndarray:
    """Rows of flat faces, met after others, that send a field back: near a mirror reflection."""
    found = _mirrors(met)
    if setting.planes.any_curved:
        found &= (met.plane == NO_PLANE) | ~setting.planes.curved[met.plane]
    return np.flatnonzero(found)


def _mirrors(met: Met) -> np.ndarray:
    """Whether the ways in and back, of faces that the radar looks at from the lit side, are near those of a mirror."""
    across = np.abs(met.slope) + np.abs(met.rise)
    middle = 2.0 + 2.0 * dot(met.waves.direction, met.back)
    return np.asarray(across > MIRROR * np.sqrt(np.maximum(middle, 0.0)))


def facing(setting: Setting, met: Met) -> np.ndarray:
    """Rows that send something straight back if nothing is in between: lit, ahead of the radar and within reach."""
    sends = _mirrors(met)
    if setting.reflections.scatters:
        sends |= setting.reflections.diffuse(met.table) > 0
    if setting.planes.any_curved:
        sends |= setting.planes.curved[met.plane] & (met.plane != NO_PLANE)
    sends &= met.rise * met.slope > 0
    sends &= met.back[0] > 0
    sends &= met.way + met.out < 2.0 * setting.seen
    return np.flatnonzero(sends)


def _azimuth(local: np.ndarray) -> np.ndarray:
    """Sines (k,) of the azimuths of directions in the sensor frame."""
    return np.asarray(local[1] / np.maximum(np.sqrt(local[0] ** 2 + local[1] ** 2), 1e-12))
