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


FAR = 8.0
"""Distance, over a triangle's size, from which on it counts as its area seen at its middle: within 3 % of its angle."""


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
        near: list[tuple[Any, list[str]]] = []
        for place, passed, around in zip(places, excluded, found, strict=True):
            local = to_local.Transform(place)
            if extent.Contains(local) and not f"{path}/".startswith(passed):
                near.append((local, around))
        wound = winding_numbers(shape, np.array([local for local, _ in near])) if near else ()
        for (_, around), number in zip(near, wound, strict=True):
            if number > WOUND:
                around.append(path)
    return found


def _extent(shape: Any) -> Any:
    """The bounding box of a shape in its own space, or None."""
    try:
        extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(shape), EARLIEST)
    except Tf.ErrorException:  # of a shape that is reported where it is read
        return None
    return Gf.Range3d(*map(Gf.Vec3d, extent)) if extent is not None and len(extent) == 2 else None


def winding_numbers(shape: Any, points: Floats) -> Floats:
    """(n,) the winding numbers of a gprim's surface about points (n, 3) of its own space. 1 inside, 0 outside, -1
    inside out, half of it on a face.

    The sum of the solid angles of its triangles over 4 pi; A. Van Oosterom, J. Strackee, "The Solid Angle of a Plane
    Triangle", 1983; of distant ones (`FAR`) by area over distance squared.
    """
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(shape), EARLIEST)
    size = float(np.ptp(np.array(extent, np.float64), axis=0).max())
    surface = surface_of(shape, TOLERANCE * size, lambda problem: None)
    if surface is None:
        return np.zeros(len(points))
    vertices = np.asarray(surface.vertices, np.float64).T
    corners = [vertices[:, corner] for corner in surface.triangles.T]
    normal = _cross(corners[1] - corners[0], corners[2] - corners[0])
    thin = ON_FACE * size * np.sqrt(_dot(normal, normal))
    middle = (corners[0] + corners[1] + corners[2]) / 3
    reach = FAR**2 * np.maximum.reduce([_dot(arm, arm) for arm in (corner - middle for corner in corners)])
    found = []
    for point in points:
        away = middle - point[:, None]
        square = _dot(away, away)
        near = square <= reach
        far = np.where(near, 1.0, square)
        angles = np.where(near, 0.0, _dot(away, normal) / (4 * far * np.sqrt(far)))
        a, b, c = (corner[:, near] - point[:, None] for corner in corners)
        x, y, z = (np.sqrt(_dot(arm, arm)) for arm in (a, b, c))
        volume = _dot(a, normal[:, near])
        flat = x * y * z + _dot(a, b) * z + _dot(b, c) * x + _dot(c, a) * y
        off = np.abs(volume) > thin[near]
        found.append((angles.sum() + np.arctan2(volume[off], flat[off]).sum()) / (2 * np.pi))
    return np.array(found)


def _cross(a: Floats, b: Floats) -> Floats:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _dot(a: Floats, b: Floats) -> Floats:
    out: Floats = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return out
