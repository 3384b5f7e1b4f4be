"""The lines of a lidar: which emitters scan at one elevation, counted from the lowest; what messages call rings."""

from __future__ import annotations

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass

from .config import EmitterState, LidarConfig

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
