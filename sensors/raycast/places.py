"""Where moving surfaces are as seen from the origin of rays, and which rays may meet them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .rays import MARGIN_RAD, RayBundle
from .windows import RayGrid, runs

_SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)


ALL_PAIRS = 100_000
"""Up to this many pairs of a ray and a surface, all are tried: it costs less than to select."""


@dataclass(frozen=True, slots=True)
class Places:
    """Positions of m moving surfaces, seen from the origins of p bundles.

    towards: (p, m, 3) float64 [m] to the centres of their spheres, world axes; distance: (p, m) [m] to them, more than
    0; radius: (p, m) [m], enlarged by the spread of the rays' origins; half: (p, m) [rad], of the cone that holds each.
    """

    towards: np.ndarray
    distance: np.ndarray
    radius: np.ndarray
    half: np.ndarray

    def some(self, looks: slice, surfaces: slice) -> Places:
        """Those of some of the surfaces, seen from some of the bundles."""
        at = looks, surfaces
        return Places(self.towards[at], self.distance[at], self.radius[at], self.half[at])


@dataclass(frozen=True, slots=True)
class Pairs:
    """k pairs of a moving surface and a bundle that sees it, sorted by surface, and the rays that may meet it.

    surface, look: (k,), the numbers of each. index: (r,) of the rays, counted through all bundles, with repeats; pair:
    (r,), for which pair each is, ascending.
    """

    surface: np.ndarray
    look: np.ndarray
    index: np.ndarray
    pair: np.ndarray

    def only(self, rows: np.ndarray) -> Pairs:
        """With some of the rays (n,), ascending."""
        return Pairs(self.surface, self.look, self.index.take(rows), self.pair.take(rows))

    def parted(self, surface: int) -> tuple[Pairs, Pairs]:
        """The pairs of the surfaces before one, and the others, whose surfaces count from it."""
        at = int(self.surface.searchsorted(surface))
        ray = int(self.pair.searchsorted(at))
        return (
            Pairs(self.surface[:at], self.look[:at], self.index[:ray], self.pair[:ray]),
            Pairs(self.surface[at:] - surface, self.look[at:], self.index[ray:], self.pair[ray:] - at),
        )


class Bounds:
    """Boxes (m, 2, 3) [m] around m moving surfaces, and spheres about the boxes' centres; in the frames of bodies.

    radii: (m,) [m] of the spheres; bodies: (m,), which body carries each.
    """

    def __init__(self, boxes: np.ndarray, radii: np.ndarray, bodies: np.ndarray) -> None:
        self.centres, half = boxes.mean(axis=1), (boxes[:, 1] - boxes[:, 0]) / 2
        self.radii, self.bodies = radii, bodies
        points = np.concatenate([self.centres[:, None], self.centres[:, None] + half[:, None] * _SIGNS], axis=1)
        self._points = np.ascontiguousarray(np.swapaxes(points, 1, 2))  # (m, 3, 9): centre and corners of each box
        self._turned: tuple[bytes, np.ndarray, np.ndarray] | None = None
        """The bodies' poses that were last asked for, and the points turned and their shifts by these."""

    def places(self, looks: Sequence[RayBundle], poses: np.ndarray) -> Places:
        """Where p bundles see them, with the bodies at `poses` (p or 1, b, 4, 4) float64 [m]."""
        key = poses.tobytes()
        if self._turned is None or self._turned[0] != key:
            own = poses[:, self.bodies]
            self._turned = key, own[..., :3, :3] @ self._points, own[..., :3, 3]
        _, turned, moved = self._turned
        points = turned + (moved - np.array([look.origin for look in looks])[:, None])[..., None]
        towards = points[..., 0]
        lengths = np.maximum(np.sqrt((points * points).sum(axis=-2)), 1e-12)
        distance = lengths[..., 0]
        spread = np.array([[look.spread()] for look in looks])
        radius = self.radii + spread
        half = np.arcsin(np.minimum(radius / distance, 1.0))
        half[distance <= radius * 1.001] = np.pi
        if not spread.any():  # any cone of less than a right angle that holds a box's corners holds the box
            along = (points[..., 1:] * towards[..., None]).sum(axis=-2) / lengths[..., 1:]
            cosine = along.min(axis=-1) / distance
            corners = np.arccos(np.minimum(np.maximum(cosine, -1.0), 1.0))
            half = np.where(cosine > 1e-3, np.minimum(half, corners), half)
        return Places(towards, distance, radius, half + [[MARGIN_RAD + look.swing] for look in looks])


def windows(rays: RayBundle, looks: Sequence[RayBundle], places: Places, seen: np.ndarray) -> Pairs:
    """The rays that may lie in the cones of the surfaces seen (p, m) bool, and some more.

    looks: the p bundles that make up `rays`.
    """
    sizes = np.array([len(look.table) for look in looks])
    starts = sizes.cumsum() - sizes
    grid, axes = looks[0].grid, places.towards
    if grid is None:
        surface, look = np.nonzero(seen.T)
        if sizes[look].sum() <= ALL_PAIRS:
            return Pairs(surface, look, runs(starts[look], sizes[look]), np.arange(len(look)).repeat(sizes[look]))
        grid, span, shift = RayGrid(rays.table[:, 3:6], starts.tolist()), np.arange(len(looks)), 0 * starts
    else:
        span, shift = np.array([one.span for one in looks]), starts - [one.first for one in looks]
        axes = axes @ np.array([one.grid.rotation for one in looks if one.grid is not None])
    along = (axes * grid.middles[span, None]).sum(axis=-1) / places.distance
    between = np.arccos(np.minimum(np.maximum(along, -1.0), 1.0))
    surface, look = np.nonzero((seen & (between <= places.half + (grid.angles[span, None] + MARGIN_RAD))).T)
    index, counts = grid.near_local(axes[look, surface], places.half[look, surface], span[look])
    found = Pairs(surface, look, index, np.arange(len(look)).repeat(counts))
    if shift.any():
        index += shift[look].take(found.pair)
    if (sizes < grid.sizes[span]).any():
        first = starts[look].take(found.pair)
        found = found.only(np.flatnonzero((index >= first) & (index < first + sizes[look].take(found.pair))))
    return found
