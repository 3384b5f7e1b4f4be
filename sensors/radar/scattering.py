"""What flat and rough faces send back to the radar: physical optics, and Lambert's law.

The tubes on one flat face, and along one set of faces for a corner, add up as fields: over a tube's footprint the phase
is linear, and its integral a product of two sinc functions, so tubes may be many wavelengths wide. In angular form the
field of a tube is gain x reflection x solid angle x (way in / way back) x exp(-j k way), near and far (Ling, Chou and
Lee, "Shooting and bouncing rays", IEEE Trans. AP-37 (1989) 194-205).

A rough face scatters part of the power by Lambert's law, which adds up as powers: its cross section is 4 x share x area
x cosine in x cosine back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sensors.compiled import inlined
from sensors.vectors import dot, transposed_times

from .bins import Bins, angle_cell, put
from .grouping import Sums
from .images import Images
from .rays import Tubes, angles_of
from .setting import Space
from .waves import Echo, Touch, Wave, strength

MIRROR = 0.7
"""Least cosine between a face's normal and the middle of the ways in and back: physical optics is good to about 40 deg
from the mirror reflection, and what it gives beyond is far below the lobe."""

WIDEST = 6.0
"""Turns of phase over a tube up to which it counts for a flat face: inside a face wider ones cancel to nothing, and an
edge they cannot resolve."""

OWN = np.uint64(1 << 60)
"""Added to the keys of single hits, which are like no other."""


@dataclass(slots=True)
class Arrivals:
    """Single contributions to what is received, k of them, which add up in groups before they do in cells.

    values: (4, k) float32, half the way [m] and half its rate [m/s], positive where it grows, and sines of azimuth and
    elevation that it arrives from. power: (k,) [W]. group: (k,) uint64, equal for fields that add up, and for the
    powers of one curved surface. field: (k,) complex [sqrt(W)], where they add up as fields; zone: (k,) angles that the
    first Fresnel zone takes up then [rad].
    """

    values: np.ndarray
    power: np.ndarray
    group: np.ndarray
    field: np.ndarray | None = None
    zone: np.ndarray | None = None

    @classmethod
    def together(cls, parts: list[Arrivals]) -> Arrivals:
        """Several of one kind as one."""
        columns: list[Any] = [[getattr(part, name) for part in parts] for name in cls.__slots__]
        together: list[Any] = [None if each[0] is None else np.concatenate(each, axis=-1) for each in columns]
        return cls(*together)


class Fields(NamedTuple):
    """What flat faces send straight back, one field for each tube; room for n.

    values: (4, n) float32, half the way [m] and half its rate [m/s], sines of azimuth and elevation. zone: (n,) float32
    [rad] and group: (n,) uint64, as in `Arrivals`. field: (n,) complex64, amplitudes [sqrt(W)]; turns: (3, n) float32,
    their phases and half the turns of phase across and up the tubes [rad].
    """

    values: np.ndarray
    zone: np.ndarray
    group: np.ndarray
    field: np.ndarray
    turns: np.ndarray

    @classmethod
    def room(cls, count: int) -> Fields:
        """For so many tubes."""
        values, turns, zone = (np.empty((*rows, count), np.float32) for rows in ((4,), (3,), ()))
        return cls(values, zone, np.empty(count, np.uint64), np.empty(count, np.complex64), turns)

    def first(self, count: int) -> Fields:
        """So many of them."""
        return Fields(*(each[..., :count] for each in self))


def arrived(found: Fields) -> Arrivals:
    """Arrivals (n,) of fields of tubes, with their phases; works in the arrays of `found`."""
    phase, *across = found.turns
    field, wave = found.field, np.empty_like(found.field)
    for angle in across:  # sin(x) / x, and 1 for 0
        angle += np.float32(1e-20)
        field *= np.sin(angle) / angle
    np.cos(phase, out=wave.real)
    np.sin(phase, out=wave.imag)
    field *= wave
    return Arrivals(found.values, field.real**2 + field.imag**2, found.group, field, found.zone)


@inlined
def azimuth_of(back: Any) -> Any:
    """Sine of the azimuth of a direction in the sensor's axes."""
    return back[1] / max(math.sqrt(back[0] ** 2 + back[1] ** 2), 1e-12)


@inlined
def scatter_again(space: Space, tubes: Tubes, wave: Wave, touch: Touch, echo: Echo, bins: Bins, sums: Sums) -> None:
    """Adds what a rough face, met after others, sends back along the way on which the wave came."""
    share = space.tables.diffuse[touch.table]
    if share > 0 and touch.way < space.seen:
        row = wave.row
        power = share * tubes.weight[row] * wave.wide**2 * space.received * touch.cosine
        power *= (strength(wave.field) / touch.way) ** 2
        side, level, angle = angles_of(tubes, row)
        put(bins, sums, touch.way, echo.coming, side, level, angle, power)


@inlined
def scatter_back(
    space: Space, tubes: Tubes, wave: Wave, touch: Touch, echo: Echo, sends: Any, hears: Any, bins: Bins, sums: Sums
) -> None:
    """Adds what a rough face, met after others, sends straight back, and what takes the same way in the other order.

    sends, hears: gains of the way straight back.
    """
    share = space.tables.diffuse[touch.table]
    if share > 0:
        row, way, rate = wave.row, (touch.way + echo.out) / 2, (echo.coming + echo.going) / 2
        power = share * tubes.solid[row] * wave.wide**2 * space.received
        power *= strength(wave.field) * abs(echo.rise) / echo.out**2
        side, level = azimuth_of(echo.back), echo.back[2]
        angle, _, _ = angle_cell(bins, side, level)
        put(bins, sums, way, rate, side, level, angle, power * (tubes.sends[row] * hears))
        power *= tubes.hears[row] * sends
        side, level, angle = angles_of(tubes, row)
        put(bins, sums, way, rate, side, level, angle, power)


@inlined
def reflect_back(
    space: Space, images: Images, tubes: Tubes, wave: Wave, touch: Touch, echo: Echo, hears: Any, found: Fields, at: Any
) -> bool:
    """Writes the field that a flat face sends straight back of one tube, if it counts; whether it does.

    hears: gain of the way back. The group is that of the faces on the way, whatever their order.
    """
    back, image, row, way = echo.back, wave.image, wave.row, touch.way + echo.out
    waves, there, normal = 1.0 / space.wavelength, touch.way / space.wavelength, touch.normal
    along = there * (1.0 + dot(wave.direction, back)) / -touch.slope
    more = (  # how many waves more on the way, per radian, as mirrors show it
        normal[0] * along + back[0] * there,
        normal[1] * along + back[1] * there,
        normal[2] * along + back[2] * there,
    )
    x, y, z = transposed_times(images.turn, image, more)
    side, high = tubes.azimuth[row], tubes.elevation[row]
    ahead, level = math.sqrt(1.0 - side * side), math.sqrt(1.0 - high * high)
    across = (ahead * y - side * x) * wave.wide * tubes.width[row]
    up = (level * z - high * (ahead * x + side * y)) * wave.wide * tubes.height[row]
    if max(abs(across), abs(up)) > WIDEST:
        return False
    found.turns[1, at], found.turns[2, at] = math.pi * across, math.pi * up
    found.turns[0, at] = 2.0 * math.pi * (np.rint(way * waves) - way * waves)
    found.values[0, at], found.values[1, at] = way / 2, (echo.coming + echo.going) / 2
    found.values[2, at], found.values[3, at] = azimuth_of(back), back[2]
    found.zone[at] = math.sqrt(space.wavelength / way)
    known = touch.face < space.faces.planes
    found.group[at] = images.key[image] + (space.keys[touch.face] if known else np.uint64(row) + OWN)
    gain = math.sqrt(tubes.sends[row] * hears) * touch.way / echo.out
    amplitude = np.float32(space.scale * tubes.solid[row] * wave.wide**2 * gain)
    found.field[at] = space.tables.amplitude[touch.table] * wave.field * amplitude
    return True
