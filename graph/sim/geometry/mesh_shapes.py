"""UsdGeom meshes and tetrahedral meshes as triangles: holes, orientation, subdivision."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.sim.arrays import array_of, number_of
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom

from .polygons import Complain, Integers, Polygons, usable_faces
from .subdivision import SCHEMES, Cage, Sharp, refine
from .tessellation import Triangles
from .triangulation import triangles_of

FromMesh = tuple[Floats, Triangles, Integers]
"""Vertices (n, 3), triangles (m, 3), and the face that each triangle comes from."""

REFINE_HERE, LEVELS = "refinementEnableOverride", "refinementLevel"
"""Attributes of Omniverse: whether a mesh sets its own refinement, and the number of levels."""

MOST_LEVELS_HERE = 6


def mesh_surface(prim: Any, tolerance: float, refined: bool, time: Any, complain: Complain) -> FromMesh | None:
    """A mesh's triangles; as a subdivision surface if the caller or the mesh requests it."""
    schema = UsdGeom.Mesh(prim)
    points = array_of(schema.GetPointsAttr(), np.float64, 3, time)
    counts = array_of(schema.GetFaceVertexCountsAttr(), np.int64, time=time)
    if not len(points) or not len(counts):
        complain("the mesh has no points or no faces; nothing can hit it")
        return None
    indices = array_of(schema.GetFaceVertexIndicesAttr(), np.int64, time=time)
    faces = usable_faces(points, counts, indices, complain)
    scheme = str(schema.GetSubdivisionSchemeAttr().Get(EARLIEST))
    levels = _levels_here(prim)
    if scheme in SCHEMES and (refined if levels is None else levels > 0) and len(faces.counts):
        points, faces = _subdivided(schema, points, faces, scheme, tolerance, levels, time, complain)
    holes = array_of(schema.GetHoleIndicesAttr(), np.int64, time=time)
    if len(holes):
        faces = faces.only(~np.isin(faces.source, holes))
    flip = schema.GetOrientationAttr().Get(EARLIEST) == UsdGeom.Tokens.leftHanded
    triangles, source = triangles_of(points, faces, flip)
    return _hittable(points, triangles, source)


def tet_mesh_surface(prim: Any, time: Any, complain: Complain) -> FromMesh | None:
    """The outside of a TetMesh: its authored faces, else those that belong to only one tetrahedron."""
    schema = UsdGeom.TetMesh(prim)
    points = array_of(schema.GetPointsAttr(), np.float64, 3, time)
    named = array_of(schema.GetSurfaceFaceVertexIndicesAttr(), np.int64, 3, time)
    if not len(named):
        named = _outside(array_of(schema.GetTetVertexIndicesAttr(), np.int64, 4, time))
    if not len(points) or not len(named):
        complain("the tetrahedral mesh has no points or no tetrahedra; nothing can hit it")
        return None
    faces = usable_faces(points, np.full(len(named), 3), named.ravel(), complain)
    flip = schema.GetOrientationAttr().Get(EARLIEST) == UsdGeom.Tokens.leftHanded
    triangles, source = triangles_of(points, faces, flip)
    return _hittable(points, triangles, source)


def _hittable(points: Floats, triangles: Triangles, source: Integers) -> FromMesh | None:
    """The mesh with finite points alone, so that it has bounds; None without triangles.

    No triangle has a point that is not finite: they are put where the first triangle begins.
    """
    if not len(triangles):
        return None
    strange = ~np.isfinite(points).all(axis=1, keepdims=True)
    return (np.where(strange, points[triangles[0, 0]], points) if strange.any() else points), triangles, source


def _outside(tetrahedra: Integers) -> Integers:
    """Faces that belong to only one tetrahedron, counter-clockwise seen from outside for right-handed tetrahedra."""
    if not len(tetrahedra):
        return np.zeros((0, 3), np.int64)
    faces = tetrahedra[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3)
    _, first, number = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return np.asarray(faces[np.sort(first[number == 1])])


def _levels_here(prim: Any) -> int | None:
    """The refinement levels that the mesh itself sets, or None."""
    wanted = prim.GetAttribute(REFINE_HERE)
    if not wanted or not wanted.Get(EARLIEST):
        return None
    level = prim.GetAttribute(LEVELS)
    value = number_of(level)
    return max(0, min(int(value), MOST_LEVELS_HERE)) if math.isfinite(value) else 0


def _subdivided(
    schema: Any,
    points: Floats,
    faces: Polygons,
    scheme: str,
    tolerance: float,
    levels: int | None,
    time: Any,
    complain: Complain,
) -> tuple[Floats, Polygons]:
    cage = Cage(points, faces.counts, faces.corners, faces.source, _sharp(schema, len(points), time, complain))
    boundary = str(schema.GetInterpolateBoundaryAttr().Get(EARLIEST))
    fine = refine(
        cage,
        scheme,
        tolerance,
        levels=levels,
        boundary=boundary,
        smooth_triangles=str(schema.GetTriangleSubdivisionRuleAttr().Get(EARLIEST)) == "smooth",
        complain=complain,
    )
    return fine.points, Polygons(fine.counts, fine.corners, fine.source)


def _sharp(schema: Any, points: int, time: Any, complain: Complain) -> Sharp:
    """Creases and corners; those that do not fit the mesh are left out and reported."""
    lengths = array_of(schema.GetCreaseLengthsAttr(), np.int64, time=time)
    indices = array_of(schema.GetCreaseIndicesAttr(), np.int64, time=time)
    sharpness = array_of(schema.GetCreaseSharpnessesAttr(), np.float64, time=time)
    edges, edge_sharpness = np.zeros((0, 2), np.int64), np.zeros(0)
    fits = (lengths >= 2).all() and lengths.sum() == len(indices)
    segments = int((lengths - 1).sum())
    if not fits or len(sharpness) not in (len(lengths), segments) or not _within(indices, points):
        complain("its creases do not fit together or to its points; they are left out")
    elif len(lengths):
        inner = np.ones(len(indices), bool)
        inner[np.cumsum(lengths) - 1] = False  # the last point of a crease does not start an edge
        start = np.flatnonzero(inner)
        edges = np.stack([indices[start], indices[start + 1]], axis=1)
        edge_sharpness = sharpness if len(sharpness) == segments else np.repeat(sharpness, lengths - 1)
    corners = array_of(schema.GetCornerIndicesAttr(), np.int64, time=time)
    corner_sharpness = array_of(schema.GetCornerSharpnessesAttr(), np.float64, time=time)
    if len(corners) != len(corner_sharpness) or not _within(corners, points):
        complain("its corners do not fit together or to its points; they are left out")
        corners, corner_sharpness = corners[:0], corner_sharpness[:0]
    hard, pointed = edge_sharpness > 0, corner_sharpness > 0
    return Sharp(edges[hard], edge_sharpness[hard], corners[pointed], corner_sharpness[pointed])


def _within(indices: Integers, size: int) -> bool:
    return not len(indices) or bool(indices.min() >= 0 and indices.max() < size)
