"""What flat and rough faces send back to the radar: physical optics, and Lambert's law.

The tubes on one flat face, and along one set of faces for a corner, add up as fields: over a tube's footprint the phase
is linear, and its integral a product of two sinc functions, so tubes may be many wavelengths wide. In angular form the
field of a tube is gain x reflection x solid angle x (way in / way back) x exp(-j k way), near and far (Ling, Chou and
Lee, "Shooting and bouncing rays", IEEE Trans. AP-37 (1989) 194-205).

A rough face scatters part of the power by Lambert's law, which adds up as powers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from sensors.compiled import compiled

from .rays import Tubes
from .waves import Met, Setting

MIRROR = 0.7
"""Least cosine between a face's normal and the middle of the ways in and back: physical optics is good to about 40 deg
from the mirror reflection, and what it gives beyond is far below the lobe."""

OWN = np.uint64(1 << 60)
"""Added to the keys of single hits, which are like no other."""


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

    @classmethod
    def of(cls, columns: Iterable[np.ndarray], bounces: int) -> Arrivals:
        """Of columns (k,): range, velocity, sines and power."""
        range_m, velocity, azimuth, height, power = columns
        return cls(range_m, velocity, azimuth, height, power, bounces=bounces)

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


@dataclass(slots=True)
class Facing:
    """Faces ahead that send something straight back if nothing is in between: m rows of `Met`.

    mirrors: (m,) bool, those that are flat and near a mirror reflection. out: (m,) [m] from the radar, rays: (m, 6)
    float32, there; back: (m, 3) float32, the same in the sensor's axes.
    """

    row: np.ndarray
    mirrors: np.ndarray
    out: np.ndarray
    rays: np.ndarray
    back: np.ndarray

    def at(self, seen: np.ndarray) -> Facing:
        """Some of them; seen: (m,) bool."""
        rows = np.flatnonzero(seen)
        return Facing(*(getattr(self, each.name).take(rows, axis=0) for each in fields(self)))


def facing(setting: Setting, met: Met) -> Facing:
    """Those that are lit from the radar's side, ahead of it and within reach."""
    count = len(met)
    found = (
        *(np.empty(count, np.int64), np.empty(count, bool), np.empty(count)),
        *(np.empty((count, 6), np.float32), np.empty((count, 3), np.float32)),
    )
    tables = met.faces.planes, setting.faces.curved, setting.reflections.tables.diffuse, setting.rotation
    count = _facing(met.waves.each, met.each, *tables, 2.0 * setting.seen, *found)
    return Facing(*(each[:count] for each in found))


def again(setting: Setting, tubes: Tubes, met: Met) -> Arrivals:
    """What rough faces, met after others, send back along the way on which the wave came."""
    found = np.empty((5, len(met)), np.float32)
    own = tubes.weight, tubes.azimuth, tubes.elevation
    received, diffuse = 4.0 * setting.antenna.receives, setting.reflections.tables.diffuse
    count = _again(met.waves.each, met.each, diffuse, *own, received, setting.seen, found)
    return Arrivals.of(found[:, :count], met.waves.bounce)


def rough(setting: Setting, tubes: Tubes, met: Met, seen: Facing) -> Arrivals:
    """What some rough faces, met after others, send straight back: by the two ways in both orders."""
    antenna, back = setting.antenna, seen.back.T
    gains, found = (antenna.sends(back), antenna.hears(back)), np.empty((5, 2 * len(seen.row)), np.float32)
    own = tubes.solid, tubes.sends, tubes.hears, tubes.azimuth, tubes.elevation
    received, diffuse = 4.0 * antenna.receives, setting.reflections.tables.diffuse
    count = _rough(met.waves.each, met.each, seen.row, diffuse, *own, *gains, received, found)
    return Arrivals.of(found[:, :count], met.waves.bounce)


def flat(setting: Setting, tubes: Tubes, met: Met, rows: np.ndarray, back: np.ndarray | None = None) -> Arrivals:
    """What some flat faces send straight back: each tube's field; back: (m, 3), the ways, None: those of the tubes.

    The way is worked out in float64, down to a fraction of a wave; amplitudes and phases then are float32.
    """
    antenna, images, count = setting.antenna, met.waves.images, len(rows)
    hears = tubes.hears if back is None else antenna.hears(back.T)
    found, zone = np.empty((5, count), np.float32), np.empty(count, np.float32)
    turns, field, group = np.empty((3, count), np.float32), np.empty(count, np.complex64), np.empty(count, np.uint64)
    _flat(
        *(met.waves.image, met.waves.each, met.each, rows, met.faces.normal, setting.keys, images.key, images.turn),
        *(tubes.azimuth, tubes.elevation, tubes.width, tubes.height, tubes.solid, tubes.sends),
        *(hears, back is None, setting.reflections.tables.amplitude),
        *(antenna.wavelength, math.sqrt(antenna.power) / (4.0 * math.pi)),
        *(found, zone, group, turns, field),
    )
    phase, *across = turns
    for angle in across:  # sin(x) / x, and 1 for 0
        angle += np.float32(1e-20)
        field *= np.sin(angle) / angle
    wave = np.empty_like(field)
    np.cos(phase, out=wave.real)
    np.sin(phase, out=wave.imag)
    field *= wave
    found[4] = field.real**2 + field.imag**2
    return replace(Arrivals.of(found, met.waves.bounce), field=field, group=group, zone=zone)


@compiled
def _azimuth(back: Any) -> Any:
    """Sine of the azimuth of a direction in the sensor's axes."""
    return back[1] / max(math.sqrt(back[0] ** 2 + back[1] ** 2), 1e-12)


@compiled
def _power(field: Any) -> Any:
    return field.real**2 + field.imag**2


@compiled
def _inner(one: Any, two: Any) -> Any:
    return one[0] * two[0] + one[1] * two[1] + one[2] * two[2]


@compiled
def _facing(
    waves: np.ndarray,
    met: np.ndarray,
    planes: int,
    curved: np.ndarray,
    diffuse: np.ndarray,
    rotation: np.ndarray,
    longest: float,
    rows: np.ndarray,
    mirrors: np.ndarray,
    out: np.ndarray,
    rays: np.ndarray,
    back: np.ndarray,
) -> int:
    """Writes the arrays of `Facing`, and counts them; longest: way there and back [m]."""
    count = 0
    for row in range(len(met)):
        one = met[row]
        if one.rise * one.slope <= 0 or one.back[0] <= 0 or one.way + one.out >= longest:
            continue
        middle = math.sqrt(max(2.0 + 2.0 * _inner(waves[one.wave].direction, one.back), 0.0))
        mirror = abs(one.slope) + abs(one.rise) > MIRROR * middle
        bent = one.face < planes and curved[one.face]
        if mirror or bent or diffuse[one.table] > 0:
            rows[count], mirrors[count], out[count] = row, mirror and not bent, one.out
            for axis in range(3):
                toward = rotation[axis, 0], rotation[axis, 1], rotation[axis, 2]
                rays[count, 3 + axis], back[count, axis] = _inner(toward, one.back), one.back[axis]
            count += 1
    return count


@compiled
def _again(
    waves: np.ndarray,
    met: np.ndarray,
    diffuse: np.ndarray,
    weight: np.ndarray,
    azimuth: np.ndarray,
    elevation: np.ndarray,
    received: float,
    seen: float,
    found: np.ndarray,
) -> int:
    """Writes into `found` (5, k), and counts, what Lambert's law sends back on the way in.

    Cross section 4 x share x area x cosine squared.
    """
    count = 0
    for at in range(len(met)):
        one = met[at]
        if diffuse[one.table] > 0 and one.way < seen:
            wave = waves[one.wave]
            power = diffuse[one.table] * weight[wave.row] * wave.wide**2 * received * one.cosine
            power *= (_power(wave.field) / one.way) ** 2
            found[0, count], found[1, count], found[4, count] = one.way, one.coming, power
            found[2, count], found[3, count] = azimuth[wave.row], elevation[wave.row]
            count += 1
    return count


@compiled
def _rough(
    waves: np.ndarray,
    met: np.ndarray,
    rows: np.ndarray,
    diffuse: np.ndarray,
    solid: np.ndarray,
    sends: np.ndarray,
    hears: np.ndarray,
    azimuth: np.ndarray,
    elevation: np.ndarray,
    back_sends: np.ndarray,
    back_hears: np.ndarray,
    received: float,
    found: np.ndarray,
) -> int:
    """Writes into `found` (5, 2 k), and counts, what Lambert's law sends straight back, and in the other order.

    Cross section 4 x share x area x cosines in and back.
    """
    count = 0
    for at in range(len(rows)):
        one = met[rows[at]]
        if diffuse[one.table] > 0:
            wave = waves[one.wave]
            power = diffuse[one.table] * solid[wave.row] * wave.wide**2 * received
            power *= _power(wave.field) * abs(one.rise) / one.out**2
            for end in (count, count + 1):
                found[0, end], found[1, end] = (one.way + one.out) / 2, (one.coming + one.going) / 2
            found[2, count], found[3, count] = _azimuth(one.back), one.back[2]
            found[4, count] = power * sends[wave.row] * back_hears[at]
            found[2, count + 1], found[3, count + 1] = azimuth[wave.row], elevation[wave.row]
            found[4, count + 1] = power * hears[wave.row] * back_sends[at]
            count += 2
    return count


@compiled
def _flat(
    images: np.ndarray,
    waves: np.ndarray,
    met: np.ndarray,
    rows: np.ndarray,
    normals: np.ndarray,
    face_keys: np.ndarray,
    image_keys: np.ndarray,
    turn: np.ndarray,
    azimuth: np.ndarray,
    elevation: np.ndarray,
    width: np.ndarray,
    height: np.ndarray,
    solid: np.ndarray,
    sends: np.ndarray,
    hears: np.ndarray,
    of_tubes: bool,
    amplitude: np.ndarray,
    wavelength: float,
    scale: float,
    found: np.ndarray,
    zone: np.ndarray,
    group: np.ndarray,
    turns: np.ndarray,
    field: np.ndarray,
) -> None:
    """Writes range, rate and sines of the angles into `found` (5, k), the sizes of Fresnel zones, keys of the faces on
    the way, whatever their order, amplitudes of fields, and into `turns` (3, k) [rad] their phases and half the turns
    of phase across and up the tubes.

    hears: gains, of the tubes, or else of the ways back.
    """
    for at in range(len(rows)):
        one = met[rows[at]]
        wave = waves[one.wave]
        image, row, way, back = images[one.wave], wave.row, one.way + one.out, one.back
        found[0, at], found[1, at], found[2, at], found[3, at] = (
            way / 2,
            (one.coming + one.going) / 2,
            _azimuth(back),
            back[2],
        )
        zone[at] = math.sqrt(wavelength / way)
        known = one.face < len(face_keys) - 1
        group[at] = image_keys[image] + (face_keys[one.face] if known else np.uint64(row) + OWN)
        gain = math.sqrt(sends[row] * hears[row if of_tubes else at]) * one.way / one.out
        field[at] = amplitude[one.table] * wave.field * np.float32(scale * solid[row] * wave.wide**2 * gain)
        turns[0, at] = 2.0 * math.pi * (np.rint(way / wavelength) - way / wavelength)
        along = one.way * (1.0 + _inner(wave.direction, back)) / (-one.slope * wavelength)
        x = y = z = 0.0
        for axis in range(3):  # how many waves more on the way, per radian, as mirrors show it
            more = normals[one.face, axis] * along + back[axis] * one.way / wavelength
            x += turn[image, axis, 0] * more
            y += turn[image, axis, 1] * more
            z += turn[image, axis, 2] * more
        side, high = azimuth[row], elevation[row]
        ahead, level = math.sqrt(1.0 - side * side), math.sqrt(1.0 - high * high)
        turns[1, at] = math.pi * (ahead * y - side * x) * wave.wide * width[row]
        turns[2, at] = math.pi * (level * z - high * (ahead * x + side * y)) * wave.wide * height[row]
