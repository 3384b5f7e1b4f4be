"""What tubes meet first, and what comes straight back of it: in single precision, of all tubes of a block at once.

The distance of a hit, and the height of the radar over the plane that is hit, give the cosine of incidence. That is
enough for what rough faces scatter, and to choose the few tubes whose phase counts: those near a mirror reflection, and
those that are followed on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sensors.raycast.rays import Hits, RayBundle

from .planes import NO_PLANE
from .rays import Tubes
from .scattering import MIRROR, WIDEST, Arrivals
from .waves import FAINTEST, GRAZING, Setting, speeds_within

LEAST_M = np.float32(1e-12)
"""Distances below this [m] count as this."""


@dataclass(slots=True)
class Beam:
    """Neighbouring tubes that were cast together, and what they meet; n of them, from `first` of all tubes on.

    bundle: their rays. angle: (n,) int64, their angle cells. heights: (p + 1,) float32 [m] of the radar over the planes
    they may meet, 0 over others, as if it were in them. owner: (n,) int32, the only surface whose hits count, None for
    all.
    """

    first: int
    bundle: RayBundle
    angle: np.ndarray
    heights: np.ndarray
    owner: np.ndarray | None
    hits: Hits

    def blocks(self, size: int, seen: float) -> Iterator[tuple[Beam, slice]]:
        """Its tubes in blocks, but for those in which none meets anything nearer than `seen` [m]."""
        count = len(self.angle)
        for first in range(0, count, size):
            part = slice(first, min(first + size, count))
            if self.hits.distance[part].min() < seen:
                yield self, part


@dataclass(slots=True)
class Lit:
    """Some tubes of a beam, and what they meet; n of them.

    part: of the beam, tubes: of all. plane: (n,) int64, `NO_PLANE` where it is not known. distance: (n,) float32 [m].
    cosine: (n,) float32 of incidence, 0 for those that meet nothing. table: (n,) int32, places in the reflection
    tables. unknown: (m,) rows of those that meet no known plane.
    """

    part: slice
    tubes: slice
    plane: np.ndarray
    distance: np.ndarray
    cosine: np.ndarray
    table: np.ndarray
    unknown: np.ndarray


def heights(setting: Setting, skip: np.ndarray | None) -> np.ndarray:
    """Heights (p + 1,) float32 [m] of the radar over planes; 0 over those of surfaces that are skipped, (s,) bool."""
    found = np.abs(setting.heights).astype(np.float32)
    if skip is not None:
        found[:-1][skip[setting.planes.surface]] = 0.0
    return np.asarray(found)


def lit(setting: Setting, beam: Beam, part: slice) -> Lit:
    """What some tubes of a beam meet."""
    hits = beam.hits
    distance, plane = hits.distance[part], setting.planes.of_hits(hits, part)
    counts = distance < np.float32(setting.seen)
    if beam.owner is not None:
        counts &= np.take(setting.surfaces, plane) == beam.owner[part]
    distance = np.maximum(distance, LEAST_M)
    cosine = np.take(beam.heights, plane)
    cosine /= distance
    np.minimum(cosine, np.float32(1), out=cosine)
    cosine *= counts
    table = np.take(setting.tables, plane)
    unknown = np.zeros(0, np.intp)
    if setting.deforms:
        assert hits.normals is not None
        unknown = np.flatnonzero(counts & (plane == NO_PLANE))
        rows = unknown + part.start
        cosine[unknown] = np.abs((hits.normals[rows].T * beam.bundle.directions[:, rows]).sum(axis=0))
        table[unknown] = setting.reflections.of_surfaces(hits.surfaces(rows))
    table += setting.reflections.steps(cosine)
    tubes = slice(beam.first + part.start, beam.first + part.stop)
    return Lit(part, tubes, plane, distance, cosine, table, unknown)


def scattered(setting: Setting, tubes: Tubes, beam: Beam, lit: Lit) -> Arrivals:
    """What rough faces send straight back. Cross section 4 x share x area x cosine squared (Lambert)."""
    part = lit.tubes
    power = setting.reflections.diffuse(lit.table)
    power *= lit.cosine
    power *= tubes.weight[part]
    power *= np.float32(4.0 * setting.antenna.receives)
    power /= lit.distance
    power /= lit.distance
    rows = np.flatnonzero(power > 0)
    rate = _rates(setting, beam, lit)
    return Arrivals(
        np.take(lit.distance, rows),
        np.broadcast_to(np.float32(0), len(rows)) if rate is None else np.take(rate, rows),
        np.take(tubes.azimuth[part], rows),
        np.take(tubes.elevation[part], rows),
        np.take(power, rows),
        angle=np.take(beam.angle[lit.part], rows),
    )


def _rates(setting: Setting, beam: Beam, lit: Lit) -> np.ndarray | None:
    """Rates (n,) float32 [m/s] of the distances; None where nothing moves."""
    directions, hits = beam.bundle.directions[:, lit.part], beam.hits
    linear = setting.twists.linear.astype(np.float32)
    rate: np.ndarray | None = None
    if not setting.alike:
        body = np.take(setting.planes.body, lit.plane)
        rate = np.take(linear[:, 0], body) * directions[0]
        for axis in (1, 2):
            rate += np.take(linear[:, axis], body) * directions[axis]
    elif not setting.still:
        rate = np.einsum("i,ik->k", linear[-1], directions)
    if len(lit.unknown):
        row = lit.unknown + lit.part.start
        within = speeds_within(setting, hits.surfaces(row), hits, row)
        rate = np.zeros(len(lit.plane), np.float32) if rate is None else rate
        rate[lit.unknown] += (within * directions[:, lit.unknown]).sum(axis=0)
    return rate


def mirrors(setting: Setting, tubes: Tubes, lit: Lit) -> np.ndarray:
    """Rows of flat faces near their mirror reflection, whose phase turns less than `WIDEST` times over a tube."""
    rows = np.flatnonzero(lit.cosine > MIRROR)
    if setting.planes.any_curved:
        rows = rows[~setting.curved[np.take(lit.plane, rows)]]
    tube, square = rows + lit.tubes.start, np.take(lit.cosine, rows) ** 2
    turns = np.maximum(np.take(tubes.width, tube), np.take(tubes.height, tube)) * np.take(lit.distance, rows)
    turns *= np.float32(2.0 / (WIDEST * setting.antenna.wavelength))
    return np.compress(turns**2 * (1.0 - square) < square, rows)


def bent(setting: Setting, lit: Lit) -> np.ndarray:
    """Rows of faces of curved surfaces."""
    return np.flatnonzero(np.take(setting.curved, lit.plane) & (lit.cosine > GRAZING))


def leading(setting: Setting, tubes: Tubes, lit: Lit) -> np.ndarray:
    """Rows of the tubes that flat faces send on and that are followed."""
    rows = np.flatnonzero((tubes.wide[lit.tubes] > 0) & (lit.cosine > GRAZING))
    kept = np.take(setting.reflections.strength, np.take(lit.table, rows)) > FAINTEST
    if setting.deforms or setting.planes.any_curved:
        plane = np.take(lit.plane, rows)
        kept &= (plane != NO_PLANE) & ~np.take(setting.curved, plane)
    return np.compress(kept, rows)
