"""Several returns of one beam: groups the hits of its sub-rays into echoes."""

from __future__ import annotations

import numpy as np

from graph.base.records import dataclass
from sensors.raycast.rays import NO_SURFACE

from .config import LidarConfig

LIGHT_M_PER_NS = 0.299792458
TYPICAL_DIVERGENCE_DEG = 0.17
"""Full angle of a beam if its profile gives none: 3 mrad, as in data sheets of rotating lidars."""

GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))


@dataclass(slots=True)
class Candidates:
    """Hits of the beams' sub-rays, in any order: m hits.

    beam: (m,) number of the beam; distance: (m,) float32 [m]; light: (m,) float32, the returned light, relative to a
    whole beam on a white diffuse surface along its normal; normals (m, 3) float32; surface (m,) int32.
    """

    beam: np.ndarray
    distance: np.ndarray
    light: np.ndarray
    normals: np.ndarray
    surface: np.ndarray

    @classmethod
    def joined(cls, parts: list[Candidates]) -> Candidates:
        """All hits of several sets."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__slots__))

    def at(self, rows: np.ndarray) -> Candidates:
        """Some of the hits."""
        return Candidates(*(np.take(getattr(self, name), rows, axis=0, mode="clip") for name in Candidates.__slots__))


MISS = Candidates(
    np.zeros(1, np.intp),
    np.zeros(1, np.float32),
    np.zeros(1, np.float32),
    np.zeros((1, 3), np.float32),
    np.full(1, NO_SURFACE, np.int32),
)
"""A ray without a hit."""


def form_echoes(hits: Candidates, *, separation: float, least: float, most: int) -> Candidates:
    """The echoes of beams, ordered by beam, then from near to far.

    Hits of a beam within `separation` [m] of one another form one echo: its light is the sum of theirs; its distance is
    their mean, weighted by the returned energy light / distance^2; surface and normal are those of the hit with the
    most energy. Echoes with less energy than `least` [1/m^2] are not detected. Of more than `most` echoes, the
    strongest is kept, then the last, then the first, then the stronger ones.
    """
    if not len(hits.beam):
        return hits
    order = _by_beam_and_distance(hits)
    beam, distance, light = (np.take(array, order) for array in (hits.beam, hits.distance, hits.light))
    new = np.ones(len(beam), bool)
    new[1:] = (np.diff(beam) != 0) | (np.diff(distance) > separation)
    start = np.flatnonzero(new)
    echo = np.cumsum(new) - 1
    energy = light.astype(np.float64) / np.maximum(distance, 1e-3).astype(np.float64) ** 2
    total = np.bincount(echo, energy)
    seen = np.flatnonzero((total >= least) & (total > 0))
    seen = seen[_chosen(np.take(beam, start[seen]), total[seen], most)]
    echoes = hits.at(np.take(order, _brightest(energy, echo, start)[seen]))
    moment, nearest = np.bincount(echo, energy * distance)[seen], distance[start[seen]]
    alone = np.diff(start, append=len(echo))[seen] == 1
    echoes.distance = np.where(alone, nearest, moment / total[seen]).astype(np.float32)
    echoes.light = np.bincount(echo, light)[seen].astype(np.float32)
    return echoes


def _by_beam_and_distance(hits: Candidates) -> np.ndarray:
    """(m,) order of hits by beam, then distance, then position.

    The bits of positive floats have the order of the floats, and hits come as a few runs of ascending beams, which a
    stable sort of integers merges twenty times as fast as a sort by two keys.
    """
    key = hits.beam.astype(np.uint64) << np.uint64(32)
    key |= np.ascontiguousarray(hits.distance, np.float32).view(np.uint32)
    return np.argsort(key, kind="stable")


def _brightest(energy: np.ndarray, echo: np.ndarray, start: np.ndarray) -> np.ndarray:
    """(e,) the hit of each echo with the most energy, the last of equal ones; echo: (m,), ascending."""
    most = np.flatnonzero(energy == np.take(np.maximum.reduceat(energy, start), echo))
    found = np.empty(len(start), np.intp)
    found[echo[most]] = most
    return found


def echo_ids(beam: np.ndarray) -> np.ndarray:
    """(n,) uint8: 0 for the first return of each beam, then 1 ...; `beam` (n,) is ascending."""
    return _places(beam)[0].astype(np.uint8)


def _chosen(beam: np.ndarray, energy: np.ndarray, most: int) -> np.ndarray:
    """(k,) the echoes to keep so that no beam has more than `most`; beam: (e,), ascending; energy: (e,)."""
    place, count = _places(beam)
    crowded = np.flatnonzero(count > most)
    if not len(crowded):
        return np.arange(len(beam))
    kept = np.ones(len(beam), bool)
    beam, energy, place, count = beam[crowded], energy[crowded], place[crowded], count[crowded]
    rank = np.full(len(crowded), 3)
    rank[place == 0] = 2
    rank[place == count - 1] = 1
    start = np.flatnonzero(place == 0)
    strongest = np.flatnonzero(energy == np.repeat(np.maximum.reduceat(energy, start), count[start]))
    rank[strongest[np.diff(beam[strongest], prepend=-1) != 0]] = 0
    if most > 2:  # otherwise strongest, last and first are enough to choose from
        ranked = np.lexsort((-energy, rank, beam))
    else:
        ranked = np.argsort(beam.astype(np.int64) * 4 + rank, kind="stable")
    kept[crowded[ranked[place >= most]]] = False
    return np.flatnonzero(kept)


def _places(beam: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each entry of ascending numbers: its index among equal ones, and how many they are."""
    if not len(beam):
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    start = np.flatnonzero(np.diff(beam, prepend=beam[0] - 1))
    lengths = np.diff(np.append(start, len(beam)))
    return np.arange(len(beam)) - np.repeat(start, lengths), np.repeat(lengths, lengths)


def separation(config: LidarConfig) -> float:
    """Least distance [m] of two echoes: minDistBetweenEchosM, else half the length of a pulse."""
    return config.min_dist_between_echos_m or LIGHT_M_PER_NS * config.pulse_time_ns / 2


class SubRays:
    """`count` rays that represent a beam: each carries the same share of its energy.

    They form a sunflower pattern (Vogel, "A better way to construct the sunflower head", 1979) over the elliptic cone
    of divergenceHorDeg and divergenceVerDeg (full angles; `TYPICAL_DIVERGENCE_DEG` if the profile gives none). A single
    one is the beam's axis.
    """

    def __init__(self, config: LidarConfig, count: int) -> None:
        number = np.arange(count)
        radius = np.sqrt((number + 0.5) / count) if count > 1 else np.zeros(1)
        half = [
            np.deg2rad((angle or TYPICAL_DIVERGENCE_DEG) / 2)
            for angle in (config.divergence_hor_deg, config.divergence_ver_deg)
        ]
        self.left = np.tan(half[0]) * radius * np.cos(number * GOLDEN_ANGLE)
        self.up = np.tan(half[1]) * radius * np.sin(number * GOLDEN_ANGLE)
        self.swing = float(max(half)) if count > 1 else 0.0
        """The largest angle [rad] between a sub-ray and its beam."""

    def __len__(self) -> int:
        return len(self.left)

    def directions(self, number: int, beams: np.ndarray) -> np.ndarray:
        """(3, n) float32 unit directions of one sub-ray of each beam (3, n), in the sensor frame."""
        left, up = self.left[number], self.up[number]
        if not left and not up:
            return beams
        x, y, z = beams.astype(np.float64)
        level = np.maximum(np.hypot(x, y), 1e-9)
        out = np.stack(
            [x - left * y / level - up * z * x / level, y + left * x / level - up * z * y / level, z + up * level]
        )
        return np.asarray(out / np.sqrt((out * out).sum(axis=0)), np.float32)
