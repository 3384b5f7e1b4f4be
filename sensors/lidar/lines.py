"""The lines of a lidar (the rings of messages), and the beams of a planar one as a row of equal angles."""

from __future__ import annotations

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass

from .config import EmitterState, LidarConfig
from .pattern import firing_pattern

SAME_DEG = 1e-3
"""Elevations closer than this [deg] are one line: they are stored as float32."""

MOST_LINES = 1 << 16
"""A message's field for rings is a uint16."""


@dataclass(frozen=True, slots=True)
class Lines:
    """ring: (states, emitters) int64, the line of each emitter, from 0 upwards. place: (states, emitters) int64, its
    place within the line by azimuth, from 0. count: lines; longest: emitters of the longest line of a state.
    """

    ring: np.ndarray
    place: np.ndarray
    count: int
    longest: int

    def check(self, name: str) -> None:
        """Raises UserError if the numbers of the lines do not fit a message's field."""
        if self.count > MOST_LINES:
            raise UserError(
                f"{name}: its emitters have {self.count:,} elevations, more than a ring field (uint16) can number; "
                "give numRaysPerLine, or leave the ring out"
            )


def lines_of(config: LidarConfig) -> Lines:
    """The lines of a configuration.

    Emitters of one elevation are a line, in whatever state. A solid-state lidar that declares several lines
    (numRaysPerLine) has these instead, in the order of their mean elevations: a mirror sweeps them aslant.
    """
    heights = np.stack([_heights(config, state) for state in config.emitter_states])
    distinct, which = np.unique(heights, return_inverse=True)
    new = np.diff(distinct, prepend=distinct[:1]) > SAME_DEG
    ring = np.cumsum(new)[which.reshape(heights.shape)]
    count = int(new.sum()) + 1
    if _declared(config):
        ring, count = _apart(config, ring)
    place, longest = np.zeros_like(ring), 0
    for own, rings, state in zip(place, ring, config.emitter_states, strict=True):
        order = np.lexsort((state.azimuth_deg, rings))
        size = np.bincount(rings, minlength=count)
        own[order] = np.arange(len(order)) - np.repeat(np.cumsum(size) - size, size)
        longest = max(longest, int(size.max()))
    return Lines(ring, place, count, longest)


def _declared(config: LidarConfig) -> bool:
    return not config.is_rotary and len(config.num_rays_per_line) > 1


def _heights(config: LidarConfig, state: EmitterState) -> np.ndarray:
    """(emitters,) float64 [deg]: the elevation of each emitter, or of its declared line."""
    elevation = state.elevation_deg.astype(np.float64)
    if not _declared(config):
        return elevation
    sizes = np.array([size for size in config.num_rays_per_line if size])
    means = np.add.reduceat(elevation, np.cumsum(sizes) - sizes) / sizes
    return np.repeat(means, sizes)


def _apart(config: LidarConfig, ring: np.ndarray) -> tuple[np.ndarray, int]:
    """Numbers declared lines of one state apart, also those of equal height, and counts them."""
    sizes = [size for size in config.num_rays_per_line if size]
    line = np.repeat(np.arange(len(sizes)), sizes)
    first = np.cumsum([0, *sizes[:-1]])
    keys = np.empty_like(ring)
    for own, rings in zip(keys, ring, strict=True):
        heights = rings[first]
        earlier = np.array([np.count_nonzero(heights[:number] == height) for number, height in enumerate(heights)])
        own[:] = (heights * len(sizes) + earlier)[line]
    distinct, which = np.unique(keys, return_inverse=True)
    return which.reshape(ring.shape), len(distinct)


GRID = 0.05
"""How far a beam may lie from its place in the row, as a fraction of the spacing: azimuths are stored as float32."""


@dataclass(frozen=True, slots=True)
class BeamRow:
    """`count` beams: number i has azimuth start_deg + i * step_deg [deg] (a negative step turns clockwise) and fires
    i * time_step_s [s] after the first, which fires `first_ns` after the begin of a turn.
    """

    start_deg: float
    step_deg: float
    count: int
    time_step_s: float
    first_ns: int = 0

    def place(self, azimuth_deg: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For azimuths (n,), the number of each beam, (n,) int64, and whether the beam is in the row, (n,) bool."""
        ahead = np.sign(self.step_deg) * (azimuth_deg.astype(np.float64) - self.start_deg)
        number = np.rint((ahead + abs(self.step_deg) / 2) % 360.0 / abs(self.step_deg) - 0.5).astype(np.int64)
        return number, (number >= 0) & (number < self.count)


def beam_row(config: LidarConfig) -> BeamRow:
    """One cell for each beam of a turn, starting at the first beam.

    Beams that fire along a row of equal steps keep their order; where a sector is passed at both ends of a turn, the
    cells between stay empty, so that times are true. Others, such as those of emitters that fire back and
    forth, are ordered counter-clockwise, with no time between them; if their spacing differs, cells have its mean.
    """
    pattern = firing_pattern(config)
    azimuth = pattern.azimuth_deg.astype(np.float64)
    if len(azimuth) < 2:
        return BeamRow(float(azimuth[0]) if len(azimuth) else 0.0, 360.0, len(azimuth), 0.0)
    turned = (np.diff(azimuth) + 180.0) % 360.0 - 180.0
    step = float(np.median(turned))
    turned = np.where(turned * step < 0, turned + np.sign(step) * 360.0, turned)
    row = _row(np.concatenate([[0.0], np.cumsum(turned)]), step) if step else None
    if row is not None:
        count, step = row
        seconds = float(pattern.offset_ns[-1] - pattern.offset_ns[0]) * 1e-9 / (count - 1)
        return BeamRow(float(azimuth[0]), step, count, seconds, int(pattern.offset_ns[0]))
    distinct = np.unique(azimuth)
    gap = int(np.argmax(np.diff(distinct, append=distinct[0] + 360.0)))  # the row begins after the largest gap
    start = float(distinct[(gap + 1) % len(distinct)])
    ahead = np.sort((distinct - start) % 360.0)
    row = _row(ahead, float(np.median(np.diff(ahead)))) if len(ahead) > 1 else None
    count, step = row or (len(ahead), float(ahead[-1]) / max(1, len(ahead) - 1) or 360.0)
    return BeamRow(start, step, count, 0.0, int(pattern.offset_ns[0]))


def _row(turned: np.ndarray, step: float) -> tuple[int, float] | None:
    """(count, step) of the row of equal steps that contains angles [deg] relative to the first; None if no row does."""
    place = np.rint(turned / step)
    if place[-1] < 1 or np.any(np.diff(place) < 1) or place[-1] * abs(step) > 360.0:
        return None
    step = float(turned[-1] / place[-1])
    return (int(place[-1]) + 1, step) if np.all(np.abs(turned - place * step) <= GRID * abs(step)) else None
