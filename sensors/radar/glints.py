"""What curved surfaces send back to the radar.

A tube that meets a face of a curved surface has a lobe about the normal there, spread over the angles to the face's
neighbours, as geometrical optics of the curved surface does. They add up as powers.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sensors.compiled import compiled, inlined
from sensors.vectors import Vector, dot, row_of, times, transposed_times

from .images import Images
from .lines import MOST_ZONES, along_lines
from .planes import FADED, Curves
from .rays import Tubes
from .scattering import Arrivals, azimuth_of
from .setting import Setting, Space
from .tensors import Pair, form, inverse, pair, symmetric
from .waves import Met, strength

NEAR = math.sqrt(12.0)
"""Deviations of a face's area from its middle within which it tells where the surface reflects: its own length."""


class Glints(NamedTuple):
    """What curved faces send back, room for n of them; power at gain 1, but for the gains of the tubes where these are
    known.

    row: (n,) int64, which of those that are met. values: (4, n) float32, half the way [m] and half its rate [m/s],
    sines of azimuth and elevation from where it comes; outwards: (2, n), those in which it left. power: (n,) float64
    [W]; group: (n,) uint64 of the surface and of the mirrors on the way. Of faces that are straight along a line, m of
    them, line: (n,) int64, their places here, face: (n,) int64, equal for one line, and facts: (5, n) that
    `along_lines` takes.
    """

    row: np.ndarray
    values: np.ndarray
    outwards: np.ndarray
    power: np.ndarray
    group: np.ndarray
    line: np.ndarray
    face: np.ndarray
    facts: np.ndarray

    @classmethod
    def room(cls, count: int) -> Glints:
        """For so many."""
        row, line, face = np.empty((3, count), np.int64)
        values, outwards = np.empty((4, count), np.float32), np.empty((2, count), np.float32)
        return cls(
            *(row, values, outwards, np.empty(count), np.empty(count, np.uint64)), *(line, face, np.empty((5, count)))
        )


def curved(setting: Setting, tubes: Tubes, met: Met) -> list[Arrivals]:
    """What faces of curved surfaces send straight back; after mirrors by the two ways in both orders."""
    found = _found(setting, tubes, met, again=False)
    if met.bounce == 1 or not len(found.row):
        return _arrivals(found, found.values[2:], found.power)
    row, each = met.each["row"][found.row], met.each["back"][found.row]
    sends, hears = setting.antenna.gains(each.T)
    return [
        *_arrivals(found, found.values[2:], found.power * tubes.sends[row] * hears),
        *_arrivals(found, found.outwards, found.power * tubes.hears[row] * sends),
    ]


def curved_again(setting: Setting, tubes: Tubes, met: Met) -> list[Arrivals]:
    """What faces of curved surfaces, met after mirrors, send back along the way on which the wave came."""
    found = _found(setting, tubes, met, again=True)
    return _arrivals(found, found.outwards, found.power)


def _arrivals(found: Glints, sines: np.ndarray, power: np.ndarray) -> list[Arrivals]:
    if not len(power):
        return []
    return [Arrivals(np.concatenate((found.values[:2], sines)), power.astype(np.float32), found.group)]


def _found(setting: Setting, tubes: Tubes, met: Met, *, again: bool) -> Glints:
    found = Glints.room(len(met) if setting.planes.any_curved else 0)
    if len(found.row):
        space, curves, first = setting.space(met.faces), setting.scenery.curves, met.bounce == 1
        count, lines = _glints(met.each, again, first, met.images, space, curves, tubes, found)
        found = Glints(*(each[..., :count] for each in found))
        if lines:
            found.power[found.line[:lines]] *= along_lines(found.face[:lines], *found.facts[:, :lines])
    return found


@compiled
def _glints(
    met: np.ndarray,
    again: bool,
    first: bool,
    images: Images,
    space: Space,
    curves: Curves,
    tubes: Tubes,
    found: Glints,
) -> tuple[int, int]:
    """Writes what curved faces (k,) of `MET` send back, and counts them, and those that are straight along a line.

    again: back along the way on which the wave came, else straight to the radar; first: whether nothing was met before.
    """
    faces, wavelength = space.faces, space.wavelength
    count, lines = np.int64(0), np.int64(0)
    for at in range(len(met)):
        one = met[at]
        face, row, image, way = np.int64(one.face), np.int64(one.row), np.int64(one.image), one.way
        body, normal = faces.body[face], row_of(faces.normal, face)
        ahead, there = _vector(one.direction), _vector(one.back)
        back, out = (ahead, way) if again else (there, one.out)
        ways = 1.0 + dot(ahead, back)
        # In the axes of the face's body from here on.
        onward, there = transposed_times(faces.turn, body, ahead), transposed_times(faces.turn, body, there)
        back = transposed_times(faces.turn, body, back)
        wide = np.float64(one.wide) ** 2
        solid = np.float64(tubes.width[row] * tubes.height[row]) * wide
        near = (1.0 / way + 1.0 / out) / 2.0
        sine = ways / 2.0 - (one.slope + dot(normal, back)) ** 2 / 4.0
        reach, bent, square = curves.reach[face, 0], curves.reach[face, 1], curves.reach[face, 2]
        reach += solid * (FADED / 2.0) * (1.0 / 3.0 + bent * way**2 / one.cosine)
        if square < MOST_ZONES * wavelength * way:
            reach += square / 2.0 / way**2
        if not sine < reach:
            continue
        middle = row_of(curves.middle, face)
        here = row_of(faces.place, body)
        place = _in_plane(
            curves,
            face,
            (
                there[0] * one.out + here[0] - middle[0],
                there[1] * one.out + here[1] - middle[1],
                there[2] * one.out + here[2] - middle[2],
            ),
        )
        home = -(onward[0] + back[0]) / 2.0, -(onward[1] + back[1]) / 2.0, -(onward[2] + back[2]) / 2.0
        off = _off(curves, face, normal, home, place)
        # Over a face of less than a Fresnel zone the wave is flat, as from the face's middle. Over a larger one each
        # tube counts by itself, and `lines.line` knows how it bends along a straight one.
        lobe_home, lobe_off = home, off
        extent = symmetric(curves.extent, face)
        if first and 12.0 * max(extent[0], extent[1], extent[2]) < wavelength * out and not square > 0:
            towards = here[0] - middle[0], here[1] - middle[1], here[2] - middle[2]
            away = 1.0 / math.sqrt(dot(towards, towards))
            lobe_home = towards[0] * away, towards[1] * away, towards[2] * away
            lobe_off = _off(curves, face, normal, lobe_home, place)
        power = _lobe(curves, face, lobe_off, solid, way)
        if square > 0:
            straight, length = pair(curves.straight, face), math.sqrt(square)
            along = straight[0] * place[0] + straight[1] * place[1]
            found.line[lines], found.face[lines] = count, image * faces.planes + face
            found.facts[0, lines] = near * square / wavelength
            found.facts[1, lines] = straight[0] * lobe_off[0] + straight[1] * lobe_off[1]
            found.facts[2, lines] = along * wavelength / (2.0 * length) / length
            found.facts[3, lines] = solid * (2.0 * length / wavelength) ** 2
            found.facts[4, lines] = solid * way**2 / one.cosine
            lines += 1
        power *= math.sqrt(dot(lobe_home, lobe_home)) * abs(dot(lobe_home, normal)) / one.cosine
        left = one.field * space.tables.amplitude[one.table]
        power *= space.received / 8.0 * np.float64(strength(left)) * tubes.solid[row] * wide
        gain = np.float64(tubes.sends[row]) * tubes.hears[row]
        if again:
            power *= gain * strength(one.field) / way**2 if way < space.seen else 0.0
        else:
            power *= (gain if first else 1.0) / out**2
        x, y, z = times(faces.turn, body, _moved(curves, face, off, place, near, wavelength))
        if not again:
            back = one.back[0] * out + x, one.back[1] * out + y, one.back[2] * out + z
            found.values[2, count], found.values[3, count] = _sines(back)
        if not first:
            left_for = ahead[0] * way + x, ahead[1] * way + y, ahead[2] * way + z
            found.outwards[0, count], found.outwards[1, count] = _sines(transposed_times(images.turn, image, left_for))
        rate = one.coming if again else (one.coming + one.going) / 2.0
        found.values[0, count], found.values[1, count] = (way + out) / 2.0, rate
        found.row[count], found.power[count] = at, power
        found.group[count] = np.uint64(faces.surface[face]) + images.key[image]
        count += 1
    return int(count), int(lines)


@inlined
def _vector(array: np.ndarray) -> Vector:
    return array[0], array[1], array[2]


@inlined
def _sines(there: Vector) -> Pair:
    """Sines of azimuth and elevation of a place in the sensor's axes."""
    return azimuth_of(there), there[2] / math.sqrt(dot(there, there))


@inlined
def _in_plane(curves: Curves, face: Any, vector: Vector) -> Pair:
    """A vector in the axes of a face."""
    axes = curves.axes
    return (
        axes[face, 0, 0] * vector[0] + axes[face, 0, 1] * vector[1] + axes[face, 0, 2] * vector[2],
        axes[face, 1, 0] * vector[0] + axes[face, 1, 1] * vector[1] + axes[face, 1, 2] * vector[2],
    )


@inlined
def _off(curves: Curves, face: Any, normal: Vector, ways: Vector, place: Pair) -> Pair:
    """How far ways are off the normal of the surface at a place [m] from the middle of a face, as sines in its axes."""
    (x, y), bend, along = _in_plane(curves, face, ways), curves.bend, dot(ways, normal)
    return (
        x - (bend[face, 0, 0] * place[0] + bend[face, 0, 1] * place[1]) * along,
        y - (bend[face, 1, 0] * place[0] + bend[face, 1, 1] * place[1]) * along,
    )


@inlined
def _lobe(curves: Curves, face: Any, off: Pair, solid: Any, way: Any) -> Any:
    """The lobe of a face for ways that are so much off its normal, of a tube of a solid angle [sr] and a way [m].

    The integral of the lobe over all directions is pi x area, however wide it is. Each tube meets the surface where the
    normal has turned by `bend` from that of the face, and counts as a lobe of at least half its own footprint's turn:
    however many tubes meet a face, they add up to the surface. Along a straight line it is that of the line
    (`lines.along_lines`), in place of a Gaussian one of deviation 1.
    """
    bend, more, foot = curves.bend, solid / 12.0, solid * way**2 / 4.0
    (a, b), (c, d) = (bend[face, 0, 0], bend[face, 0, 1]), (bend[face, 1, 0], bend[face, 1, 1])
    xx, xy, yy = symmetric(curves.lobes, face)
    spread = xx + more + (a * a + b * b) * foot, xy + (a * c + b * d) * foot, yy + more + (c * c + d * d) * foot
    within, area = inverse(spread)
    (x, y), (u, v) = off, pair(curves.straight, face)
    square = u * u + v * v
    line = 1.0
    if square > 0:
        along = (u * x + v * y) / square
        x, y = x - u * along, y - v * along
        line = math.sqrt(2.0 * math.pi * form(spread, (u, v)))
    lobe = line * math.exp(-0.5 * form(within, (x, y))) / math.sqrt(area)
    return lobe / -math.expm1(-1.0 / (spread[0] + spread[2]))  # none of a wide one is beyond the horizon


@inlined
def _moved(curves: Curves, face: Any, off: Pair, place: Pair, near: Any, wavelength: Any) -> Vector:
    """From a place [m] on a face, where ways are so much off the normal, to where the surface reflects as a mirror [m],
    in the axes of the body: all of a lobe comes from there.

    As far as `NEAR` of a face tells, and of what is straight no farther than its ends. near: mean of the inverse ways.
    """
    bend, axes = curves.bend, curves.axes
    (a, b), (c, d) = (bend[face, 0, 0] + near, bend[face, 0, 1]), (bend[face, 1, 0], bend[face, 1, 1] + near)
    # Damped, since the place is nowhere where a hollow surface focuses on the radar.
    damped = 1e-6 * near**2
    (xx, xy, yy), _ = inverse((a * a + c * c + damped, a * b + c * d, b * b + d * d + damped))
    x, y = a * off[0] + c * off[1], b * off[0] + d * off[1]
    x, y = place[0] + xx * x + xy * y, place[1] + xy * x + yy * y
    wide, flat, tall = symmetric(curves.extent, face)
    within, _ = inverse((wide + 1e-12, flat, tall + 1e-12))
    share = min(1.0, NEAR / math.sqrt(form(within, (x, y)) + 1e-30))
    x, y = x * share, y * share
    u, v = pair(curves.straight, face)
    square = u * u + v * v
    if square > 0:
        along, end = (u * x + v * y) / square, wavelength / 4.0
        beyond = along - min(max(along, -end), end)
        x, y = x - u * beyond, y - v * beyond
    x, y = x - place[0], y - place[1]
    return (
        x * axes[face, 0, 0] + y * axes[face, 1, 0],
        x * axes[face, 0, 1] + y * axes[face, 1, 1],
        x * axes[face, 0, 2] + y * axes[face, 1, 2],
    )
