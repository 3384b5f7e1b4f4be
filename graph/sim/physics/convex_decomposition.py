"""Meshes as convex pieces: their convex connected parts, and of concave parts flat faces with some depth behind them.

Triangles in one plane are joined to convex polygons if possible. Each polygon is extruded backwards into the solid,
half as deep as the solid is there (found by a ray), so that a body pushed into it is pushed out again through the same
face. So the colliding surface is the true one, with its hollows and holes. The pieces of meshes too large for rays are
thin, with the depth SHEET of open surfaces.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.geometry.tessellation import Triangles
from graph.sim.transforms import Floats

from .world_model import Volume

MOST_PIECES = 20_000
"""At most this many pieces are made: a model of more takes seconds to compile."""

DEPTH = 0.25
"""Depth of a piece, as a fraction of the mesh's size, if the solid is deeper."""

SHEET = 0.01
"""Depth of an open surface, which has no inside, as a fraction of the mesh's size."""

MOST_TRIANGLES = 100_000
"""Larger meshes are not decomposed."""

_FLAT = 1e-5
_SLIVER = 1e-7
_RAYS, _MOST_RAYS = 300_000, 30_000_000


def surface_pieces(vertices: Floats, triangles: NDArray[np.integer[Any]]) -> list[Floats] | None:
    """The points of convex pieces that form a surface; None if more than `MOST_PIECES` are needed."""
    if len(triangles) > MOST_TRIANGLES:
        return None
    points, number = np.unique(vertices, axis=0, return_inverse=True)
    faces = number.reshape(-1)[triangles.astype(np.int64)]
    normals = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    lengths = np.linalg.norm(normals, axis=1)
    extent = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    longest = np.max([np.linalg.norm(points[faces[:, i]] - points[faces[:, i - 1]], axis=1) for i in range(3)], axis=0)
    solid = lengths > _SLIVER * extent * longest
    faces, normals = faces[solid], normals[solid] / lengths[solid, None]
    polygons = _polygons(points, faces, normals, extent)
    if len(polygons) > MOST_PIECES:
        return None
    if not polygons:
        return []
    most = (DEPTH if _closed(faces) else SHEET) * extent
    if len(polygons) * len(faces) <= _MOST_RAYS:
        depths = np.clip(_room(points, faces, polygons, extent) / 2, 1e-4 * extent, most)
    else:
        depths = np.full(len(polygons), SHEET * SHEET * extent)
    return [
        np.concatenate([points[corners], points[corners] - normal * depth])
        for (corners, normal), depth in zip(polygons, depths, strict=True)
    ]


Polygon = tuple[NDArray[np.int64], Floats]
"""Corners by number, counterclockwise about the normal, and the normal."""


def _polygons(points: Floats, faces: NDArray[np.int64], normals: Floats, extent: float) -> list[Polygon]:
    """Triangles joined across shared edges to convex polygons, as far as possible."""
    loops: list[list[int] | None] = [[int(corner) for corner in face] for face in faces]
    owner = list(range(len(loops)))
    inner = _flat_edges(points, faces, normals, extent)
    while inner:
        left = []
        for first, second, a, b in inner:
            one, other = _find(owner, first), _find(owner, second)
            if one == other:
                continue
            joined = _joined(points, loops[one], loops[other], (a, b), normals[first], extent)
            if joined is None:
                left.append((first, second, a, b))
                continue
            loops[one], loops[other], owner[other] = joined, None, one
        if len(left) == len(inner):
            break
        inner = left
    return [(np.array(loop), normals[number]) for number, loop in enumerate(loops) if loop is not None]


def _find(owner: list[int], number: int) -> int:
    while owner[number] != number:
        owner[number] = owner[owner[number]]
        number = owner[number]
    return number


def _flat_edges(
    points: Floats, faces: NDArray[np.int64], normals: Floats, extent: float
) -> list[tuple[int, int, int, int]]:
    """(face, face, corner, corner) of edges between two faces in one plane, in the direction of the first face."""
    edges = np.concatenate([faces[:, (0, 1)], faces[:, (1, 2)], faces[:, (2, 0)]])
    opposite = np.concatenate([faces[:, 2], faces[:, 0], faces[:, 1]])
    face = np.tile(np.arange(len(faces)), 3)
    key = np.sort(edges, axis=1)
    order = np.lexsort((key[:, 1], key[:, 0]))
    same = (np.diff(key[order], axis=0) == 0).all(axis=1)
    first, second = order[:-1][same], order[1:][same]
    against = (edges[first] == edges[second][:, ::-1]).all(axis=1)
    height = np.einsum("ij,ij->i", normals[face[first]], points[opposite[second]] - points[edges[first, 0]])
    along = np.einsum("ij,ij->i", normals[face[first]], normals[face[second]])
    flat = against & (np.abs(height) <= _FLAT * extent) & (along > 0)
    columns = (face[first], face[second], edges[first, 0], edges[first, 1])
    return list(zip(*(column[flat].tolist() for column in columns), strict=True))


def _joined(
    points: Floats, one: list[int] | None, other: list[int] | None, edge: tuple[int, int], normal: Floats, extent: float
) -> list[int] | None:
    """Two polygons joined along an edge, without collinear corners; None if the result is not convex."""
    if one is None or other is None or edge[0] not in one or edge[1] not in one:
        return None
    i = one.index(edge[0])
    if one[(i + 1) % len(one)] != edge[1] or edge[0] not in other or edge[1] not in other:
        return None
    j = other.index(edge[1])
    if other[(j + 1) % len(other)] != edge[0]:
        return None
    ring = one[i + 1 :] + one[: i + 1]  # from the edge's end round to its start
    ring += [other[(j + 1 + k) % len(other)] for k in range(1, len(other) - 1)]
    corners = points[ring]
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    turning = np.cross(before, after) @ normal
    scale = _FLAT * extent * np.maximum(np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1))
    if (turning < -scale).any() or len(set(ring)) < len(ring):
        return None
    return [corner for corner, turn, least in zip(ring, turning, scale, strict=True) if turn > least] or None


def outward(points: Floats, faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """The faces of a closed mesh with normals pointing out; those of an open mesh unchanged."""
    if not len(faces) or not _closed(faces):
        return faces
    corners = points[faces] - points[faces[0, 0]]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    return faces[:, ::-1] if volume < 0 else faces


def _closed(faces: NDArray[np.int64]) -> bool:
    """Whether every edge is used once in each direction, so that the mesh has an inside."""
    edges = np.concatenate([faces[:, (0, 1)], faces[:, (1, 2)], faces[:, (2, 0)]])
    most = int(faces.max()) + 1
    forward, backward = np.sort(edges[:, 0] * most + edges[:, 1]), np.sort(edges[:, 1] * most + edges[:, 0])
    return bool(np.array_equal(forward, backward))


def _room(points: Floats, faces: NDArray[np.int64], polygons: list[Polygon], extent: float) -> Floats:
    """The distance from the middle of each polygon backwards to the next triangle [m]."""
    starts = np.array([points[corners].mean(axis=0) for corners, _ in polygons])
    ways = -np.array([normal for _, normal in polygons])
    a = points[faces[:, 0]]
    u, v = points[faces[:, 1]] - a, points[faces[:, 2]] - a
    nearest = np.full(len(polygons), np.inf)
    rows = max(_RAYS // max(len(faces), 1), 1)
    for low in range(0, len(polygons), rows):
        start, way = starts[low : low + rows, None], ways[low : low + rows, None]
        nearest[low : low + rows] = _first_hits(start, way, a, u, v, extent)
    return nearest


def _first_hits(start: Floats, way: Floats, a: Floats, u: Floats, v: Floats, extent: float) -> Floats:
    """Distance of the nearest triangle for each ray (Möller and Trumbore, 1997)."""
    p = np.cross(way, v)
    det = np.einsum("rtj,tj->rt", p, u)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = start - a
        x = np.einsum("rtj,rtj->rt", s, p) / det
        q = np.cross(s, u)
        y = np.einsum("rtj,rtj->rt", q, np.broadcast_to(way, q.shape)) / det
        t = np.einsum("rtj,tj->rt", q, v) / det
        hit = (np.abs(det) > 1e-300) & (x >= -1e-9) & (y >= -1e-9) & (x + y <= 1 + 1e-9) & (t > 1e-6 * extent)
    out: Floats = np.where(hit, t, np.inf).min(axis=1)
    return out


def enclosed(vertices: Floats, triangles: NDArray[np.integer[Any]]) -> Volume | None:
    """The volume that a closed mesh encloses, from the tetrahedra that its triangles make with a point; None for an
    open mesh.
    """
    points, number = np.unique(vertices, axis=0, return_inverse=True)
    faces = number.reshape(-1)[triangles.astype(np.int64)]
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    if not len(faces) or not _closed(faces):
        return None
    faces = outward(points, faces)
    middle = points.mean(axis=0)
    corners: Any = points[faces] - middle
    six = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volume = float(six.sum()) / 6
    if volume <= 0:
        return None
    center = (six[:, None] * corners.sum(axis=1)).sum(axis=0) / 24 / volume
    # of a tetrahedron with a corner at the origin: sum over its other corners and their sum, a a^T, times 6 V / 120
    total = corners.sum(axis=1)
    square = np.einsum("i,ikm,ikn->mn", six, corners, corners) + np.einsum("i,im,in->mn", six, total, total)
    second = square / 120 - volume * np.outer(center, center)
    return Volume(volume, middle + center, np.trace(second) * np.eye(3) - second)


FLAT = 1e-6
"""Points this close to one plane (as a fraction of their extent) are flat."""


def convex_pieces(vertices: Floats, triangles: Triangles) -> tuple[list[Floats], int]:
    """The points of convex pieces of a mesh, and how many of its concave parts are replaced by their hulls.

    A convex connected part is one piece, others are cut into their faces (see `convex_decomposition`). Vertices at
    equal positions are merged, so that flat-shaded meshes hold together. A flat part gets a little depth behind its
    faces, since a hull needs a volume.
    """
    points, number = np.unique(vertices, axis=0, return_inverse=True)
    corners = number.reshape(-1)[triangles.astype(np.int64)]
    labels = _components(corners, len(points))
    pieces: list[Floats] = []
    hulls = 0
    for label in np.unique(labels[corners[:, 0]]):
        faces = outward(points, corners[labels[corners[:, 0]] == label])
        if not _convex(points, faces):
            cut = surface_pieces(points, faces)
            if cut is not None and len(pieces) + len(cut) <= MOST_PIECES:
                pieces.extend(cut)
                continue
            hulls += 1
        pieces.append(with_depth(points[np.unique(faces)], points, faces))
    return pieces, hulls


def with_depth(part: Floats, points: Floats, faces: NDArray[np.integer[Any]]) -> Floats:
    """The part; if all its points lie in one plane, together with a copy of them 5 % of its size behind."""
    normals = _normals(points, faces)
    normal = normals.sum(axis=0)
    length = float(np.linalg.norm(normal))
    extent = float(np.ptp(part, axis=0).max())
    if length == 0 or extent == 0:
        return part
    normal /= length
    if np.ptp(part @ normal) > FLAT * extent:
        return part
    return np.concatenate([part, part - normal * extent * 0.05])


def _normals(points: Floats, faces: NDArray[np.integer[Any]]) -> Floats:
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def _components(corners: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """A label per vertex, equal within a connected part (labels spread along edges until nothing changes)."""
    labels = np.arange(count)
    edges = np.concatenate([corners[:, (0, 1)], corners[:, (1, 2)]])
    while True:
        low = np.minimum(labels[edges[:, 0]], labels[edges[:, 1]])
        spread = labels.copy()
        np.minimum.at(spread, edges[:, 0], low)
        np.minimum.at(spread, edges[:, 1], low)
        spread = spread[spread]
        if np.array_equal(spread, labels):
            return labels
        labels = spread


def _convex(points: Floats, faces: NDArray[np.int64]) -> bool:
    """Whether no two faces with a common edge form a concave angle (and no edge has more than two faces)."""
    normals = _normals(points, faces)
    lengths = np.linalg.norm(normals, axis=1)
    solid = lengths > 0
    if not solid.any():
        return True
    faces, normals = faces[solid], normals[solid] / lengths[solid, None]
    edges = np.concatenate([faces[:, (0, 1)], faces[:, (1, 2)], faces[:, (2, 0)]])
    opposite = np.concatenate([faces[:, 2], faces[:, 0], faces[:, 1]])
    owner = np.tile(np.arange(len(faces)), 3)
    key = np.sort(edges, axis=1)
    order = np.lexsort((key[:, 1], key[:, 0]))
    same = (np.diff(key[order], axis=0) == 0).all(axis=1)
    if (same[1:] & same[:-1]).any():
        return False
    first, second = order[:-1][same], order[1:][same]
    height = np.einsum("ij,ij->i", normals[owner[first]], points[opposite[second]] - points[edges[first, 0]])
    return bool((height <= 1e-5 * np.ptp(points[np.unique(faces)], axis=0).max()).all())
