"""Where moving surfaces are as seen from the origin of rays, and which rays may meet them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from graph.base.records import dataclass
from sensors.compiled import compiled, inlined
from sensors.vectors import Vector

from .rays import COMMON, MARGIN_RAD, RayBundle

_SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)


BLOCK = 16
"""Neighbouring rays without a grid whose box is tried before they are."""

ROUNDING = 1e-6
"""Boxes of blocks are off by no more than this, in the greatest distance of a sphere."""

MARGIN_M = 1e-3
"""Spheres are so much larger for rays, so that rounding loses none."""


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
    """The rays that may meet the surfaces seen (p, m) bool, and some more.

    looks: the p bundles that make up `rays`. distance: (n,) float32 [m] of former hits; rays that end before they reach
    the sphere of a surface are left out.
    """
    sizes = np.array([len(look.table) for look in looks])
    starts = sizes.cumsum() - sizes
    surface, look = np.nonzero(seen.T)
    if looks[0].grid is None:
        spread = np.array([one.spread() for one in looks])
        radius = (places.radius - spread[:, None])[look, surface] + MARGIN_M
        offsets = COMMON if rays.offsets is None else rays.offsets
        index, pair, kept = _through_spheres(
            *(rays.table, offsets, distance, float(spread.max(initial=0.0))),
            *(places.towards[look, surface], radius, starts[look], sizes[look]),
        )
    else:
        axes = places.towards @ np.array([one.grid.rotation for one in looks if one.grid is not None])
        first, span = np.array([one.first for one in looks]), np.array([one.span for one in looks])
        index, counts = looks[0].grid.near_local(axes[look, surface], places.half[look, surface], span[look])
        before = (places.distance - places.radius)[look, surface] - MARGIN_M
        ray, pair, kept = np.empty(len(index), np.intp), np.empty(len(index), np.intp), np.empty(len(counts), np.intp)
        total, number = _in_front(
            *(index, counts, (starts - first)[look], starts[look], sizes[look]),
            *(before.astype(np.float32), distance, ray, pair, kept),
        )
        index, pair, kept = ray[:total], pair[:total], kept[:number]
    return Pairs(surface[kept], look[kept], index, pair)


@compiled(makes_arrays=True)
def _through_spheres(
    table: np.ndarray,
    offsets: np.ndarray,
    distance: np.ndarray,
    spread: float,
    middle: np.ndarray,
    radius: np.ndarray,
    first: np.ndarray,
    size: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `_in_front`, for rays that meet a sphere before their hits; none needs a grid.

    table, offsets: of the rays, which begin within `spread` [m]. middle: (k, 3), radius: (k,) [m] of the spheres.
    """
    longest = 0.0
    for sphere in range(len(radius)):
        x, y, z = middle[sphere, 0], middle[sphere, 1], middle[sphere, 2]
        longest = max(longest, math.sqrt(x * x + y * y + z * z) + radius[sphere] + spread)
    count = (len(table) + BLOCK - 1) // BLOCK
    boxes, gaps = np.empty((6, count), np.float32), np.empty(count, np.float32)
    middles = np.empty((count, 7))  # begin and way of a ray in the middle of each block, how far others are off
    for block in range(count):
        first_ray, end_ray = block * BLOCK, min((block + 1) * BLOCK, len(table))
        one = (first_ray + end_ray) // 2
        own, far = min(one, len(offsets) - 1), min(np.float64(distance[one]), longest)
        a, b, c = np.float64(offsets[own, 0]), np.float64(offsets[own, 1]), np.float64(offsets[own, 2])
        u, v, w = table[one, 3] * far, table[one, 4] * far, table[one, 5] * far
        widest = 0.0
        low_x = low_y = low_z = np.inf
        high_x = high_y = high_z = -np.inf
        for ray in range(first_ray, end_ray):
            own, far = min(ray, len(offsets) - 1), min(np.float64(distance[ray]), longest)
            x, y, z = np.float64(offsets[own, 0]), np.float64(offsets[own, 1]), np.float64(offsets[own, 2])
            p, q, r = x + table[ray, 3] * far, y + table[ray, 4] * far, z + table[ray, 5] * far
            # What is not a number is in no box, and is not far off.
            low_x, high_x = _wider(low_x, high_x, x, p)
            low_y, high_y = _wider(low_y, high_y, y, q)
            low_z, high_z = _wider(low_z, high_z, z, r)
            x, y, z, p, q, r = x - a, y - b, z - c, p - a - u, q - b - v, r - c - w
            # At equal shares of two straight ways, points are at most as far apart as the farther pair of ends.
            near, away = x * x + y * y + z * z, p * p + q * q + r * r
            widest = near if near > widest else widest
            widest = away if away > widest else widest
        boxes[0, block], boxes[1, block], boxes[2, block] = low_x, low_y, low_z
        boxes[3, block], boxes[4, block], boxes[5, block] = high_x, high_y, high_z
        middles[block, 0], middles[block, 1], middles[block, 2] = a, b, c
        middles[block, 3], middles[block, 4], middles[block, 5] = u, v, w
        middles[block, 6] = math.sqrt(widest)
    rays, spheres = np.empty(4 * len(table) + BLOCK, np.intp), np.empty(4 * len(table) + BLOCK, np.intp)
    kept, total, number = np.empty(len(radius), np.intp), np.int64(0), np.int64(0)
    for sphere in range(len(radius)):
        x, y, z, square = middle[sphere, 0], middle[sphere, 1], middle[sphere, 2], radius[sphere] ** 2
        former, last = total, first[sphere] + size[sphere]
        begin, end = first[sphere] // BLOCK, (last + BLOCK - 1) // BLOCK
        _gaps(boxes, np.float32(x), np.float32(y), np.float32(z), gaps)
        most = np.float32((radius[sphere] + ROUNDING * longest) ** 2)
        for block in range(begin, end):
            if gaps[block] > most:
                continue
            if _passes(middles, block, (x, y, z), radius[sphere]):
                continue
            if total + BLOCK > len(rays):
                grown, others = np.empty(2 * len(rays), np.intp), np.empty(2 * len(rays), np.intp)
                for at in range(total):
                    grown[at], others[at] = rays[at], spheres[at]
                rays, spheres = grown, others
            for ray in range(max(block * BLOCK, first[sphere]), min((block + 1) * BLOCK, last)):
                own = min(ray, len(offsets) - 1)
                u, v, w = x - offsets[own, 0], y - offsets[own, 1], z - offsets[own, 2]
                along = u * table[ray, 3] + v * table[ray, 4] + w * table[ray, 5]
                along = min(max(along, 0.0), np.float64(distance[ray]))
                u, v, w = u - along * table[ray, 3], v - along * table[ray, 4], w - along * table[ray, 5]
                if u * u + v * v + w * w <= square:
                    rays[total], spheres[total] = ray, number
                    total += 1
        if total > former:
            kept[number] = sphere
            number += 1
    return rays[:total], spheres[:total], kept[:number]


@inlined
def _wider(low: Any, high: Any, one: Any, two: Any) -> tuple[Any, Any]:
    low, high = one if one < low else low, one if one > high else high
    return two if two < low else low, two if two > high else high


@inlined
def _gaps(boxes: np.ndarray, x: Any, y: Any, z: Any, gaps: np.ndarray) -> None:
    """Writes the squares (n,) of a place's distances from boxes (6, n)."""
    for block in range(len(gaps)):  # from 0 and without a branch, so that it runs as vectors
        u = max(max(boxes[0, block] - x, x - boxes[3, block]), np.float32(0))
        v = max(max(boxes[1, block] - y, y - boxes[4, block]), np.float32(0))
        w = max(max(boxes[2, block] - z, z - boxes[5, block]), np.float32(0))
        gaps[block] = u * u + v * v + w * w


@inlined
def _passes(middles: np.ndarray, block: Any, centre: Vector, radius: Any) -> bool:
    """Whether all rays of a block pass a sphere, by the way in its middle."""
    u, v, w = middles[block, 3], middles[block, 4], middles[block, 5]
    x, y, z = centre[0] - middles[block, 0], centre[1] - middles[block, 1], centre[2] - middles[block, 2]
    share = min(max((x * u + y * v + z * w) / max(u * u + v * v + w * w, 1e-300), 0.0), 1.0)
    x, y, z = x - share * u, y - share * v, z - share * w
    return bool(x * x + y * y + z * z > (radius + middles[block, 6]) ** 2)


@compiled
def _in_front(
    index: np.ndarray,
    counts: np.ndarray,
    shift: np.ndarray,
    first: np.ndarray,
    size: np.ndarray,
    before: np.ndarray,
    distance: np.ndarray,
    rays: np.ndarray,
    cones: np.ndarray,
    kept: np.ndarray,
) -> tuple[int, int]:
    """Writes `rays` (r,) and `cones` (r,), the rays of k cones that have any, and `kept` (k,), which they are of all;
    r and k.

    index: of the rays, cone after cone, `counts` of each, moved by its `shift`; those from `first` on, `size` of them,
    belong to it. distance: (n,) of the rays' hits, which are not farther than `before` for what is hidden.
    """
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
    return total, number
