"""What curved surfaces send back to the radar.

A tube that meets a face of a curved surface has a lobe about the normal there, spread over the angles to the face's
neighbours, as geometrical optics of the curved surface does. They add up as powers.
"""

from __future__ import annotations

import numpy as np

from .lines import MOST_ZONES, along_lines
from .planes import FADED
from .rays import Tubes
from .scattering import Arrivals
from .setting import Setting
from .waves import Met


def curved(setting: Setting, tubes: Tubes, met: Met) -> list[Arrivals]:
    """What faces of curved surfaces send straight back; after mirrors by the two ways in both orders."""
    if not setting.planes.any_curved or not len(met := _bent(setting, tubes, met, met.each["back"])):
        return []
    each, antenna = met.each, setting.antenna
    row, back, group = each["row"], each["back"].T, _surface_keys(setting, met)
    power = _glint(setting, tubes, met, _middle_ways(setting, met), each["out"]) / each["out"] ** 2
    range_m, rate = (each["way"] + each["out"]) / 2, (each["coming"] + each["going"]) / 2
    azimuth = back[1] / np.maximum(np.hypot(back[0], back[1]), 1e-12)
    first = power * np.take(tubes.sends, row) * antenna.hears(back)
    found = [Arrivals(range_m, rate, azimuth, back[2], first, group)]
    if met.bounce > 1:
        second = power * np.take(tubes.hears, row) * antenna.sends(back)
        own = tubes.azimuth[row], tubes.elevation[row]
        found.append(Arrivals(range_m, rate, *own, second, group))
    return found


def curved_again(setting: Setting, tubes: Tubes, met: Met) -> list[Arrivals]:
    """What faces of curved surfaces, met after mirrors, send back along the way on which the wave came."""
    if not setting.planes.any_curved or not len(met := _bent(setting, tubes, met, met.each["direction"])):
        return []
    each = met.each
    way, row, passed = each["way"], each["row"], np.abs(each["field"]) ** 2
    power = _glint(setting, tubes, met, -each["direction"], way) * passed / way**2
    power *= np.take(tubes.sends, row) * np.take(tubes.hears, row)
    power *= way < setting.seen
    own, group = (tubes.azimuth[row], tubes.elevation[row]), _surface_keys(setting, met)
    return [Arrivals(way, each["coming"], *own, power, group)]


def _bent(setting: Setting, tubes: Tubes, met: Met, back: np.ndarray) -> Met:
    """Those that are met within reach of their lobes; back: (k, 3), the ways back."""
    each, (wide, bend, square) = met.each, setting.planes.widths(setting.antenna.wavelength)
    row, plane, ways = each["row"], each["face"], 1.0 + _dot(each["direction"], back)
    sine = ways / 2.0 - (each["slope"] + _dot(met.faces.normal[plane], back)) ** 2 / 4.0
    solid = tubes.width[row] * tubes.height[row] * (each["wide"] ** 2 * FADED / 2.0)
    reach = wide[plane] + solid * (1.0 / 3.0 + bend[plane] * each["way"] ** 2 / each["cosine"])
    square, most = square[plane], MOST_ZONES * setting.antenna.wavelength * each["way"]
    reach += np.where(square < most, square / 2.0, 0.0) / each["way"] ** 2
    return met.at(np.flatnonzero(sine < reach))


def _glint(setting: Setting, tubes: Tubes, met: Met, ways: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """What faces of curved surfaces receive at 1 m [W m^2] (k,), at gain 1; ways: (k, 3), the middles of both ways,
    ends: (k,) [m], how long the ways back are.

    The integral of the lobe over all directions is pi x area, however wide it is. Each tube meets the surface where the
    normal has turned by `bend` from that of the face, and counts as a lobe of at least half its own footprint's turn:
    however many tubes meet a face, they add up to the surface. Where this is straight, as along a cylinder, the lobe is
    that of a line.
    """
    planes, wavelength, each = setting.planes, setting.antenna.wavelength, met.each
    row, plane, cosine = each["row"], each["face"], each["cosine"]
    axes, bend = planes.axes[plane], planes.bend[plane]
    place = (each["back"] * each["out"][:, None]) @ setting.rotation.T + setting.pose[:3, 3] - planes.middle[plane]
    across = np.einsum("pai,pi->pa", axes, ways @ setting.rotation.T)
    across -= np.einsum("pab,pbi,pi->pa", bend, axes, place) * _dot(ways, met.faces.normal[plane])[:, None]
    wide = each["wide"] ** 2
    solid = tubes.width[row] * tubes.height[row] * wide
    spread = planes.lobes(wavelength)[plane] + (solid / 12.0)[:, None, None] * np.eye(2)
    spread += np.einsum("pab,pcb->pac", bend, bend) * (solid * each["way"] ** 2 / (4.0 * cosine))[:, None, None]
    inverse = np.linalg.inv(spread)
    straight = np.take(planes.straight(wavelength), plane, axis=0)
    square = (straight**2).sum(axis=1)
    rows = np.flatnonzero(square)
    turns, unit = (straight * across).sum(axis=1)[rows], straight[rows] / np.sqrt(square[rows, None])
    across[rows] -= unit * (unit * across[rows]).sum(axis=1)[:, None]
    lobe = np.exp(-0.5 * np.einsum("pa,pab,pb->p", across, inverse, across)) * np.sqrt(np.linalg.det(inverse))
    if len(rows):
        length = np.sqrt(square[rows]) * (wavelength / 2.0)
        near = (1.0 / each["way"] + 1.0 / ends)[rows] / 2.0
        place = np.einsum("pa,pai,pi->p", unit, axes[rows], place[rows]) / length
        face = each["image"][rows].astype(np.int64) * len(planes.normal) + plane[rows]
        coarse, area = (solid * square)[rows], (solid * each["way"] ** 2 / cosine)[rows]
        lines = along_lines(face, near * length**2 / wavelength, turns, place, coarse, area)
        # In place of the Gaussian lobe along the line, of deviation 1.
        lobe[rows] *= lines * np.sqrt(2.0 * np.pi * square[rows] * np.einsum("pa,pab,pb->p", unit, spread[rows], unit))
    left = np.abs(each["field"] * setting.reflections.tables.amplitude[each["table"]]) ** 2
    return np.asarray(setting.antenna.receives * left * tubes.solid[row] * wide * lobe / (2.0 * cosine))


def _surface_keys(setting: Setting, met: Met) -> np.ndarray:
    """(k,) uint64 of the surface that sends back and of the mirrors on the way."""
    surface = np.take(setting.faces.surface, met.each["face"]).astype(np.uint64)
    return np.asarray(surface + np.take(met.images.key, met.each["image"]))


def _middle_ways(setting: Setting, met: Met) -> np.ndarray:
    """The middles (k, 3) between the ways in and back; of small faces from where their middles are.

    Over a face of less than a Fresnel zone the wave is flat; over a larger one each tube counts by itself, and `line`
    knows how it bends along a straight one.
    """
    planes, plane = setting.planes, met.each["face"]
    ways = -(met.each["direction"] + met.each["back"]) / 2.0
    if met.bounce == 1:
        size = 12.0 * planes.extent[plane].max(axis=(1, 2))
        lines = planes.widths(setting.antenna.wavelength)[2][plane] > 0
        small = np.flatnonzero((size < setting.antenna.wavelength * met.each["out"]) & ~lines)
        towards = (setting.pose[:3, 3] - planes.middle[plane[small]]) @ setting.rotation
        ways[small] = towards / np.linalg.norm(towards, axis=1)[:, None]
    return np.asarray(ways)


def _dot(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Dot products (k,) of vectors (k, 3)."""
    return np.asarray(np.einsum("ki,ki->k", one, two))
