"""Where rays meet balls, boxes, cylinders, cones and capsules: by formula, in the frame of each solid, in float64.

A ray p = o + t d goes into a solid's frame by the inverse of the frame's matrix, which may scale, shear and mirror; t
stays the same. Origins are subtracted in float64 first, so a range is as exact far from the world's origin as near it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from graph.sim.geometry.closed_forms import ClosedForm

from .triangles import SKIN

BLOCK = 8192
"""Rays that are computed together, so that their numbers stay in the cache."""

SEAM = 1e-12
"""Tolerance where two pieces of a surface join, so that no ray passes between them."""

Span = tuple[np.ndarray, np.ndarray]
"""From where to where lines are inside a convex solid, (k,) float64; empty or NaN for those that never are."""


class Forms:
    """m solids with closed forms, ordered by kind.

    order: (m,) the place of each in the sequence it was made of.
    """

    def __init__(self, forms: Sequence[ClosedForm]) -> None:
        kinds = np.array([_number(form) for form in forms], np.intp)
        self.order = np.argsort(kinds, kind="stable")
        self._ends = np.searchsorted(kinds[self.order], np.arange(len(_KINDS) + 1))
        frames = np.array([forms[at].frame for at in self.order])
        self._inverse = np.linalg.inv(frames[:, :3, :3])
        self._centre = frames[:, :3, 3]
        self._sizes = np.array([(forms[at].low, forms[at].high) for at in self.order]).T
        boxes = np.array([forms[at].bounds() for at in self.order])
        self.boxes = boxes
        """(m, 2, 3) [m], the least and the greatest coordinates, in the frames of the surfaces."""
        self.radii = np.array([_radius(forms[at], box) for at, box in zip(self.order, boxes, strict=True)])
        """(m,) [m], of spheres about the boxes' centres that hold the solids."""

    def some(self, which: np.ndarray) -> Forms:
        """The solids `which` (k,), ascending; each may be there several times."""
        found = copy(self)
        found._ends = np.searchsorted(which, self._ends)
        found._inverse, found._centre, found._sizes = self._inverse[which], self._centre[which], self._sizes[:, which]
        return found

    def seen_from(self, origin: np.ndarray, poses: np.ndarray | None = None) -> PlacedForms:
        """The solids from an origin, (3,) or one for each (m, 3) float64 [m]; poses: (m, 4, 4), move each of them."""
        inverse, centre = self._inverse, self._centre
        if poses is not None:
            inverse = inverse @ np.swapaxes(poses[:, :3, :3], 1, 2)
            centre = (poses[:, :3, :3] @ centre[:, :, None])[:, :, 0] + poses[:, :3, 3]
        return PlacedForms(inverse, centre - origin, self._sizes, self._ends)


class PlacedForms:
    """The solids of a `Forms` as seen from one origin."""

    def __init__(self, inverse: np.ndarray, centre: np.ndarray, sizes: np.ndarray, ends: np.ndarray) -> None:
        self._sizes, self._ends = sizes, ends
        # By columns: the origin in the solid's frame (0 to 2), and the inverse (3 to 11).
        start = -(inverse @ centre[:, :, None])[:, :, 0]
        self._table = np.concatenate([start.T, inverse.reshape(-1, 9).T])

    def meet(self, index: np.ndarray, owner: np.ndarray, directions: np.ndarray, offsets: np.ndarray | None) -> Met:
        """Where rays meet the solids that are tried for them.

        index, owner: (k,) the ray and the solid of each pair, sorted by solid. directions: (3, n) float32 of all rays;
        offsets: (n, 3) float32 [m] of their origins from the solids' one. A ray that leaves a solid within `SKIN` of
        its origin started on its surface, and does not meet it there.
        """
        found: list[tuple[np.ndarray, ...]] = []
        for low, high, pairs, counts in self._blocks(owner):
            table = np.repeat(self._table[:, low:high], counts, axis=1)
            turn, start = table[3:].reshape(3, 3, -1), table[:3]
            ahead = _turned(turn, directions.take(index[pairs], axis=1).astype(np.float64))
            if offsets is not None:
                start += _turned(turn, offsets.take(index[pairs], axis=0).T.astype(np.float64))
            enter, leave = np.empty((2, len(ahead[0])))
            with np.errstate(all="ignore"):
                for number, some in self._by_kind(owner[pairs]):
                    sizes = self._sizes.take(owner[pairs][some], axis=1) if number in _SIZED else None
                    enter[some], leave[some] = _SPAN[number](start[:, some], ahead[:, some], sizes)
                rows, length = _ahead(enter, leave)
            point = ahead.take(rows, axis=1) * length
            point += start.take(rows, axis=1)
            found.append((rows + pairs.start, length, point))
        if len(found) != 1:
            found.append((np.zeros(0, np.intp), np.zeros(0), np.zeros((3, 0))))
            found = [tuple(np.concatenate(each, axis=-1) for each in zip(*found, strict=True))]
        rows, length, point = found[0]
        return Met(self, rows, length, owner.take(rows), point)

    def normals(self, owner: np.ndarray, point: np.ndarray) -> np.ndarray:
        """(k, 3) float32 unit normals, outwards, world axes, at points (3, k) in the frames of solids (k,), sorted."""
        local = np.empty_like(point)
        for number, some in self._by_kind(owner):
            sizes = self._sizes.take(owner[some], axis=1) if number in _SIZED else None
            local[:, some] = _NORMAL[number](point[:, some], sizes)
        turn = self._table[3:].take(owner, axis=1).reshape(3, 3, -1)
        normal = _turned(np.swapaxes(turn, 0, 1), local)
        normal /= np.sqrt(_dot(normal, normal))
        return np.asarray(normal.T.astype(np.float32))

    def _blocks(self, owner: np.ndarray) -> Iterator[tuple[int, int, slice, np.ndarray]]:
        """Runs of solids with about `BLOCK` pairs: from, to, the pairs, and how many each solid has."""
        counts = np.bincount(owner, minlength=self._table.shape[1])
        if 0 < len(owner) <= BLOCK:
            yield 0, len(counts), slice(0, len(owner)), counts
            return
        before = np.concatenate([[0], np.cumsum(counts)])
        low = 0
        while before[low] < len(owner):
            high = max(int(np.searchsorted(before, before[low] + BLOCK, side="right")) - 1, low + 1)
            if before[high] > before[low]:
                yield low, high, slice(int(before[low]), int(before[high])), counts[low:high]
            low = high

    def _by_kind(self, owner: np.ndarray) -> Iterator[tuple[int, slice]]:
        """Runs of pairs, sorted by solid, whose solids are of one kind: its number, and the pairs."""
        for number, (low, high) in enumerate(pairwise(owner.searchsorted(self._ends).tolist())):
            if high > low:
                yield number, slice(low, high)


@dataclass(frozen=True, slots=True)
class Met:
    """Pairs of a ray and a solid that it meets.

    rows: (k,) of those that were tried; length: (k,) float64 [lengths of the ray's direction] to the place; owner:
    (k,) the solids, ascending; point: (3, k) float64, the places in the frames of the solids.
    """

    forms: PlacedForms
    rows: np.ndarray
    length: np.ndarray
    owner: np.ndarray
    point: np.ndarray

    def normals(self, some: np.ndarray) -> np.ndarray:
        """(m, 3) float32 unit normals, outwards, world axes, of some of the pairs, in ascending order."""
        return self.forms.normals(self.owner.take(some), self.point.take(some, axis=1))


def _turned(turn: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    out = turn[:, 0] * vectors[0]
    out += turn[:, 1] * vectors[1]
    out += turn[:, 2] * vectors[2]
    return np.asarray(out)


def _dot(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    out = one[0] * two[0]
    out += one[1] * two[1]
    out += one[2] * two[2]
    return np.asarray(out)


def _ahead(enter: np.ndarray, leave: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the spans that have an end ahead, and the end that the ray meets first."""
    rows = np.flatnonzero((leave >= enter) & (leave >= 0))
    length, leave = enter.take(rows), leave.take(rows)
    inside = np.flatnonzero(length < 0)
    if len(inside):
        length[inside] = np.where(leave[inside] >= SKIN, leave[inside], np.inf)
        met = np.flatnonzero(np.isfinite(length))
        return rows[met], length[met]
    return rows, length


def _ball(start: np.ndarray, ahead: np.ndarray, sizes: np.ndarray | None) -> Span:
    return _within(_dot(ahead, ahead), _dot(start, ahead), _dot(start, start) - 1.0)


def _within(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From where to where a t^2 + 2 b t + c <= 0, for a > 0; NaN where it never is."""
    root = b * b
    root -= a * c
    np.sqrt(root, out=root)
    leave = root - b
    leave /= a
    np.add(root, b, out=root)
    np.negative(root, out=root)
    root /= a
    return root, leave


def _box(start: np.ndarray, ahead: np.ndarray, sizes: np.ndarray | None) -> Span:
    before, leave = _slab(start, ahead)
    return -before.min(axis=0), np.asarray(leave.min(axis=0))


def _slab(start: np.ndarray, ahead: np.ndarray, half: np.ndarray | None = None) -> Span:
    """From minus where to where |start + t ahead| <= half, or 1 (Kay and Kajiya 1986)."""
    middle = ahead + 1e-300  # a ray along a slab is never, or always, within it
    np.divide(1.0, middle, out=middle)
    span = np.abs(middle)
    if half is not None:
        span *= half
    middle *= start  # less than 0 where the ray comes to the middle of the slab
    leave = span - middle
    middle += span
    return middle, leave


def _cylinder(start: np.ndarray, ahead: np.ndarray, sizes: np.ndarray | None) -> Span:
    (x, y, z), (u, v, w) = start, ahead
    enter, leave = _within(u * u + v * v + 1e-300, x * u + y * v, x * x + y * y - 1.0)
    before, last = _slab(z, w)
    return np.maximum(enter, -before), np.minimum(leave, last)


def _quadratic(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The two roots of a t^2 + 2 b t + c, in any order; NaN or infinite for those that do not exist."""
    q = -(b + np.copysign(np.sqrt(b * b - a * c), b))
    return q / a, c / q


def _frustum(start: np.ndarray, ahead: np.ndarray, sizes: np.ndarray | None) -> Span:
    """The side x^2 + y^2 = (m + n z)^2 between the ends at z = -1 and 1, and the ends' discs."""
    assert sizes is not None
    low, high = sizes
    m, n = (low + high) / 2, (high - low) / 2
    (x, y, z), (u, v, w) = start, ahead
    level = m + n * z
    side = _quadratic(u * u + v * v - (n * w) ** 2, x * u + y * v - n * w * level, x * x + y * y - level * level)
    found = [np.where(np.abs(z + t * w) <= 1 + SEAM, t, np.nan) for t in side]
    for end, radius in ((-1.0, low), (1.0, high)):
        t = (end - z) / w
        found.append(np.where((x + t * u) ** 2 + (y + t * v) ** 2 <= (radius * radius) * (1 + SEAM), t, np.nan))
    enter = leave = found[0]
    for one in found[1:]:
        enter, leave = np.fmin(enter, one), np.fmax(leave, one)
    return enter, leave


def _capsule(start: np.ndarray, ahead: np.ndarray, sizes: np.ndarray | None) -> Span:
    """The union of a cylinder and a ball at each of its ends, which is convex."""
    assert sizes is not None
    (x, y, z), (u, v, w) = start, ahead
    low, high = sizes
    across, along, beside = u * u + v * v, x * u + y * v, x * x + y * y - 1.0
    side, slab = _within(across + 1e-300, along, beside), _slab(z, w, high)
    enter, leave = np.maximum(side[0], -slab[0]), np.minimum(side[1], slab[1])
    empty = ~(enter <= leave)
    enter[empty] = leave[empty] = np.nan
    across += w * w
    for end in (low, high):
        over = z - end
        first, last = _within(across, along + over * w, beside + over * over)
        enter, leave = np.fmin(enter, first), np.fmax(leave, last)
    return enter, leave


def _ball_normal(point: np.ndarray, sizes: np.ndarray | None) -> np.ndarray:
    return point


def _box_normal(point: np.ndarray, sizes: np.ndarray | None) -> np.ndarray:
    away = np.abs(point)
    return np.asarray(np.where(away == away.max(axis=0), np.sign(point), 0.0))


def _cylinder_normal(point: np.ndarray, sizes: np.ndarray | None) -> np.ndarray:
    return _side_or_end(point, 1.0, 0.0)


def _frustum_normal(point: np.ndarray, sizes: np.ndarray | None) -> np.ndarray:
    assert sizes is not None
    low, high = sizes
    slope = (high - low) / 2
    return _side_or_end(point, (low + high) / 2 + slope * point[2], slope)


def _side_or_end(point: np.ndarray, radius: np.ndarray | float, slope: np.ndarray | float) -> np.ndarray:
    """Normals of a frustum, by the surface that is nearer to each point; radius: of the side at its height."""
    x, y, z = point
    level = np.hypot(x, y)
    on_end = (np.abs(1 - np.abs(z)) < np.abs(level - radius)) | (level == 0)
    normal = np.stack([x, y, -slope * level])
    normal[:, on_end] = 0.0
    normal[2, on_end] = np.sign(z[on_end])
    return normal


def _capsule_normal(point: np.ndarray, sizes: np.ndarray | None) -> np.ndarray:
    assert sizes is not None
    (x, y, z), (low, high) = point, sizes
    return np.stack([x, y, z - np.clip(z, low, high)])


_KINDS = ("ball", "box", "cylinder", "frustum", "capsule")
_SPAN = (_ball, _box, _cylinder, _frustum, _capsule)
_NORMAL = (_ball_normal, _box_normal, _cylinder_normal, _frustum_normal, _capsule_normal)
_SIZED = (3, 4)
"""Kinds for which `low` and `high` matter."""


def _number(form: ClosedForm) -> int:
    """The place of a form in these tables; a cylinder is a frustum of one radius."""
    return _KINDS.index("cylinder" if form.kind == "frustum" and form.low == form.high else form.kind)


def _radius(form: ClosedForm, box: np.ndarray) -> float:
    """Of a sphere about the middle of a form's box that holds the form, rounded up."""
    sides, away = form.frame[:3, :3], form.frame[:3, 3] - box.mean(axis=0)
    if form.kind == "box":
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) @ sides.T + away
        reach = float(np.sqrt((corners * corners).sum(axis=1)).max())
    elif form.kind == "frustum":
        level = np.linalg.norm(sides[:, :2], 2)
        ends = (np.linalg.norm(away + z * sides[:, 2]) + r * level for z, r in ((-1.0, form.low), (1.0, form.high)))
        reach = float(max(ends))
    else:
        ends = (np.linalg.norm(away + z * sides[:, 2]) for z in (form.low, form.high))
        reach = float(max(ends) + np.linalg.norm(sides, 2))
    return reach * (1 + 1e-6) + 1e-6
