"""Polygons to triangles: any number of corners, concave ones too; holes are left out, bad faces are reported."""

from __future__ import annotations

import numpy as np

from graph.sim.transforms import Floats

from .ears import clip_ears
from .polygons import Complain, Integers, Polygons, usable_faces
from .tessellation import Triangles

BLOCK = 32768
"""Polygons that are processed together: as many as fit into the caches."""


def triangulate(
    points: Floats,
    counts: Integers,
    indices: Integers,
    holes: Integers | None = None,
    flip: bool = False,
    complain: Complain = lambda message: None,
) -> tuple[Triangles, Integers]:
    """Triangles (m, 3) of the polygons, in face order, and the face that each comes from.

    counts, indices: corners per face and their points, face after face; holes: faces to leave out; flip: turn the
    winding. Faces with fewer than 3 corners, or with points that do not exist or are not finite, are left out; each
    kind is reported to `complain` once.
    """
    faces = usable_faces(points, counts, indices, complain)
    if holes is not None and len(holes):
        faces = faces.only(~np.isin(faces.source, holes))
    return triangles_of(points, faces, flip)


def triangles_of(points: Floats, faces: Polygons, flip: bool = False) -> tuple[Triangles, Integers]:
    """Triangles (m, 3) of usable faces, in their order, and the face of the source that each comes from."""
    counts, corners = faces.counts, faces.corners
    if not len(counts):
        return np.zeros((0, 3), np.uint32), np.zeros(0, np.int64)
    smallest, largest = int(counts.min()), int(counts.max())
    if smallest == largest:
        triangles, owner = _split(points, corners.reshape(-1, largest))
    else:
        triangles, owner = _split_mixed(points, counts, corners)
    if flip:
        triangles = triangles[:, ::-1]
    return np.ascontiguousarray(triangles, dtype=np.uint32), faces.source[owner]


def _split_mixed(points: Floats, counts: Integers, corners: Integers) -> tuple[Integers, Integers]:
    """Triangles of faces of different sizes, and which face each belongs to."""
    starts = np.cumsum(counts) - counts
    first = np.cumsum(counts - 2) - (counts - 2)
    triangles = np.empty((int((counts - 2).sum()), 3), np.int64)
    for size in np.unique(counts):
        chosen = np.flatnonzero(counts == size)
        polygons = corners[starts[chosen][:, None] + np.arange(size)]
        places = first[chosen][:, None] + np.arange(size - 2)
        triangles[places.ravel()] = _split(points, polygons)[0]
    return triangles, np.repeat(np.arange(len(counts)), counts - 2)


def _split(points: Floats, polygons: Integers) -> tuple[Integers, Integers]:
    """Triangles of polygons with equally many corners, and which polygon each belongs to."""
    count, corners = polygons.shape
    owner = np.arange(count)
    if corners == 3:
        return polygons, owner
    inner = np.arange(1, corners - 1)
    fans = np.stack([np.zeros_like(inner), inner, inner + 1], axis=1)
    triangles = np.empty((count, corners - 2, 3), np.int64)
    for start in range(0, count, BLOCK):
        some = polygons[start : start + BLOCK]
        block = triangles[start : start + BLOCK]
        for place, corner in np.ndenumerate(fans):
            block[:, place[0], place[1]] = some[:, corner]
        turns = _turns(points, some)
        concave = np.flatnonzero((turns < 0).any(axis=0))
        if len(concave):
            block[concave] = _cut_at_hollow(some, turns, concave) if corners == 4 else _cut(points, some[concave])
    return triangles.reshape(-1, 3), np.repeat(owner, corners - 2)


def _cut_at_hollow(quads: Integers, turns: Floats, concave: Integers) -> Integers:
    """A quad has at most one concave corner, unless it crosses itself; the diagonal from that corner lies inside."""
    hollow = turns[:, concave].argmin(axis=0)
    turned = quads[concave[:, None], (hollow[:, None] + np.arange(4)) % 4]
    return np.asarray(turned[:, [[0, 1, 2], [0, 2, 3]]])


def _cut(points: Floats, polygons: Integers) -> Integers:
    """(f, n) concave polygons to (f, n - 2, 3)."""
    local = clip_ears(points[polygons])
    return np.take_along_axis(polygons, local.reshape(len(polygons), -1), axis=1).reshape(local.shape)


def _turns(points: Floats, polygons: Integers) -> Floats:
    """(n, f): the turn at each corner of (f, n) polygons about the face's normal; negative at a concave corner."""
    places = [np.ascontiguousarray(points[polygons[:, corner]].T) for corner in range(polygons.shape[1])]
    edges = [there - here for here, there in zip(places, places[1:] + places[:1], strict=True)]
    crosses = [_cross(before, after) for before, after in zip(edges[-1:] + edges[:-1], edges, strict=True)]
    normal, reach = np.zeros_like(places[0]), edges[0]
    for edge in edges[1:-1]:
        normal += _cross(reach, edge)
        reach = reach + edge
    turns = np.stack([(cross * normal).sum(axis=0) for cross in crosses])
    turns[np.abs(turns) <= 1e-12 * np.abs(turns).max(axis=0)] = 0
    return np.asarray(turns)


def _cross(a: Floats, b: Floats) -> Floats:
    """Cross product of (3, f) columns."""
    out = np.empty_like(a)
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        out[axis] = a[u] * b[v] - a[v] * b[u]
    return out
