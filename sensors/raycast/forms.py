"""Where rays meet balls, boxes, cylinders, cones and capsules: by formula, in the frame of each solid, in float64.

A ray p = o + t d goes into a solid's frame by the inverse of the frame's matrix, which may scale, shear and mirror; t
stays the same. Origins are subtracted in float64 first, so a range is as exact far from the world's origin as near it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from graph.sim.geometry.closed_forms import ClosedForm

from .triangles import SKIN

BLOCK = 8192
"""Rays that are computed together, so that their numbers stay in the cache."""

ROUND = 1e-9
"""Relative difference of its scales up to which a ball is a sphere."""

SEAM = 1e-12
"""Tolerance where two pieces of a surface join, so that no ray passes between them."""

Rows = tuple[np.ndarray, np.ndarray]
"""Rows of rays that meet a solid, and where: t (k,) float64."""


class Forms:
    """m solids with closed forms, ordered by kind.

    order: (m,) the place of each in the sequence it was made of.
    """

    def __init__(self, forms: Sequence[ClosedForm]) -> None:
        kinds = np.array([_number(form) for form in forms], np.intp)
        self.order = np.argsort(kinds, kind="stable")
        self._ends = np.searchsorted(kinds[self.order], np.arange(len(_COLUMNS) + 1))
        frames = np.array([forms[at].frame for at in self.order])
        self._inverse = np.linalg.inv(frames[:, :3, :3])
        self._centre = frames[:, :3, 3]
        self._low, self._high = np.array([(forms[at].low, forms[at].high) for at in self.order]).T
        boxes = np.array([forms[at].bounds() for at in self.order])
        self.boxes = boxes
        """(m, 2, 3) [m], the least and the greatest coordinates, in the frames of the surfaces."""
        self.radii = np.array([_radius(forms[at], box) for at, box in zip(self.order, boxes, strict=True)])
        """(m,) [m], of spheres about the boxes' centres that hold the solids."""

    def seen_from(self, origin: np.ndarray, poses: np.ndarray | None = None) -> PlacedForms:
        """The solids from an origin (3,) float64 [m], each moved by one of the poses (m, 4, 4) if given."""
        inverse, centre = self._inverse, self._centre
        if poses is not None:
            inverse = inverse @ np.swapaxes(poses[:, :3, :3], 1, 2)
            centre = (poses[:, :3, :3] @ centre[:, :, None])[:, :, 0] + poses[:, :3, 3]
        return PlacedForms(inverse, centre - origin, self._low, self._high, self._ends)


class PlacedForms:
    """The solids of a `Forms` as seen from one origin."""

    def __init__(
        self, inverse: np.ndarray, centre: np.ndarray, low: np.ndarray, high: np.ndarray, ends: np.ndarray
    ) -> None:
        self._ends = ends
        # By columns: the origin in the solid's frame (0 to 2), the inverse (3 to 11), low, high (12, 13); for a sphere
        # its centre (0 to 2), its squared radius (3) and the origin's power with respect to it (4).
        start = -(inverse @ centre[:, :, None])[:, :, 0]
        self._table = np.concatenate([start.T, inverse.reshape(-1, 9).T, low[None], high[None]])
        spheres = slice(ends[0], ends[1])
        middle = centre[spheres]
        square = 1.0 / (inverse[spheres, 0] ** 2).sum(axis=1)
        self._table[:3, spheres], self._table[3, spheres] = middle.T, square
        self._table[4, spheres] = (middle * middle).sum(axis=1) - square

    def meet(self, index: np.ndarray, owner: np.ndarray, directions: np.ndarray, offsets: np.ndarray | None) -> Rows:
        """Where rays meet the solids that are tried for them: rows of the pairs that do, and t [lengths of d].

        index, owner: (k,) the ray and the solid of each pair, sorted by solid. directions: (3, n) float32 of all rays;
        offsets: (n, 3) float32 [m] of their origins from the solids' one. A ray that leaves a solid within `SKIN` of
        its origin started on its surface, and does not meet it there.
        """
        rows, ways = [np.zeros(0, np.intp)], [np.zeros(0)]
        for number, part, each in self._blocks(owner):
            found, length = _MEET[number](each, *_rays(index[part], directions, offsets))
            rows.append(found + part.start)
            ways.append(length)
        return np.concatenate(rows), np.concatenate(ways)

    def normals(
        self,
        index: np.ndarray,
        owner: np.ndarray,
        length: np.ndarray,
        directions: np.ndarray,
        offsets: np.ndarray | None,
    ) -> np.ndarray:
        """(k, 3) float32 unit normals, outwards, world axes, where rays meet solids after `length` (k,) float64.

        index, owner: as for `meet`, sorted by solid.
        """
        out = np.empty((len(index), 3), np.float32)
        for number, part, each in self._blocks(owner):
            normal = _NORMAL[number](each, *_rays(index[part], directions, offsets), length[part])
            normal /= np.sqrt(_dot(normal, normal))
            out[part] = normal.T
        return out

    def _blocks(self, owner: np.ndarray) -> Iterator[tuple[int, slice, np.ndarray]]:
        """Runs of pairs with solids of one kind: its number, the pairs, and the columns of the table for each."""
        counts = np.bincount(owner, minlength=self._table.shape[1])
        before = np.concatenate([[0], np.cumsum(counts)])
        for number, columns in enumerate(_COLUMNS):
            low, end = int(self._ends[number]), int(self._ends[number + 1])
            while low < end and before[low] < before[end]:
                high = int(np.searchsorted(before, before[low] + BLOCK, side="right")) - 1
                high = min(max(high, low + 1), end)
                if before[high] > before[low]:
                    each = np.repeat(self._table[:columns, low:high], counts[low:high], axis=1)
                    yield number, slice(int(before[low]), int(before[high])), each
                low = high


def _rays(
    index: np.ndarray, directions: np.ndarray, offsets: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray | None]:
    """Directions of some rays (3, k) float64, and offsets of their origins."""
    way = np.take(directions, index, axis=1).astype(np.float64)
    return way, None if offsets is None else np.take(offsets, index, axis=0).T.astype(np.float64)


def _into_frame(each: np.ndarray, way: np.ndarray, off: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (3, k) of rays in the frames of their solids."""
    turn = each[3:12].reshape(3, 3, -1)
    start = each[:3]
    if off is not None:
        start = start + _turned(turn, off)
    return start, _turned(turn, way)


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


def _ahead(enter: np.ndarray, leave: np.ndarray) -> Rows:
    """Of the interval that each line has inside a convex solid (empty or NaN without), the end that its ray meets."""
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero((leave >= enter) & (leave >= 0))
    enter, leave = enter[rows], leave[rows]
    inside = np.flatnonzero(enter < 0)
    if len(inside):
        length = enter
        length[inside] = np.where(leave[inside] >= SKIN, leave[inside], np.inf)
        met = np.flatnonzero(np.isfinite(length))
        return rows[met], length[met]
    return rows, enter


def _sphere(each: np.ndarray, way: np.ndarray, off: np.ndarray | None) -> Rows:
    """a t^2 - 2 b t + c = 0, with a = d.d, b = m.d and c = m.m - r^2, for the centre at m from the ray's origin."""
    middle, power = each[:3], each[4]
    if off is not None:
        middle = middle - off
        power = _dot(middle, middle) - each[3]
    a, b = _dot(way, way), _dot(middle, way)
    square = b * b
    square -= a * power
    rows = np.flatnonzero(square >= 0)
    a, b, root = a[rows], b[rows], np.sqrt(square[rows])
    met, length = _ahead((b - root) / a, (b + root) / a)
    return rows[met], length


def _ball(each: np.ndarray, way: np.ndarray, off: np.ndarray | None) -> Rows:
    start, ahead = _into_frame(each, way, off)
    with np.errstate(all="ignore"):
        return _ahead(*_within(_dot(ahead, ahead), _dot(start, ahead), _dot(start, start) - 1.0))


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


def _box(each: np.ndarray, way: np.ndarray, off: np.ndarray | None) -> Rows:
    start, ahead = _into_frame(each, way, off)
    enter, leave = _slab(start, ahead)
    return _ahead(enter.max(axis=0), leave.min(axis=0))


def _slab(start: np.ndarray, ahead: np.ndarray, half: np.ndarray | float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """From where to where |start + t ahead| <= half (Kay and Kajiya 1986)."""
    middle = ahead + 1e-300  # a ray along a slab is never, or always, within it
    np.divide(1.0, middle, out=middle)
    span = np.abs(middle)
    span *= half
    middle *= start  # less than 0 where the ray comes to the middle of the slab
    leave = span - middle
    middle += span
    return np.negative(middle, out=middle), leave


def _cylinder(each: np.ndarray, way: np.ndarray, off: np.ndarray | None) -> Rows:
    (x, y, z), (u, v, w) = _into_frame(each, way, off)
    with np.errstate(all="ignore"):
        enter, leave = _within(u * u + v * v + 1e-300, x * u + y * v, x * x + y * y - 1.0)
        first, last = _slab(z, w)
        return _ahead(np.maximum(enter, first), np.minimum(leave, last))


def _quadratic(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The two roots of a t^2 + 2 b t + c, in any order; NaN or infinite for those that do not exist."""
    q = -(b + np.copysign(np.sqrt(b * b - a * c), b))
    return q / a, c / q


def _frustum(each: np.ndarray, way: np.ndarray, off: np.ndarray | None) -> Rows:
    """The side x^2 + y^2 = (m + n z)^2 between the ends at z = -1 and 1, and the ends' discs."""
    start, ahead = _into_frame(each, way, off)
    low, high = each[12], each[13]
    m, n = (low + high) / 2, (high - low) / 2
    (x, y, z), (u, v, w) = start, ahead
    level = m + n * z
    with np.errstate(all="ignore"):
        side = _quadratic(u * u + v * v - (n * w) ** 2, x * u + y * v - n * w * level, x * x + y * y - level * level)
        found = [np.where(np.abs(z + t * w) <= 1 + SEAM, t, np.nan) for t in side]
        for end, radius in ((-1.0, low), (1.0, high)):
            t = (end - z) / w
            found.append(np.where((x + t * u) ** 2 + (y + t * v) ** 2 <= (radius * radius) * (1 + SEAM), t, np.nan))
        enter = leave = found[0]
        for one in found[1:]:
            enter, leave = np.fmin(enter, one), np.fmax(leave, one)
        return _ahead(enter, leave)


def _capsule(each: np.ndarray, way: np.ndarray, off: np.ndarray | None) -> Rows:
    """The union of a cylinder and a ball at each of its ends, which is convex."""
    (x, y, z), (u, v, w) = _into_frame(each, way, off)
    low, high = each[12:]
    with np.errstate(all="ignore"):
        across, along, beside = u * u + v * v, x * u + y * v, x * x + y * y - 1.0
        side, slab = _within(across + 1e-300, along, beside), _slab(z, w, high)
        enter, leave = np.maximum(side[0], slab[0]), np.minimum(side[1], slab[1])
        empty = ~(enter <= leave)
        enter[empty] = leave[empty] = np.nan
        across += w * w
        for end in (low, high):
            over = z - end
            first, last = _within(across, along + over * w, beside + over * over)
            enter, leave = np.fmin(enter, first), np.fmax(leave, last)
        return _ahead(enter, leave)


def _sphere_normal(each: np.ndarray, way: np.ndarray, off: np.ndarray | None, length: np.ndarray) -> np.ndarray:
    out = length * way
    out -= each[:3] if off is None else each[:3] - off
    return np.asarray(out)


def _in_frame(normal: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Normal:
    """The normals in the world of solids from those at points (3, k) of their own frames."""

    def turned(each: np.ndarray, way: np.ndarray, off: np.ndarray | None, length: np.ndarray) -> np.ndarray:
        start, ahead = _into_frame(each, way, off)
        ahead *= length
        ahead += start
        return _turned(np.swapaxes(each[3:12].reshape(3, 3, -1), 0, 1), normal(ahead, each[12:]))

    return turned


def _ball_normal(point: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    return point


def _box_normal(point: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    away = np.abs(point)
    return np.asarray(np.where(away == away.max(axis=0), np.sign(point), 0.0))


def _frustum_normal(point: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    (x, y, z), (low, high) = point, sizes
    slope = (high - low) / 2
    radius = (low + high) / 2 + slope * z
    level = np.hypot(x, y)
    on_end = (np.abs(1 - np.abs(z)) < np.abs(level - radius)) | (level == 0)
    normal = np.stack([x, y, -slope * level])
    normal[:, on_end] = 0.0
    normal[2, on_end] = np.sign(z[on_end])
    return normal


def _capsule_normal(point: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    (x, y, z), (low, high) = point, sizes
    return np.stack([x, y, z - np.clip(z, low, high)])


Normal = Callable[[np.ndarray, np.ndarray, "np.ndarray | None", np.ndarray], np.ndarray]

_KINDS = ("sphere", "ball", "box", "cylinder", "frustum", "capsule")
_MEET = (_sphere, _ball, _box, _cylinder, _frustum, _capsule)
_NORMAL: tuple[Normal, ...] = (
    _sphere_normal,
    *map(_in_frame, (_ball_normal, _box_normal, _frustum_normal, _frustum_normal, _capsule_normal)),
)
_COLUMNS = (5, 12, 12, 14, 14, 14)


def _number(form: ClosedForm) -> int:
    """The place of a form in these tables; a sphere is a ball of one scale, a cylinder a frustum of one radius."""
    if form.kind == "ball":
        scales = np.linalg.svd(form.frame[:3, :3], compute_uv=False)
        return _KINDS.index("sphere" if scales[0] - scales[-1] <= ROUND * scales[0] else "ball")
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
