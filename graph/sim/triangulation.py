"""Polygons to triangles: any number of corners, concave ones too, holes left out, bad faces named."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .tessellation import Triangles
from .transforms import Floats

Integers = NDArray[np.int64]


def triangulate(
    points: Floats,
    counts: Integers,
    indices: Integers,
    holes: Integers | None = None,
    flip: bool = False,
    complain: Callable[[str], None] = lambda message: None,
) -> tuple[Triangles, Integers]:
    """Triangles (m, 3) of the polygons, in face order, and the face that each comes from.

    counts, indices: corners per face and their points, face after face; holes: faces to leave out; flip: turn the
    winding. Faces with fewer than 3 corners, with points that do not exist or are not finite are left out, each kind
    told to `complain` once.
    """
    counts = counts.astype(np.int64, copy=False)
    indices = indices.astype(np.int64, copy=False)
    counts, total = _fitting(counts, len(indices), complain)
    indices = indices[:total]
    starts = np.cumsum(counts) - counts
    usable = counts >= 3
    if not usable.all():
        complain(f"{int((~usable).sum())} faces have fewer than 3 corners; they are left out.")
    usable &= ~_faces_with(
        indices, counts, (indices < 0) | (indices >= len(points)), "points that do not exist", complain
    )
    inside = np.clip(indices, 0, max(len(points) - 1, 0))
    if len(points):
        strange = np.asarray(~np.isfinite(points).all(axis=1))
        if strange.any():
            usable &= ~_faces_with(indices, counts, strange[inside], "points that are not finite", complain)
    if holes is not None and len(holes):
        usable[holes[(holes >= 0) & (holes < len(counts))]] = False
    parts, faces = [], []
    for corners in np.unique(counts[usable]):
        chosen = np.flatnonzero(usable & (counts == corners))
        polygons = indices[starts[chosen][:, None] + np.arange(corners)]
        triangles, owner = _split(points, polygons)
        parts.append(triangles)
        faces.append(chosen[owner])
    if not parts:
        return np.zeros((0, 3), np.uint32), np.zeros(0, np.int64)
    triangles, face = np.concatenate(parts), np.concatenate(faces)
    if len(parts) > 1:
        order = np.argsort(face, kind="stable")
        triangles, face = triangles[order], face[order]
    if flip:
        triangles = triangles[:, ::-1]
    return np.ascontiguousarray(triangles, dtype=np.uint32), face


def _fitting(counts: Integers, available: int, complain: Callable[[str], None]) -> tuple[Integers, int]:
    if (counts < 0).any():
        complain("faceVertexCounts holds negative numbers; those faces are left out.")
        counts = np.maximum(counts, 0)
    ends = np.cumsum(counts)
    total = int(ends[-1]) if len(ends) else 0
    if total > available:
        fit = int(np.searchsorted(ends, available, side="right"))
        complain(
            f"faceVertexCounts asks for {total} indices, there are {available}; {len(counts) - fit} faces are left out."
        )
        counts = counts[:fit]
        total = int(ends[fit - 1]) if fit else 0
    return counts, total


def _faces_with(
    indices: Integers, counts: Integers, bad: NDArray[np.bool_], what: str, complain: Callable[[str], None]
) -> NDArray[np.bool_]:
    out = np.zeros(len(counts), bool)
    if bad.any():
        out[np.repeat(np.arange(len(counts)), counts)[bad]] = True
        complain(f"{int(out.sum())} faces have {what}; they are left out.")
    return out


def _split(points: Floats, polygons: Integers) -> tuple[Integers, Integers]:
    """Triangles of polygons with equally many corners, and which polygon each belongs to."""
    count, corners = polygons.shape
    owner = np.arange(count)
    if corners == 3:
        return polygons, owner
    inner = np.arange(1, corners - 1)
    fans = np.stack([np.zeros_like(inner), inner, inner + 1], axis=1)
    triangles = polygons[:, fans]
    turns = _turns(points[polygons])
    concave = np.flatnonzero((turns < 0).any(axis=1))
    for face in concave:
        triangles[face] = polygons[face][_clip_ears(points[polygons[face]])]
    return triangles.reshape(-1, 3), np.repeat(owner, corners - 2)


def _turns(corners: Floats) -> Floats:
    """(f, n, 3) polygons to (f, n): at each corner, the turn along the face's normal; negative where it is concave."""
    edges = np.roll(corners, -1, axis=1) - corners
    before = np.roll(edges, 1, axis=1)
    cross = _cross(before, edges)
    relative = corners - corners[:, :1]
    normal = _cross(relative, np.roll(relative, -1, axis=1)).sum(axis=1)
    turns: Floats = np.einsum("fnk,fk->fn", cross, normal)
    turns[np.abs(turns) <= 1e-12 * np.abs(turns).max(axis=1, keepdims=True)] = 0
    return turns


def _cross(a: Floats, b: Floats) -> Floats:
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    out[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    out[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return out


def _clip_ears(corners: Floats) -> Integers:
    """(n, 3) corners of one concave polygon to (n - 2, 3) local corner numbers, by clipping ears in its own plane."""
    relative = corners - corners[0]
    normal = _cross(relative, np.roll(relative, -1, axis=0)).sum(axis=0)
    drop = int(np.argmax(np.abs(normal)))
    u, v = {0: (1, 2), 1: (2, 0), 2: (0, 1)}[drop]
    flat = relative[:, (u, v)] * (1.0, 1.0 if normal[drop] > 0 else -1.0)
    left = list(range(len(corners)))
    out = []
    while len(left) > 3:
        size = len(left)
        ear = next((i for i in range(size) if _is_ear(flat, left, i)), 0)
        out.append((left[ear - 1], left[ear], left[(ear + 1) % size]))
        del left[ear]
    out.append((left[0], left[1], left[2]))
    return np.array(out, dtype=np.int64)


def _is_ear(flat: Floats, left: list[int], i: int) -> bool:
    a, b, c = (flat[left[k % len(left)]] for k in (i - 1, i, i + 1))
    if _area(a, b, c) <= 0:
        return False
    others = flat[[k for k in left if k not in (left[i - 1], left[i], left[(i + 1) % len(left)])]]
    within = (_area(a, b, others) >= 0) & (_area(b, c, others) >= 0) & (_area(c, a, others) >= 0)
    return not within.any()


def _area(a: Floats, b: Floats, c: Floats) -> Floats:
    return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
