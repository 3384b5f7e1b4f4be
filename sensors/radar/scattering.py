"""What faces send back to the radar: physical optics of flat ones, the spread lobes of curved ones, rough ones.

The tubes on one flat face, and along one set of faces for a corner, add up as fields: over a tube's footprint the phase
is linear, and its integral a product of two sinc functions, so tubes may be many wavelengths wide. In angular form the
field of a tube is gain x reflection x solid angle x (way in / way back) x exp(-j k way), near and far (Ling, Chou and
Lee, "Shooting and bouncing rays", IEEE Trans. AP-37 (1989) 194-205).

A face of a curved surface spreads its lobe over the angles to its neighbours, as geometrical optics of the curved
surface does; a rough one scatters part of the power by Lambert's law. Both add up as powers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sensors.raycast.rays import RayBundle

from .planes import NO_PLANE
from .rays import Tubes
from .waves import Met, Setting, face_keys, in_sight, met_faces, tangents

MIRROR = 0.7
"""Least cosine between a face's normal and the middle of the ways in and back: physical optics is good to about 40 deg
from the mirror reflection, and what it gives beyond is far below the lobe."""


WIDEST = 6.0
"""Turns of phase over a tube up to which it counts for a flat face: inside a face wider ones cancel to nothing, and an
edge they cannot resolve."""


@dataclass(slots=True)
class Arrivals:
    """Single contributions to what is received, k of them.

    range_m: half the way [m]. velocity: half its rate [m/s], positive where it grows. azimuth, height: sines of azimuth
    and elevation that it arrives from. power: (k,) [W]. field: (k,) complex [sqrt(W)], where they add up as fields;
    group: (k,) uint64 then, equal for those that do. zone: (k,) angles that the first Fresnel zone takes up then [rad].
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
    bounces: int = 1


def arrivals(setting: Setting, tubes: Tubes, bundle: RayBundle, skip: np.ndarray | None = None) -> Iterator[Arrivals]:
    """All that comes back along tubes, whose rays are those of the bundle; skip: as for `met_faces`."""
    for bounce, met in enumerate(met_faces(setting, tubes, bundle, skip), start=1):
        first = bounce == 1
        if bounce == 2:
            tubes = tubes.thinned()
        found = [] if first else list(_again(setting, tubes, met))
        seen = met if first else met.at(_in_sight(setting, met))
        for law in (_rough, _curved, _flat):
            found += law(setting, tubes, seen, first)
        for one in found:
            one.bounces = bounce
            yield one


def _again(setting: Setting, tubes: Tubes, met: Met) -> Iterator[Arrivals]:
    """What rough faces send back along the way on which the wave came."""
    met, sent = _rough_ones(setting, tubes, met)
    waves, antenna = met.waves, setting.antenna
    local = tubes.directions[:, waves.row]
    speed = waves.rate if met.speed is None else waves.rate + (met.speed * waves.direction).sum(axis=0)
    power = sent * antenna.gain(local[0]) ** 2 * met.cosine / met.way**2
    yield _arrivals(met, met.way, speed, local, power)


def _rough(setting: Setting, tubes: Tubes, met: Met, first: bool) -> Iterator[Arrivals]:
    """What rough faces send straight back; where others lie before them, by the two ways in both orders."""
    if first:
        yield from _rough_first(setting, tubes, met)
        return
    met, sent = _rough_ones(setting, tubes, met)
    waves, antenna = met.waves, setting.antenna
    local, back = tubes.directions[:, waves.row], setting.pose[:3, :3].T @ met.back
    leaving = -(met.normal * met.back).sum(axis=0)
    power = sent * antenna.gain(local[0]) * antenna.gain(back[0]) * leaving / met.out**2
    for direction in (back, local):
        yield _arrivals(met, (met.way + met.out) / 2.0, met.rate(), direction, power)


def _rough_first(setting: Setting, tubes: Tubes, met: Met) -> Iterator[Arrivals]:
    """The same where nothing lies before: for most rays of most worlds, so no array is taken apart."""
    if not setting.reflections.scatters:
        return
    row, antenna = met.waves.row, setting.antenna
    share = setting.reflections.diffuse(met.table)
    strength = tubes.solid * antenna.gain(tubes.directions[0]) ** 2 * (4.0 * antenna.receives)
    power = share * strength[row] * met.cosine / met.way**2
    sines = tubes.directions[1] / np.maximum(np.hypot(tubes.directions[0], tubes.directions[1]), 1e-12)
    velocity = np.broadcast_to(0.0, len(row)) if met.speed is None else met.rate()
    yield Arrivals(met.way, velocity, sines[row], tubes.directions[2][row], power)


def _rough_ones(setting: Setting, tubes: Tubes, met: Met) -> tuple[Met, np.ndarray]:
    """The faces that scatter by Lambert's law, and what each sends along its normal and receives at 1 m [W m^2].

    Cross section 4 x share x area x cosines in and back.
    """
    share = setting.reflections.diffuse(met.table)
    rows = np.flatnonzero(share > 0)
    met, share = met.at(rows), share[rows]
    waves = met.waves
    return met, setting.antenna.receives * 4.0 * share * tubes.solid[waves.row] * np.abs(waves.field) ** 2


def _curved(setting: Setting, tubes: Tubes, met: Met, first: bool) -> Iterator[Arrivals]:
    """Faces of curved surfaces: the integral of the lobe over all directions is pi x area, however wide it is."""
    planes = setting.planes
    met = met.at(np.flatnonzero((met.plane != NO_PLANE) & planes.curved[np.maximum(met.plane, 0)]))
    if not len(met.way):
        return
    waves, antenna, plane = met.waves, setting.antenna, met.plane
    across = np.einsum("pai,ip->pa", planes.axes[plane], _middle_ways(setting, met, first))
    wave = antenna.wavelength**2 / (96.0 * np.pi) * np.linalg.inv(planes.extent[plane] + 1e-12 * np.eye(2))
    tube = tubes.width[waves.row] * tubes.height[waves.row] / 12.0
    spread = planes.spread[plane] + wave + tube[:, None, None] * np.eye(2)
    inverse = np.linalg.inv(spread)
    lobe = np.exp(-0.5 * np.einsum("pa,pab,pb->p", across, inverse, across)) * np.sqrt(np.linalg.det(inverse))
    left = np.abs(waves.field * setting.reflections.coherent(met.table)) ** 2
    local, back = tubes.directions[:, waves.row], setting.pose[:3, :3].T @ met.back
    gain = antenna.gain(local[0]) * antenna.gain(back[0])
    power = antenna.receives * left * gain * tubes.solid[waves.row] * lobe / (2.0 * met.cosine * met.out**2)
    yield _arrivals(met, (met.way + met.out) / 2.0, met.rate(), back, power)


def _middle_ways(setting: Setting, met: Met, first: bool) -> np.ndarray:
    """The middles (3, k) between the ways in and back; of small faces from where their middles are.

    Over a face of less than a Fresnel zone the wave is flat; over a larger one each tube counts by itself.
    """
    ways = -(met.waves.direction + met.back) / 2.0
    if first:
        small = np.flatnonzero(
            12.0 * setting.planes.extent[met.plane].max(axis=(1, 2)) < setting.antenna.wavelength * met.out
        )
        towards = setting.pose[:3, 3] - setting.planes.middle[met.plane[small]]
        ways[:, small] = (towards / np.linalg.norm(towards, axis=1)[:, None]).T
    return np.asarray(ways)


def _flat(setting: Setting, tubes: Tubes, met: Met, first: bool) -> Iterator[Arrivals]:
    """Flat faces: each tube's field."""
    planes = setting.planes
    flat = (met.plane == NO_PLANE) | ~planes.curved[np.maximum(met.plane, 0)]
    flat &= _mirrors(met, first)
    if first:
        size = np.maximum(tubes.width, tubes.height)[met.waves.row]
        steep = met.way * size * (2.0 / setting.antenna.wavelength) * np.sqrt(1.0 - np.minimum(met.cosine, 1.0) ** 2)
        flat &= steep < WIDEST * met.cosine
    met = met.at(np.flatnonzero(flat))
    if not len(met.way):
        return
    waves, antenna = met.waves, setting.antenna
    number = 2.0 * np.pi / antenna.wavelength
    local, back = tubes.directions[:, waves.row], setting.pose[:3, :3].T @ met.back
    field = waves.field * setting.reflections.coherent(met.table) * tubes.solid[waves.row] * (met.way / met.out)
    field = field * np.sqrt(antenna.power * antenna.gain(local[0]) * antenna.gain(back[0])) / (4.0 * np.pi)
    sizes = tubes.width[waves.row], tubes.height[waves.row]
    for size, tangent in zip(sizes, tangents(setting, tubes, waves, first=first), strict=True):
        tilt = (met.normal * tangent).sum(axis=0) / met.cosine
        moved = met.way * (tangent + waves.direction * tilt)
        growth = met.way * tilt + (met.back * moved).sum(axis=0)
        field *= np.sinc(number * growth * size / (2.0 * np.pi))
    way = met.way + met.out
    field *= np.exp(-2j * np.pi * np.mod(way / antenna.wavelength, 1.0))
    found = _arrivals(met, way / 2.0, met.rate(), back, np.abs(field) ** 2)
    found.field, found.group, found.zone = field, face_keys(met), np.sqrt(antenna.wavelength / way)
    yield found


def _mirrors(met: Met, first: bool) -> np.ndarray:
    """Whether the ways in and back are near those of a mirror."""
    if first:
        return np.asarray(met.cosine > MIRROR)
    middle = met.waves.direction + met.back
    return np.asarray(-(met.normal * middle).sum(axis=0) > MIRROR * np.sqrt((middle**2).sum(axis=0)))


def _in_sight(setting: Setting, met: Met) -> np.ndarray:
    """Rows that send something straight back: from the lit side, ahead of the radar, nothing in between."""
    curved = setting.planes.curved[np.maximum(met.plane, 0)] & (met.plane != NO_PLANE)
    sends = curved | _mirrors(met, False) | (setting.reflections.diffuse(met.table) > 0)
    ahead = (met.back * setting.pose[:3, 0][:, None]).sum(axis=0) > 0
    rows = np.flatnonzero(sends & ahead & ((met.normal * met.back).sum(axis=0) < 0))
    return rows[in_sight(setting, met.out[rows], met.back[:, rows])] if len(rows) else rows


def _arrivals(
    met: Met, range_m: np.ndarray, velocity: np.ndarray, direction: np.ndarray, power: np.ndarray
) -> Arrivals:
    """What arrives from directions (3, k) in the sensor frame."""
    x, y, z = direction
    return Arrivals(range_m, velocity, y / np.maximum(np.hypot(x, y), 1e-12), z, power)
