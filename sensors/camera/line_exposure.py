"""An image of a rolling shutter: which rays show which moment."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np

from graph.base.records import dataclass
from sensors.motion.history import History
from sensors.raycast.rays import Hits, RayBundle
from sensors.raycast.world import CastWorld

from .shutter import FORWARD, ORDERS, RollingShutter

BANDS = 32
"""Bands of lines; bodies stand still in each, as in its middle: an error of v T / 64 for a readout of T."""


@dataclass(frozen=True, slots=True)
class LineExposure:
    """The lines of one image, of width and height `size`, the last of which ends at `end` [s].

    The camera has, for each line, its pose of the middle of its exposure. Bodies are cast band by band, each as in the
    middle of its band; at once if nothing moves meanwhile.
    """

    shutter: RollingShutter
    size: tuple[int, int]
    history: History
    path: str
    end: Fraction

    @property
    def start(self) -> Fraction:
        """The begin of the first line [s]."""
        return self.end - self.shutter.duration(self.size)

    def poses(self) -> np.ndarray:
        """(lines, 4, 4) float64 [m], camera to world, of each line."""
        track = self.history.trajectory(self.path, self.start, self.end)
        shutter = self.shutter
        middles = np.arange(shutter.lines(self.size)) * float(shutter.offset) + float(shutter.exposure) / 2
        return np.asarray(track.poses(middles))

    def line_of(self) -> np.ndarray:
        """(height x width,) the line of each pixel, in the order of exposure."""
        width, height = self.size
        rows, columns = np.divmod(np.arange(width * height), width)
        line = rows if self.shutter.order in ORDERS[:2] else columns
        return line if self.shutter.order in FORWARD else self.shutter.lines(self.size) - 1 - line

    def rests(self, world: CastWorld) -> bool:
        """Whether only the camera moves during the exposure."""
        return not (world.bodies or world.soft) or self.history.rests(self.start, self.end, world.soft)

    def cast(self, world: CastWorld, bundle: RayBundle, *, normals: bool, spots: bool) -> Hits:
        """Casts a bundle: each band of lines at the state in the middle of its exposure."""
        duration, lines = self.end - self.start, self.shutter.lines(self.size)
        count = 1 if self.rests(world) else min(lines, BANDS)
        states = self.history.at([self.start + (2 * band + 1) * duration / (2 * count) for band in range(count)])
        if count == 1:
            return world.cast(bundle, states[0], normals=normals, spots=spots)
        band_of = self.line_of() * count // lines
        order = np.argsort(band_of, kind="stable")
        ends = np.searchsorted(band_of[order], np.arange(count + 1)).tolist()
        offsets = None if bundle.offsets is None else bundle.offsets[order]
        sorted_rays = RayBundle(bundle.origin, np.ascontiguousarray(bundle.table[order]), offsets, bundle.exclude)
        sorted_rays.spans = [sorted_rays.some(slice(*each)) for each in pairwise(ends)]
        return world.cast(sorted_rays, states, normals=normals, spots=spots).some(np.argsort(order))
