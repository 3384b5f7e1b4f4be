"""Where rays meet balls, boxes, cylinders, cones and capsules: by formula, in the frame of each solid, in float64.

A ray p = o + t d goes into a solid's frame by the inverse of the frame's matrix, which may scale, shear and mirror; t
stays the same. Origins are subtracted in float64 first, so a range is as exact far from the world's origin as near it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy

import numpy as np

from graph.sim.geometry.closed_forms import ClosedForm
from sensors.compiled import compiled, inlined
from sensors.vectors import Vector, row_of, times, transposed_times

from .rays import COMMON
from .triangles import SKIN

SEAM = 1e-12
"""Tolerance where two pieces of a surface join, so that no ray passes between them."""

BALL, BOX, CYLINDER, FRUSTUM, CAPSULE = range(5)
_KINDS = {"ball": BALL, "box": BOX, "frustum": FRUSTUM, "capsule": CAPSULE}


class Forms:
    """m solids with closed forms."""

    def __init__(self, forms: Sequence[ClosedForm]) -> None:
        frames = np.array([form.frame for form in forms])
        self.inverse = np.linalg.inv(frames[:, :3, :3])
        """(m, 3, 3), from the axes of the surfaces to those of the solids; `centre`: (m, 3) [m], of the solids."""
        self.centre = frames[:, :3, 3]
        self.kinds = np.array([_kind(form) for form in forms])
        """(m,) numbers of their kinds, and `sizes`: (m, 2), `low` and `high` of `ClosedForm`."""
        self.sizes = np.array([(form.low, form.high) for form in forms])
        self.boxes = np.array([form.bounds() for form in forms])
        """(m, 2, 3) [m], the least and the greatest coordinates, in the frames of the surfaces."""
        self.radii = np.array([_radius(form, box) for form, box in zip(forms, self.boxes, strict=True)])
        """(m,) [m], of spheres about the boxes' centres that hold the solids."""

    def some(self, which: np.ndarray) -> Forms:
        """The solids `which` (k,); each may be there several times."""
        found = copy(self)
        found.inverse, found.centre = self.inverse[which], self.centre[which]
        found.kinds, found.sizes = self.kinds[which], self.sizes[which]
        return found

    def seen_from(self, origin: np.ndarray, poses: np.ndarray | None = None) -> PlacedForms:
        """The solids from an origin, (3,) or one for each (m, 3) float64 [m]; poses: (m, 4, 4), move each of them."""
        inverse, centre = self.inverse, self.centre
        if poses is not None:
            inverse = inverse @ np.swapaxes(poses[:, :3, :3], 1, 2)
            centre = (poses[:, :3, :3] @ centre[:, :, None])[:, :, 0] + poses[:, :3, 3]
        start = -(inverse @ (centre - origin)[:, :, None])[:, :, 0]
        return PlacedForms(start, inverse, self.kinds, self.sizes)


class PlacedForms:
    """The solids of a `Forms` as seen from one origin: the origin in each solid's frame, and the way into the frame."""

    def __init__(self, start: np.ndarray, inverse: np.ndarray, kinds: np.ndarray, sizes: np.ndarray) -> None:
        self._solids = start, inverse, kinds, sizes

    def meet(self, index: np.ndarray, owner: np.ndarray, table: np.ndarray, offsets: np.ndarray | None) -> np.ndarray:
        """(k,) float64 [lengths of the rays' directions]: where rays meet the solids tried for them; inf: not at all.

        index, owner: (k,) the ray and the solid of each pair. table: (n, 6) float32, its columns 3 to 5 the directions
        of all rays; offsets: (n, 3) float32 [m] of their origins from the solids' one. A ray that leaves a solid within
        `SKIN` of its origin started on its surface, and does not meet it there.
        """
        found = np.full(len(index), np.inf)
        _lengths(index, owner, table, COMMON if offsets is None else offsets, *self._solids, SKIN, found)
        return found

    def normals(
        self, index: np.ndarray, owner: np.ndarray, table: np.ndarray, offsets: np.ndarray | None, length: np.ndarray
    ) -> np.ndarray:
        """(k, 3) float32 unit normals, outwards, world axes, at the `length`s found by `meet`; 0 for infinite ones."""
        found = np.zeros((len(index), 3), np.float32)
        _normals(index, owner, table, COMMON if offsets is None else offsets, *self._solids, length, found)
        return found


@inlined
def _into_frame(
    ray: int, solid: int, table: np.ndarray, offsets: np.ndarray, starts: np.ndarray, inverse: np.ndarray
) -> tuple[Vector, Vector]:
    """A ray in a solid's frame: its origin and direction."""
    own = min(ray, len(offsets) - 1)
    x, y, z = times(inverse, solid, row_of(offsets, own))
    start = x + starts[solid, 0], y + starts[solid, 1], z + starts[solid, 2]
    return start, times(inverse, solid, (table[ray, 3], table[ray, 4], table[ray, 5]))


@inlined
def _within(a: float, b: float, c: float) -> tuple[float, float]:
    """From where to where a t^2 + 2 b t + c <= 0, for a > 0; from inf to -inf where it never is."""
    square = b * b - a * c
    if not square >= 0:
        return np.inf, -np.inf
    root = math.sqrt(square)
    return -(root + b) / a, (root - b) / a


@inlined
def _slab(start: float, ahead: float, half: float) -> tuple[float, float]:
    """From where to where |start + t ahead| <= half (Kay and Kajiya 1986)."""
    each = 1.0 / (ahead + 1e-300)  # a ray along a slab is never, or always, within it
    span, middle = abs(each) * half, -each * start
    return middle - span, middle + span


@inlined
def _ball(start: Vector, ahead: Vector) -> tuple[float, float]:
    (x, y, z), (u, v, w) = start, ahead
    return _within(u * u + v * v + w * w, x * u + y * v + z * w, x * x + y * y + z * z - 1.0)


@inlined
def _box(start: Vector, ahead: Vector) -> tuple[float, float]:
    enter, leave = -np.inf, np.inf
    for axis in range(3):
        first, last = _slab(start[axis], ahead[axis], 1.0)
        enter, leave = max(enter, first), min(leave, last)
    return enter, leave


@inlined
def _cylinder(start: Vector, ahead: Vector, high: float) -> tuple[float, float]:
    """x^2 + y^2 <= 1 from z = -high to high."""
    (x, y, z), (u, v, w) = start, ahead
    enter, leave = _within(u * u + v * v + 1e-300, x * u + y * v, x * x + y * y - 1.0)
    first, last = _slab(z, w, high)
    return max(enter, first), min(leave, last)


@inlined
def _frustum(start: Vector, ahead: Vector, low: float, high: float) -> tuple[float, float]:
    """The side x^2 + y^2 = (m + n z)^2 between the ends at z = -1 and 1, and the ends' discs."""
    (x, y, z), (u, v, w) = start, ahead
    m, n = (low + high) / 2, (high - low) / 2
    level = m + n * z
    a, c = u * u + v * v - (n * w) ** 2, x * x + y * y - level * level
    b = x * u + y * v - n * w * level
    q = -(b + math.copysign(math.sqrt(b * b - a * c), b))
    enter, leave = np.inf, -np.inf
    for t in (q / a, c / q):  # the roots of a t^2 + 2 b t + c, if they exist
        if abs(z + t * w) <= 1 + SEAM:
            enter, leave = min(enter, t), max(leave, t)
    for end, radius in ((-1.0, low), (1.0, high)):
        t = (end - z) / w
        if (x + t * u) ** 2 + (y + t * v) ** 2 <= radius * radius * (1 + SEAM):
            enter, leave = min(enter, t), max(leave, t)
    return enter, leave


@inlined
def _capsule(start: Vector, ahead: Vector, low: float, high: float) -> tuple[float, float]:
    """The union of a cylinder and a ball at each of its ends, which is convex."""
    x, y, z = start
    enter, leave = _cylinder(start, ahead, high)
    if not enter <= leave:
        enter, leave = np.inf, -np.inf
    for end in (low, high):
        first, last = _ball((x, y, z - end), ahead)
        enter, leave = min(enter, first), max(leave, last)
    return enter, leave


@compiled
def _lengths(
    index: np.ndarray,
    owner: np.ndarray,
    table: np.ndarray,
    offsets: np.ndarray,
    starts: np.ndarray,
    inverse: np.ndarray,
    kinds: np.ndarray,
    sizes: np.ndarray,
    skin: float,
    found: np.ndarray,
) -> None:
    """Writes the lengths that are finite; see `PlacedForms.meet`."""
    for pair in range(len(index)):
        solid = owner[pair]
        start, ahead = _into_frame(index[pair], solid, table, offsets, starts, inverse)
        kind, low, high = kinds[solid], sizes[solid, 0], sizes[solid, 1]
        if kind == BALL:
            enter, leave = _ball(start, ahead)
        elif kind == BOX:
            enter, leave = _box(start, ahead)
        elif kind == CYLINDER:
            enter, leave = _cylinder(start, ahead, 1.0)
        elif kind == FRUSTUM:
            enter, leave = _frustum(start, ahead, low, high)
        else:
            enter, leave = _capsule(start, ahead, low, high)
        if leave >= enter >= 0:
            found[pair] = enter
        elif leave >= enter and leave >= skin:
            found[pair] = leave


@inlined
def _box_normal(x: float, y: float, z: float) -> Vector:
    """Of the face that is nearest; of several at an edge."""
    most = max(abs(x), abs(y), abs(z))
    return (
        math.copysign(1.0, x) if abs(x) == most else 0.0,
        math.copysign(1.0, y) if abs(y) == most else 0.0,
        math.copysign(1.0, z) if abs(z) == most else 0.0,
    )


@inlined
def _frustum_normal(x: float, y: float, z: float, low: float, high: float) -> Vector:
    """Of the side or the end, whichever is nearer."""
    slope = (high - low) / 2
    radius, level = (low + high) / 2 + slope * z, math.hypot(x, y)
    if level == 0 or abs(1 - abs(z)) < abs(level - radius):
        return 0.0, 0.0, math.copysign(1.0, z)
    return x, y, -slope * level


@compiled
def _normals(
    index: np.ndarray,
    owner: np.ndarray,
    table: np.ndarray,
    offsets: np.ndarray,
    starts: np.ndarray,
    inverse: np.ndarray,
    kinds: np.ndarray,
    sizes: np.ndarray,
    lengths: np.ndarray,
    found: np.ndarray,
) -> None:
    """Writes the normals that are not 0; see `PlacedForms.normals`."""
    for pair in range(len(index)):
        solid, t = owner[pair], lengths[pair]
        if not t < np.inf:
            continue
        kind, low, high = kinds[solid], sizes[solid, 0], sizes[solid, 1]
        (x, y, z), (u, v, w) = _into_frame(index[pair], solid, table, offsets, starts, inverse)
        x, y, z = u * t + x, v * t + y, w * t + z
        if kind == BOX:
            x, y, z = _box_normal(x, y, z)
        elif kind == CYLINDER:
            x, y, z = _frustum_normal(x, y, z, 1.0, 1.0)
        elif kind == FRUSTUM:
            x, y, z = _frustum_normal(x, y, z, low, high)
        elif kind == CAPSULE:
            z -= min(max(z, low), high)
        x, y, z = transposed_times(inverse, solid, (x, y, z))  # of the inverse: normals along world axes
        away = math.sqrt(x * x + y * y + z * z)
        found[pair, 0], found[pair, 1], found[pair, 2] = x / away, y / away, z / away


def _kind(form: ClosedForm) -> int:
    """The number of a form's kind; a cylinder is a frustum of one radius."""
    return CYLINDER if form.kind == "frustum" and form.low == form.high else _KINDS[form.kind]


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
