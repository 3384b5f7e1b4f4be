"""Subdivision surfaces (Catmull-Clark, Loop, bilinear) as fine meshes whose vertices lie on the limit surface.

Limit masks: Halstead, Kass, DeRose, "Efficient, fair interpolation using Catmull-Clark surfaces" (1993) for
Catmull-Clark, Loop, "Smooth subdivision surfaces based on triangles" (1987) for Loop, cubic B-splines along creases.

Creases and corners have a sharpness that falls by one a level (10 never falls). In the level in which it ends, the
sharp and the smooth rule are blended by the remaining fraction, as OpenSubdiv does. Boundary and non-manifold edges
stay sharp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

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


SCHEMES = ("catmullClark", "loop", "bilinear")
MOST_LEVELS = 8
MOST_FACES = 2_000_000
"""Refinement stops before a mesh has more faces."""

_SMOOTH_TRIANGLE = 0.47
"""Weight of a triangle's middle in an edge point under `triangleSubdivisionRule` smooth; 1/4 otherwise (OpenSubdiv)."""


def refine(
    cage: Cage,
    scheme: str,
    tolerance: float,
    *,
    levels: int | None = None,
    boundary: str = "edgeAndCorner",
    smooth_triangles: bool = False,
    complain: Callable[[str], None] = lambda message: None,
) -> Cage:
    """The mesh after enough levels to be within `tolerance` of the limit surface, or after `levels`.

    tolerance: in the points' units. Every point lies on the limit surface. A level divides the distance by four (by
    three around extraordinary points), so the change from one level to the next bounds the remaining error. boundary:
    `interpolateBoundary`; with "none" the faces at the boundary are left out. Reported to `complain`: faces of a Loop
    mesh that are not triangles (the cage is returned), and a tolerance that `MOST_LEVELS` or `MOST_FACES` do not reach.
    """
    if scheme == "loop" and (cage.counts != 3).any():
        complain("a Loop subdivision surface has triangles only; its faces are used as they are")
        return cage
    if levels == 0 or not len(cage.counts):
        return cage
    level = Level.of(cage, boundary)
    shown = level.away_from_boundary() if boundary == "none" else None
    step = _LoopStep() if scheme == "loop" else _QuadStep(scheme == "bilinear", smooth_triangles)
    least = max(1, cage.sharp.levels) if levels is None else levels
    level, done = step.refined(level), 1
    at = step.limit(level)
    while done < (MOST_LEVELS if levels is None else levels):
        if len(level.cage.counts) * 4 > MOST_FACES:
            complain(f"mesh.tolerance would need more than {MOST_FACES} faces; it is refined {done} times")
            break
        finer = step.refined(level)
        there = step.limit(finer)
        change = step.change(level, at, there)
        if levels is None and done >= least and 1.5 * change <= tolerance:
            break
        level, at, done = finer, there, done + 1
        if levels is None and done >= least and change / 2 <= tolerance:
            break
    else:
        if levels is None:
            complain(f"mesh.tolerance would need more than {done} levels of refinement; it has {done}")
    fine = replace(level.cage, points=at)
    return fine if shown is None else _only(fine, np.isin(fine.source, cage.source[shown]))


def _only(cage: Cage, keep: NDArray[np.bool_]) -> Cage:
    corners = cage.corners[np.repeat(keep, cage.counts)]
    return replace(cage, counts=cage.counts[keep], corners=corners, source=cage.source[keep])


class _QuadStep:
    """Catmull-Clark or, with plain averages, bilinear: every face becomes one quad for each corner."""

    def __init__(self, bilinear: bool, smooth_triangles: bool) -> None:
        self._bilinear, self._smooth_triangles = bilinear, smooth_triangles

    def refined(self, level: Level) -> Level:
        cage, size, edges = level.cage, len(level.cage.points), len(level.edges)
        middles = summed(level.face, cage.points[cage.corners], len(cage.counts)) / cage.counts[:, None]
        if self._bilinear:
            points, on_edges = cage.points, cage.points[level.edges].mean(axis=1)
        else:
            points, on_edges = self._moved(level, middles), edge_points(level, self._smooth_edges(level, middles))
        quads = np.stack([cage.corners, size + level.out, size + edges + level.face, size + level.into], axis=1)
        count = len(quads)
        child = Cage(
            np.concatenate([points, on_edges, middles]),
            np.full(count, 4, np.int64),
            quads.ravel(),
            cage.source[level.face],
            level.child_sharp(),
        )
        return Level.of(child)

    def _moved(self, level: Level, middles: Floats) -> Floats:
        cage = level.cage
        neighbours, valence = level.around()
        faces = summed(cage.corners, middles[level.face], len(cage.points))
        n = np.maximum(valence, 1)[:, None]
        smooth = (n - 2) / n * cage.points + (neighbours + faces) / n**2
        return vertex_points(level, smooth)

    def _smooth_edges(self, level: Level, middles: Floats) -> Floats:
        ends = level.cage.points[level.edges].sum(axis=1)
        beside = summed(level.out, middles[level.face], len(level.edges))
        if not self._smooth_triangles or not (level.cage.counts == 3).any():
            return np.asarray((ends + beside) / 4)
        weights = np.where(level.cage.counts == 3, _SMOOTH_TRIANGLE, 0.25)[level.face]
        weight = (np.bincount(level.out, weights=weights, minlength=len(level.edges)) / 2)[:, None]
        return np.asarray(weight * beside + (1 - 2 * weight) / 2 * ends)

    def limit(self, level: Level) -> Floats:
        """The limit positions of the points of quads."""
        cage = level.cage
        if self._bilinear:
            return cage.points
        neighbours, valence = level.around()
        across = summed(
            cage.corners, cage.points[np.roll(cage.corners.reshape(-1, 4), 2, axis=1).ravel()], len(cage.points)
        )
        n = np.maximum(valence, 1)[:, None]
        smooth = (n * n * cage.points + 4 * neighbours + across) / (n * (n + 5))
        return by_rule(level, smooth, level.sharpness, level.point_sharpness, (4 / 6, 1 / 6))

    def change(self, level: Level, at: Floats, there: Floats) -> float:
        """Distance of the new points on edges and in faces from the flat faces before."""
        quads = level.cage.corners.reshape(-1, 4)
        a, b, c, d = (at[quads[:, corner]] for corner in range(4))
        normals = cross(c - a, d - b)
        in_faces = along(there[len(at) + len(level.edges) :] - (a + c) / 2, normals)
        return max(in_faces, edge_change(level, at, there, normals))


class _LoopStep:
    """Loop: every triangle becomes four."""

    def refined(self, level: Level) -> Level:
        cage, size = level.cage, len(level.cage.points)
        triangles = cage.corners.reshape(-1, 3)
        opposite = np.roll(triangles, 1, axis=1).ravel()
        across = summed(level.out, cage.points[opposite], len(level.edges))
        smooth_edges = 3 / 8 * cage.points[level.edges].sum(axis=1) + across / 8
        neighbours, valence = level.around()
        beta = _loop_beta(valence)[:, None]
        smooth = (1 - beta * valence[:, None]) * cage.points + beta * neighbours
        middle = size + level.out.reshape(-1, 3)
        into = size + level.into.reshape(-1, 3)
        outer = np.stack([triangles, middle, into], axis=2)  # (f, corner, 3)
        four = np.concatenate([outer, middle[:, None, :]], axis=1).reshape(-1, 3)
        child = Cage(
            np.concatenate([vertex_points(level, smooth), edge_points(level, smooth_edges)]),
            np.full(len(four), 3, np.int64),
            four.ravel(),
            np.repeat(cage.source, 4),
            level.child_sharp(),
        )
        return Level.of(child)

    def limit(self, level: Level) -> Floats:
        neighbours, valence = level.around()
        weight = (1 / (valence + 3 / (8 * _loop_beta(valence))))[:, None]
        smooth = (1 - weight * valence[:, None]) * level.cage.points + weight * neighbours
        return by_rule(level, smooth, level.sharpness, level.point_sharpness, (4 / 6, 1 / 6))

    def change(self, level: Level, at: Floats, there: Floats) -> float:
        """Distance of the new points on edges from the flat triangles before."""
        a, b, c = (at[level.cage.corners.reshape(-1, 3)[:, corner]] for corner in range(3))
        return edge_change(level, at, there, cross(b - a, c - a))


def _loop_beta(valence: Floats) -> Floats:
    n = np.maximum(valence, 1)
    return np.asarray((5 / 8 - (3 / 8 + np.cos(2 * math.pi / n) / 4) ** 2) / n)
