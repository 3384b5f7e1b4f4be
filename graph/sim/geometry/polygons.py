"""The faces of a mesh's arrays: which are valid, and their triangles, of any number of corners and concave ones too."""

from __future__ import annotations

from collections.abc import Callable

import mapbox_earcut
import numpy as np
from numpy.typing import NDArray

from graph.base.limits import allowed, most
from graph.base.records import dataclass
from graph.sim.transforms import Floats

from .tessellation import Triangles

Integers = NDArray[np.int64]
Complain = Callable[[str], None]


@dataclass(frozen=True)
class Polygons:
    """Corners per face (at least 3), the points of all faces in order, and each face's number in the source."""

    counts: Integers
    corners: Integers
    source: Integers

    def only(self, keep: NDArray[np.bool_]) -> Polygons:
        """Some of the faces."""
        if keep.all():
            return self
        corners = self.corners[np.repeat(keep, self.counts)]
        return Polygons(self.counts[keep], corners, self.source[keep])


def usable_faces(points: Floats, counts: Integers, indices: Integers, complain: Complain) -> Polygons:
    """The faces except those with fewer than 3 corners, or with points that do not exist or are not finite.

    Each kind is reported to `complain` once, with a count.
    """
    counts = counts.astype(np.int64, copy=False)
    indices = indices.astype(np.int64, copy=False)
    counts, total = _fitting(counts, len(indices), complain)
    indices = indices[:total]
    large = counts > most("mesh.corners")
    if large.any():
        complain(f"{int(large.sum())} faces have too many corners and are left out; {allowed('mesh.corners')}")
    usable = counts >= 3
    if not usable.all():
        complain(f"{int((~usable).sum())} faces have fewer than 3 corners; they are left out")
    usable &= ~large
    missing = np.asarray((indices < 0) | (indices >= len(points)))
    bad = [(missing, "points that do not exist")]
    strange = np.asarray(~np.isfinite(points).all(axis=1))
    if strange.any():
        bad.append((strange[np.clip(indices, 0, len(points) - 1)] & ~missing, "points that are not finite"))
    for corners, what in bad:
        if corners.any():
            faces = np.zeros(len(counts), bool)
            faces[np.repeat(np.arange(len(counts)), counts)[corners]] = True
            usable &= ~faces
            complain(f"{int(faces.sum())} faces have {what}; they are left out")
    return Polygons(counts, indices, np.arange(len(counts))).only(usable)


def _fitting(counts: Integers, available: int, complain: Complain) -> tuple[Integers, int]:
    if (counts < 0).any():
        complain("faceVertexCounts holds negative numbers; those faces are left out")
        counts = np.maximum(counts, 0)
    ends = np.cumsum(counts)
    total = int(ends[-1]) if len(ends) else 0
    if total > available:
        fit = int(np.searchsorted(ends, available, side="right"))
        complain(
            f"faceVertexCounts asks for {total} indices, there are {available}; {len(counts) - fit} faces are left out"
        )
        counts = counts[:fit]
        total = int(ends[fit - 1]) if fit else 0
    elif total < available:
        complain(f"faceVertexCounts asks for {total} indices, there are {available}; those left over are ignored")
    return counts, total


BLOCK = 32768
"""Polygons that are processed together: as many as fit into the caches."""


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


def clip_ears(corners: Floats) -> Integers:
    """(f, n, 3) corners of polygons to (f, n - 2, 3) corner numbers, with the winding of the polygon.

    Corners on a straight line get triangles too, so that neighbouring faces meet at every corner. If there are fewer
    than n - 2 triangles, as for a polygon that crosses itself or repeats a corner, (0, 0, 0) fills the rest.
    """
    flat = _flat(corners)
    count, size = flat.shape[:2]
    out = np.zeros((count, size - 2, 3), np.int64)
    ring = np.array([size], np.uint32)
    for polygon, triangles in zip(flat, out, strict=True):
        cut = mapbox_earcut.triangulate_float64(polygon, ring).reshape(-1, 3)
        triangles[: len(cut)] = cut
    return out


def _flat(corners: Floats) -> Floats:
    """(f, n, 3) to (f, n, 2): without the axis closest to the normal, counter-clockwise."""
    relative = corners - corners[:, :1]
    normal = np.cross(relative, np.roll(relative, -1, axis=1)).sum(axis=1)
    drop = np.argmax(np.abs(normal), axis=1)
    u, v = (drop + 1) % 3, (drop + 2) % 3
    picked = np.stack([u, v], axis=1)[:, None, :]
    flat = np.take_along_axis(relative, np.broadcast_to(picked, (*relative.shape[:2], 2)), axis=2)
    flat[..., 1] *= np.where(np.take_along_axis(normal, drop[:, None], axis=1) > 0, 1.0, -1.0)
    return np.ascontiguousarray(flat)
