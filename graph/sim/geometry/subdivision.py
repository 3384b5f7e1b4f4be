"""Subdivision surfaces (Catmull-Clark, Loop, bilinear) as fine meshes whose vertices lie on the limit surface.

Limit masks: Halstead, Kass, DeRose, "Efficient, fair interpolation using Catmull-Clark surfaces" (1993) for
Catmull-Clark, Loop, "Smooth subdivision surfaces based on triangles" (1987) for Loop, cubic B-splines along creases.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats

from .subdivision_levels import (
    Cage,
    Level,
    Sharp,
    along,
    by_rule,
    cross,
    edge_change,
    edge_points,
    summed,
    vertex_points,
)

__all__ = ["SCHEMES", "Cage", "Sharp", "refine"]

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
