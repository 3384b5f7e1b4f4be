"""Meshes as convex pieces: connected parts, and whether each is convex."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.geometry.tessellation import Triangles
from graph.sim.transforms import Floats

from .convex_decomposition import MOST_PIECES, outward, surface_pieces

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
