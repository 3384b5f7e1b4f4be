"""Where moving surfaces are as seen from the origin of rays, and which rays may meet them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sensors.compiled import compiled

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
        centres, half = boxes.mean(axis=1), (boxes[:, 1] - boxes[:, 0]) / 2
        self.radii, self.bodies = radii, bodies
        points = np.concatenate([centres[:, None], centres[:, None] + half[:, None] * _SIGNS], axis=1)
        self._points = points  # (m, 9, 3): centre and corners of each box

    def places(self, looks: Sequence[RayBundle], poses: np.ndarray) -> Places:
        """Where p bundles see them, with the bodies at `poses` (p or 1, b, 4, 4) float64 [m]."""
        shape = len(looks), len(self.radii)
        origins, spread = np.array([look.origin for look in looks]), np.array([look.spread() for look in looks])
        margin = np.array([MARGIN_RAD + look.swing for look in looks])
        radius = self.radii + spread[:, None]
        found = Places(np.empty((*shape, 3)), np.empty(shape), radius, np.empty(shape))
        _place(
            *(self._points, self.bodies, poses, origins, spread, margin),
            *(found.towards, found.distance, found.radius, found.half),
        )
        return found


@compiled
def _place(
    points: np.ndarray,
    bodies: np.ndarray,
    poses: np.ndarray,
    origins: np.ndarray,
    spread: np.ndarray,
    margin: np.ndarray,
    towards: np.ndarray,
    distance: np.ndarray,
    radius: np.ndarray,
    half: np.ndarray,
) -> None:
    """Fills `towards`, `distance` and `half` of `Places`; points: (m, 9, 3), the centre and corners of each box."""
    for look in range(len(origins)):
        state = min(look, len(poses) - 1)
        for surface in range(len(bodies)):
            body, cosine = bodies[surface], 1.0
            for point in range(9):
                x, y, z = points[surface, point, 0], points[surface, point, 1], points[surface, point, 2]
                square = along = 0.0
                for axis in range(3):
                    turned = (
                        poses[state, body, axis, 0] * x
                        + poses[state, body, axis, 1] * y
                        + poses[state, body, axis, 2] * z
                    )
                    at = turned + (poses[state, body, axis, 3] - origins[look, axis])
                    if point == 0:
                        towards[look, surface, axis] = at
                    square += at * at
                    along += at * towards[look, surface, axis]
                length = max(math.sqrt(square), 1e-12)
                if point == 0:
                    distance[look, surface] = away = length
                else:
                    cosine = min(cosine, along / (length * away))
            wide = np.pi
            if away > radius[look, surface] * 1.001:
                wide = math.asin(radius[look, surface] / away)
            if spread[look] == 0 and cosine > 1e-3:
                # Any cone of less than a right angle that holds a box's corners holds the box.
                wide = min(wide, math.acos(min(cosine, 1.0)))
            half[look, surface] = wide + margin[look]


def windows(
    rays: RayBundle, looks: Sequence[RayBundle], places: Places, seen: np.ndarray, distance: np.ndarray
) -> Pairs:
    """The rays that may lie in the cones of the surfaces seen (p, m) bool, and some more.

    looks: the p bundles that make up `rays`. distance: (n,) float32 [m] of former hits; rays that end before they reach
    the sphere of a surface are left out.
    """
    sizes = np.array([len(look.table) for look in looks])
    starts = sizes.cumsum() - sizes
    surface, look = np.nonzero(seen.T)
    first, grid, span = starts, looks[0].grid, np.array([one.span for one in looks])
    if grid is None and sizes[look].sum() <= ALL_PAIRS:
        index, counts = runs(starts[look], sizes[look]), sizes[look]
    else:
        axes = places.towards
        if grid is None:
            grid, span = RayGrid(rays.table[:, 3:6], starts.tolist()), np.arange(len(looks))
        else:
            axes = axes @ np.array([one.grid.rotation for one in looks if one.grid is not None])
            first = np.array([one.first for one in looks])
        index, counts = grid.near_local(axes[look, surface], places.half[look, surface], span[look])
    before = (places.distance - places.radius)[look, surface] - 1e-3
    index, pair, kept = _in_front(
        *(index, counts, (starts - first)[look], starts[look], sizes[look]),
        *(before.astype(np.float32), distance),
    )
    return Pairs(surface[kept], look[kept], index, pair)


@compiled(makes_arrays=True)
def _in_front(
    index: np.ndarray,
    counts: np.ndarray,
    shift: np.ndarray,
    first: np.ndarray,
    size: np.ndarray,
    before: np.ndarray,
    distance: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(ray (r,), cone (r,), kept (k,)): the rays of k cones that have any, and which they are of all.

    index: of the rays, cone after cone, `counts` of each, moved by its `shift`; those from `first` on, `size` of them,
    belong to it. distance: (n,) of the rays' hits, which are not farther than `before` for what is hidden.
    """
    rays, cones, kept = np.empty(len(index), np.intp), np.empty(len(index), np.intp), np.empty(len(counts), np.intp)
    end = total = number = 0
    for cone in range(len(counts)):
        begin, end, former = end, end + counts[cone], total
        for at in range(begin, end):
            ray = index[at] + shift[cone]
            if first[cone] <= ray < first[cone] + size[cone] and distance[ray] > before[cone]:
                rays[total], cones[total] = ray, number
                total += 1
        if total > former:
            kept[number] = cone
            number += 1
    return rays[:total], cones[:total], kept[:number]
