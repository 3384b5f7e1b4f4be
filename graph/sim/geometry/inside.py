"""Finds the shapes that contain a point, by winding numbers, so that a shape need not be fully closed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, Gf, Tf, UsdGeom

from .collect import visible_prims
from .shapes import surface_of

WOUND = 0.75
"""Winding number from which on a point is inside: an open sheet gives at most 0.5, a closed surface 1."""

TOLERANCE = 0.01
"""How far triangles may lie off a curved surface, as a fraction of the shape's size."""

ON_FACE = 1e-6
"""Distance up to which a point counts as on a triangle's plane, as a fraction of the shape's size: a sensor stands
on its mount.
"""

MOST_FREE = 3
"""Of the six directions along the axes: with more that meet no triangle, a point cannot be three quarters enclosed."""


def shapes_around(stage: Any, prims: Sequence[Any], excludes: Sequence[Iterable[str]]) -> list[list[str]]:
    """For each prim, the paths of the visible shapes that contain its origin, in their initial poses.

    excludes: for each prim, paths of prims that are skipped, with their descendants. Copies of point instancers are
    not examined.
    """
    found: list[list[str]] = [[] for _ in prims]
    if not prims:
        return found
    poses = UsdGeom.XformCache(EARLIEST)
    places = [poses.GetLocalToWorldTransform(prim).ExtractTranslation() for prim in prims]
    excluded = [tuple(f"{path}/" for path in exclude) for exclude in excludes]
    for shape, path in visible_prims(stage):
        extent = None if shape.IsA(UsdGeom.PointInstancer) else _extent(shape)
        if extent is None:
            continue
        to_local = poses.GetLocalToWorldTransform(shape).GetInverse()
        for place, passed, around in zip(places, excluded, found, strict=True):
            local = to_local.Transform(place)
            if not extent.Contains(local) or f"{path}/".startswith(passed):
                continue
            if winding_number(shape, np.array(local)) > WOUND:
                around.append(path)
    return found


def _extent(shape: Any) -> Any:
    """The bounding box of a shape in its own space, or None."""
    try:
        extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(shape), EARLIEST)
    except Tf.ErrorException:  # of a shape that is reported where it is read
        return None
    return Gf.Range3d(*map(Gf.Vec3d, extent)) if extent is not None and len(extent) == 2 else None


def winding_number(shape: Any, point: Floats) -> float:
    """The winding number of a gprim's surface about a point of its own space. 1 inside, 0 outside, -1 inside out, half
    of it on a face; 0 also where the view along most axes is free, which a quicker test finds.

    The sum of the solid angles of its triangles over 4 pi; A. Van Oosterom, J. Strackee, "The Solid Angle of a Plane
    Triangle", 1983.
    """
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(shape), EARLIEST)
    size = float(np.ptp(np.array(extent, np.float64), axis=0).max())
    surface = surface_of(shape, TOLERANCE * size, lambda problem: None)
    if surface is None:
        return 0.0
    places = np.asarray(surface.vertices, np.float64) - point
    if _free_directions(places, surface.triangles) > MOST_FREE:
        return 0.0
    a, b, c = (places[surface.triangles[:, corner]] for corner in range(3))
    x, y, z = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    flat = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
    off = np.abs(volume) > ON_FACE * size * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return float(np.arctan2(volume, flat)[off].sum() / (2 * np.pi))


def _free_directions(places: Floats, triangles: Any) -> int:
    """How many of the six rays along the axes meet the bounds of no triangle; places (V, 3) about their origin."""
    above = (places >= 0)[triangles].sum(axis=1, dtype=np.uint8)  # of the corners of each triangle, by axis
    across = (above > 0) & (above < 3)
    free = 0
    for axis in range(3):
        met = above[across[:, axis - 1] & across[:, axis - 2], axis]
        free += not (met > 0).any()
        free += not (met < 3).any()
    return free
