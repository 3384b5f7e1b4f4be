"""Concave polygons to triangles by clipping ears, in the plane that each polygon lies in best."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats

Integers = NDArray[np.int64]


def clip_ears(corners: Floats) -> Integers:
    """(n, 3) corners of one polygon to (n - 2, 3) corner numbers.

    A corner is an ear if it bulges and no hollow corner lies in the triangle that it cuts off; only the two corners
    next to one that was cut can change that. Where a polygon crosses itself there may be none: then the next is cut.
    """
    flat = _flat(corners[None])[0]
    size = len(flat)
    before, after = np.roll(np.arange(size), 1), np.roll(np.arange(size), -1)
    hollow = _area(flat[before], flat, flat[after]) <= 0
    out = np.empty((size - 2, 3), np.int64)
    tip, waited = 0, 0
    for number in range(size - 3):
        left = size - number
        while waited < left and not _is_ear(flat, hollow, before[tip], tip, after[tip]):
            tip, waited = int(after[tip]), waited + 1
        waited = 0
        a, b = int(before[tip]), int(after[tip])
        out[number] = a, tip, b
        after[a], before[b] = b, a
        hollow[tip] = False  # it is gone, and blocks nothing any more
        for end in (a, b):
            hollow[end] = _area(flat[before[end]], flat[end], flat[after[end]]) <= 0
        tip = b
    out[-1] = before[tip], tip, after[tip]
    return out


def _is_ear(flat: Floats, hollow: NDArray[np.bool_], a: int, tip: int, b: int) -> bool:
    if hollow[tip]:
        return False
    corners = flat[[a, tip, b]]
    others = flat[hollow]
    return not _inside(corners[0], corners[1], corners[2], others).any()


def clip_ears_of_many(corners: Floats) -> Integers:
    """(f, n, 3) corners of polygons to (f, n - 2, 3) corner numbers: one ear of each polygon at a time."""
    flat = _flat(corners)
    count, size = flat.shape[:2]
    left = np.broadcast_to(np.arange(size), (count, size)).copy()
    rows = np.arange(count)
    out = np.empty((count, size - 2, 3), np.int64)
    for number in range(size - 3):
        at = np.take_along_axis(flat, left[..., None], axis=1)
        a, b = np.roll(at, 1, axis=1), np.roll(at, -1, axis=1)
        bulges = _area(a, at, b) > 0
        blocked = _inside(a[:, :, None], at[:, :, None], b[:, :, None], at[:, None, :]) & ~bulges[:, None, :]
        ear = np.argmax(bulges & ~blocked.any(axis=2), axis=1)
        remaining = size - number
        out[:, number, 0] = left[rows, (ear - 1) % remaining]
        out[:, number, 1] = left[rows, ear]
        out[:, number, 2] = left[rows, (ear + 1) % remaining]
        keep = np.ones(left.shape, bool)
        keep[rows, ear] = False
        left = left[keep].reshape(count, remaining - 1)
    out[:, -1] = left
    return out


def _inside(a: Floats, tip: Floats, b: Floats, points: Floats) -> NDArray[np.bool_]:
    """Whether points lie in a triangle or on its rim; not those that are where one of its corners is."""
    within = (_area(a, tip, points) >= 0) & (_area(tip, b, points) >= 0) & (_area(b, a, points) >= 0)
    for corner in (a, tip, b):
        within &= (points != corner).any(axis=-1)
    return np.asarray(within)


def _flat(corners: Floats) -> Floats:
    """(f, n, 3) to (f, n, 2): without the axis nearest to the normal, counter-clockwise."""
    relative = corners - corners[:, :1]
    normal = np.cross(relative, np.roll(relative, -1, axis=1)).sum(axis=1)
    drop = np.argmax(np.abs(normal), axis=1)
    u, v = (drop + 1) % 3, (drop + 2) % 3
    picked = np.stack([u, v], axis=1)[:, None, :]
    flat = np.take_along_axis(relative, np.broadcast_to(picked, (*relative.shape[:2], 2)), axis=2)
    flat[..., 1] *= np.where(np.take_along_axis(normal, drop[:, None], axis=1) > 0, 1.0, -1.0)
    return np.asarray(flat)


def _area(a: Floats, b: Floats, c: Floats) -> Floats:
    """Twice the signed area of triangles."""
    return np.asarray(
        (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    )
