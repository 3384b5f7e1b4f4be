"""One level of a subdivision surface: its faces, edges and sharpness, and the rules near sharp edges and points.

Creases and corners have a sharpness that falls by one a level (10 never falls). In the level in which it ends, the
sharp and the smooth rule are blended by the remaining fraction, as OpenSubdiv does. Boundary and non-manifold edges
stay sharp.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass, field
from graph.sim.transforms import Floats

Integers = NDArray[np.int64]

SHARPEST = 10.0
"""A sharpness from here on does not fall (UsdGeom.Mesh.SHARPNESS_INFINITE)."""


@dataclass(frozen=True)
class Sharp:
    """Edges (k, 2) and vertices that are sharp, with how sharp each is (greater than 0)."""

    edges: Integers = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    edge_sharpness: Floats = field(default_factory=lambda: np.zeros(0))
    vertices: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    vertex_sharpness: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def levels(self) -> int:
        """The number of levels after which all remaining sharpness is permanent."""
        both = np.concatenate([self.edge_sharpness, self.vertex_sharpness])
        return math.ceil(float(both[both < SHARPEST].max(initial=0.0)))


@dataclass(frozen=True)
class Cage:
    """Polygons: corners per face, the points of all faces in order, and each face's number in the source."""

    points: Floats
    counts: Integers
    corners: Integers
    source: Integers
    sharp: Sharp = field(default_factory=Sharp)


@dataclass(frozen=True)
class Level:
    """A cage with its edges: for each corner, its face, the edge to the next corner and the edge from the last one."""

    cage: Cage
    face: Integers
    out: Integers
    into: Integers
    edges: Integers
    faces_at: Integers
    """Faces on each edge."""
    sharpness: Floats
    """Of each edge; at least `SHARPEST` if it does not have two faces."""
    point_sharpness: Floats

    @classmethod
    def of(cls, cage: Cage, boundary: str | None = None) -> Level:
        """boundary: on the first level, which single corners are sharp."""
        corners, counts, size = cage.corners, cage.counts, len(cage.points)
        starts = np.cumsum(counts) - counts
        place = np.arange(len(corners))
        following = place + 1
        following[starts + counts - 1] = starts
        a, b = corners, corners[following]
        keys, edge, faces_at = np.unique(
            np.minimum(a, b) * size + np.maximum(a, b), return_inverse=True, return_counts=True
        )
        into = np.empty_like(edge)
        into[following] = edge
        sharpness = np.zeros(len(keys))
        sharp = cage.sharp
        if len(sharp.edges):
            wanted = sharp.edges.min(axis=1) * size + sharp.edges.max(axis=1)
            row = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
            known = keys[row] == wanted
            np.maximum.at(sharpness, row[known], sharp.edge_sharpness[known])
        sharpness[faces_at != 2] = SHARPEST
        point_sharpness = np.zeros(size)
        np.maximum.at(point_sharpness, sharp.vertices, sharp.vertex_sharpness)
        if boundary == "edgeAndCorner":
            point_sharpness[np.bincount(corners, minlength=size) == 1] = SHARPEST
        edges = np.stack([keys // size, keys % size], axis=1)
        face = np.repeat(np.arange(len(counts)), counts)
        return cls(cage, face, edge, into, edges, faces_at, sharpness, point_sharpness)

    def away_from_boundary(self) -> NDArray[np.bool_]:
        """Faces without a corner on an edge that has only one face."""
        rim = np.zeros(len(self.cage.points), bool)
        rim[self.edges[self.faces_at != 2]] = True
        touching = np.bincount(self.face, weights=rim[self.cage.corners], minlength=len(self.cage.counts))
        return np.asarray(touching == 0)

    def around(self, edges: NDArray[np.bool_] | None = None) -> tuple[Floats, Floats]:
        """For every point: the sum of its neighbours along (some of) its edges, and their number."""
        pairs = self.edges if edges is None else self.edges[edges]
        size = len(self.cage.points)
        total = summed(
            np.concatenate([pairs[:, 0], pairs[:, 1]]),
            self.cage.points[np.concatenate([pairs[:, 1], pairs[:, 0]])],
            size,
        )
        return total, np.bincount(pairs.ravel(), minlength=size).astype(np.float64)

    def softened(self) -> tuple[Floats, Floats]:
        """The sharpness of edges and points on the next level."""
        return _softened(self.sharpness), _softened(self.point_sharpness)

    def child_sharp(self) -> Sharp:
        """The edges and points that are sharp on the next level; the point of edge e has the number of points + e."""
        edge, point = self.softened()
        mine = np.flatnonzero((edge > 0) & (self.faces_at == 2))
        halves = np.concatenate([self.edges[mine, 0], self.edges[mine, 1]])
        middles = np.tile(len(self.cage.points) + mine, 2)
        still = np.flatnonzero(point > 0)
        return Sharp(np.stack([halves, middles], axis=1), np.tile(edge[mine], 2), still, point[still])


def _softened(sharpness: Floats) -> Floats:
    return np.where(sharpness >= SHARPEST, sharpness, np.maximum(sharpness - 1, 0))


def summed(index: Integers, values: Floats, size: int) -> Floats:
    """The sums (size, 3) of the rows of `values` with the same index."""
    out = np.empty((size, 3))
    for axis in range(3):
        out[:, axis] = np.bincount(index, weights=values[:, axis], minlength=size)
    return out


def vertex_points(level: Level, smooth: Floats) -> Floats:
    """The positions of points on the next level; smooth: their positions by the smooth rule."""
    edge, point = level.softened()
    before = by_rule(level, smooth, level.sharpness, level.point_sharpness)
    after = by_rule(level, smooth, edge, point)
    # Sharpness that ends in this level: its mean is the weight of the sharp rule.
    ending = np.flatnonzero((level.sharpness > 0) & (edge <= 0))
    size = len(smooth)
    ends = level.edges[ending].ravel()
    total = np.bincount(ends, weights=np.repeat(level.sharpness[ending], 2), minlength=size).astype(np.float64)
    number = np.bincount(ends, minlength=size).astype(np.float64)
    own = (level.point_sharpness > 0) & (point <= 0)
    total[own] += level.point_sharpness[own]
    number[own] += 1
    share = np.minimum(total / np.maximum(number, 1), 1.0)[:, None]
    return np.asarray(share * before + (1 - share) * after)


def by_rule(
    level: Level, smooth: Floats, edge: Floats, point: Floats, crease: tuple[float, float] = (0.75, 0.125)
) -> Floats:
    """Points by the rule for these sharpnesses: smooth (darts too), crease (own weight, others') or corner."""
    sharp = edge > 0
    if not sharp.any() and not (point > 0).any():
        return smooth
    neighbours, number = level.around(sharp)
    out = smooth.copy()
    points = level.cage.points
    creased = (number == 2) & (point <= 0)
    out[creased] = crease[0] * points[creased] + crease[1] * neighbours[creased]
    corner = (number > 2) | (point > 0)
    out[corner] = points[corner]
    return out


def edge_points(level: Level, smooth: Floats) -> Floats:
    """Edge points between the smooth rule (sharpness 0) and the middle of the edge (1 and more)."""
    middle = level.cage.points[level.edges].mean(axis=1)
    share = np.minimum(level.sharpness, 1.0)[:, None]
    return np.asarray(share * middle + (1 - share) * smooth)


def edge_change(level: Level, at: Floats, there: Floats, normals: Floats) -> float:
    """Distance from the surface; for a sharp edge, from the edge, which may be an outline."""
    first, second = at[level.edges[:, 0]], at[level.edges[:, 1]]
    moved = there[len(at) : len(at) + len(level.edges)] - (first + second) / 2
    sharp = level.sharpness > 0
    beside = summed(level.out, normals[level.face], len(level.edges))
    off_surface = along(moved[~sharp], beside[~sharp])
    if not sharp.any():
        return off_surface
    edge = (second - first)[sharp]
    length = np.maximum((edge**2).sum(axis=1, keepdims=True), 1e-300)
    aside = moved[sharp] - edge * ((moved[sharp] * edge).sum(axis=1, keepdims=True) / length)
    return max(off_surface, math.sqrt(float((aside**2).sum(axis=1).max(initial=0.0))))


def along(vectors: Floats, normals: Floats) -> float:
    """The longest part of a vector along its normal, which need not be of unit length."""
    length = np.sqrt((normals**2).sum(axis=1))
    parts = np.abs((vectors * normals).sum(axis=1)) / np.maximum(length, 1e-300)
    return float(parts.max(initial=0.0))


def cross(a: Floats, b: Floats) -> Floats:
    """Cross products of rows."""
    out = np.empty_like(a)
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        out[:, axis] = a[:, u] * b[:, v] - a[:, v] * b[:, u]
    return out
