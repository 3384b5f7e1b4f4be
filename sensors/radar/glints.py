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

NEAR = np.sqrt(12.0)
"""Deviations of a face's area from its middle within which it tells where the surface reflects: its own length."""


def curved(setting: Setting, tubes: Tubes, met: Met) -> list[Arrivals]:
    """What faces of curved surfaces send straight back; after mirrors by the two ways in both orders."""
    if not setting.planes.any_curved or not len(met := _bent(setting, tubes, met, met.each["back"])):
        return []
    each, antenna = met.each, setting.antenna
    row, back, group = each["row"], each["back"].T, _surface_keys(setting, met)
    moved = _moved(setting, met, -(each["direction"] + each["back"]) / 2.0, each["out"])
    power = _glint(setting, tubes, met, _middle_ways(setting, met), each["out"]) / each["out"] ** 2
    range_m, rate = (each["way"] + each["out"]) / 2, (each["coming"] + each["going"]) / 2
    first = power * np.take(tubes.sends, row) * antenna.hears(back)
    found = [Arrivals(range_m, rate, *_sines(each["back"] * each["out"][:, None] + moved), first, group)]
    if met.bounce > 1:
        second = power * np.take(tubes.hears, row) * antenna.sends(back)
        found.append(Arrivals(range_m, rate, *_outwards(met, moved), second, group))
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
    moved = _moved(setting, met, -each["direction"], way)
    return [Arrivals(way, each["coming"], *_outwards(met, moved), power, _surface_keys(setting, met))]


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
    bend = planes.bend[plane]
    across, place = _off(setting, met, ways)
    wide = each["wide"] ** 2
    solid = tubes.width[row] * tubes.height[row] * wide
    spread = planes.lobes(wavelength)[plane] + (solid / 12.0)[:, None, None] * np.eye(2)
    spread += np.einsum("pab,pcb->pac", bend, bend) * (solid * each["way"] ** 2 / 4.0)[:, None, None]
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
        places = (unit * place[rows]).sum(axis=1) / length
        face = each["image"][rows].astype(np.int64) * len(planes.normal) + plane[rows]
        coarse, area = (solid * square)[rows], (solid * each["way"] ** 2 / cosine)[rows]
        lines = along_lines(face, near * length**2 / wavelength, turns, places, coarse, area)
        # In place of the Gaussian lobe along the line, of deviation 1.
        lobe[rows] *= lines * np.sqrt(2.0 * np.pi * square[rows] * np.einsum("pa,pab,pb->p", unit, spread[rows], unit))
    lobe /= -np.expm1(-1.0 / np.trace(spread, axis1=1, axis2=2))  # none of a wide one is beyond the horizon
    lobe *= np.linalg.norm(ways, axis=1) * np.abs(_dot(ways, met.faces.normal[plane])) / cosine
    left = np.abs(each["field"] * setting.reflections.tables.amplitude[each["table"]]) ** 2
    return np.asarray(setting.antenna.receives * left * tubes.solid[row] * wide * lobe / 2.0)


def _moved(setting: Setting, met: Met, ways: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """From where tubes meet surfaces to where these reflect as a mirror, (k, 3) [m]: all of a lobe comes from there.

    As far as `NEAR` of a face tells, and of what is straight no farther than its ends. ways, ends: as in `_glint`, each
    of where its tube meets the face.
    """
    planes, each = setting.planes, met.each
    plane = each["face"]
    axes, (across, place) = planes.axes[plane], _off(setting, met, ways)
    near = (1.0 / each["way"] + 1.0 / ends) / 2.0
    turns = planes.bend[plane] + near[:, None, None] * np.eye(2)
    # Damped, since the place is nowhere where a hollow surface focuses on the radar.
    square = np.einsum("pba,pbc->pac", turns, turns) + 1e-6 * (near**2)[:, None, None] * np.eye(2)
    there = place + np.linalg.solve(square, np.einsum("pba,pb->pa", turns, across)[:, :, None])[:, :, 0]
    inverse = np.linalg.inv(planes.extent[plane] + 1e-12 * np.eye(2))
    there *= np.minimum(1.0, NEAR / np.sqrt(np.einsum("pa,pab,pb->p", there, inverse, there) + 1e-30))[:, None]
    half = np.take(planes.straight(setting.antenna.wavelength), plane, axis=0) * (setting.antenna.wavelength / 4.0)
    length = np.sqrt((half**2).sum(axis=1))
    unit = half / np.maximum(length, 1e-300)[:, None]
    along = (unit * there).sum(axis=1)
    there -= unit * (along - np.clip(along, -length, length))[:, None]
    return np.asarray(np.einsum("pa,pai->pi", there - place, axes) @ setting.rotation)


def _off(setting: Setting, met: Met, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far ways (k, 3) are off the normals of surfaces where tubes meet them, (k, 2) sines in the axes of faces, and
    (k, 2) [m] where this is from their middles.
    """
    planes, each = setting.planes, met.each
    plane = each["face"]
    axes = planes.axes[plane]
    place = (each["back"] * each["out"][:, None]) @ setting.rotation.T + setting.pose[:3, 3] - planes.middle[plane]
    within = np.einsum("pai,pi->pa", axes, place)
    across = np.einsum("pai,pi->pa", axes, ways @ setting.rotation.T)
    bent = np.einsum("pab,pb->pa", planes.bend[plane], within)
    return across - bent * _dot(ways, met.faces.normal[plane])[:, None], within


def _outwards(met: Met, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sines of azimuth and elevation in which tubes leave the radar for places moved by (k, 3) [m]."""
    each = met.each
    there = each["direction"] * each["way"][:, None] + moved
    return _sines(np.einsum("kij,ki->kj", met.images.turn[each["image"]], there))


def _sines(there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sines of azimuth and elevation of places (k, 3) in the sensor's axes."""
    x, y, z = there.T
    return y / np.maximum(np.hypot(x, y), 1e-12), z / np.linalg.norm(there, axis=1)


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
