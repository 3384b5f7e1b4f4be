"""Normals that meshes author: each corner of a triangle has one; weighted as the place in it is, they give its own.

Rays meet spheres, cylinders, cones and capsules by formula, with their true normals (`mesh.solids`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.records import dataclass
from graph.sim.attributes import array_of
from graph.sim.geometry.surfaces import Mesh
from graph.sim.transforms import apply
from sensors.raycast.world import CastWorld, once_a_world, soft_prim

from .looks import by_surface
from .paints import ByCorner, Painter
from .view import View

if TYPE_CHECKING:
    pass

FLAT = 1e-4
"""Normals that differ by less than this from the triangle's do not make a surface smooth."""


@dataclass(frozen=True, eq=False)
class Smooth:
    """normals: at corners, in the frame of the mesh. lift: (m,) float32 [m], how far the smooth surface rises above
    each triangle: from there nothing of the surface itself stands in the way of light.
    """

    normals: ByCorner
    lift: np.ndarray


@once_a_world
def smooth_surfaces(world: CastWorld) -> Mapping[int, Smooth]:
    """The smooth surfaces of a cast world by number."""
    painter = Painter(world.scene.stage, world.scene.warn)
    each = {number: _smooth(surface, painter, world) for number, surface in enumerate(world.surfaces)}
    return {number: one for number, one in each.items() if one is not None}


def smoothen(view: View, shapes: Mapping[int, Smooth], world: CastWorld, state: Any) -> None:
    """Gives a view with normals and spots the normals of smooth surfaces, and its lift."""
    hits = view.hits
    if not shapes or hits.normals is None or hits.spots is None:
        return
    normals = view.facing_normals()  # by the triangles: those that are seen face the camera
    rows = np.flatnonzero(np.isfinite(hits.distance))
    poses = world.body_poses(state)
    for number, some in by_surface(shapes, hits.surfaces(rows)):
        mine = rows[some]
        triangle, flat = hits.spots.triangle[mine], normals[mine]
        found = shapes[number].normals.at(triangle, hits.spots.uv[mine])
        body = int(world.body_of[number])
        if body >= 0 and poses is not None:
            found = apply(poses[body][:3, :3].astype(np.float32), found)
        length = np.sqrt((found * found).sum(axis=1, keepdims=True))
        length[(found * flat).sum(axis=1) < 0] *= -1  # on the side of the triangle's
        with np.errstate(divide="ignore", invalid="ignore"):
            found /= length
        good = np.isfinite(found).all(axis=1)
        normals[mine[good]] = found[good]
        if view.lift is None:
            view.lift = np.zeros(len(hits.distance), np.float32)
        view.lift[mine] = np.take(shapes[number].lift, triangle, mode="clip")


def _smooth(surface: Any, painter: Painter, world: CastWorld) -> Smooth | None:
    if not isinstance(surface, Mesh) or surface.frame is None or soft_prim(surface, world.soft):
        return None
    prim = painter.gprim(surface)
    if not prim or str(prim.GetTypeName()) != "Mesh":
        return None
    corners = surface.vertices[surface.triangles.astype(np.intp)]
    normals = _authored(prim, surface, painter)
    if normals is None:
        return None
    with np.errstate(all="ignore"):
        normals = apply(np.linalg.inv(surface.frame[:3, :3]).T, normals)
        unit = normals / np.linalg.norm(normals, axis=2, keepdims=True)
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
        unit *= np.where((unit * flat[:, None]).sum(axis=2, keepdims=True) < 0, -1.0, 1.0)
        if not (np.abs(unit - flat[:, None]) > FLAT).any():
            return None
        # Heights of the corners above the planes that touch at the others; the surface rises by a third at most.
        heights = ((corners[:, None] - corners[:, :, None]) * unit[:, :, None]).sum(axis=3)
        lift = np.nan_to_num(np.maximum(-heights, 0).max(axis=(1, 2)) / 3)
    return Smooth(ByCorner(normals.astype(np.float32)), lift.astype(np.float32))


def _authored(prim: Any, surface: Mesh, painter: Painter) -> np.ndarray | None:
    """(m, 3, 3) in the prim's space: primvars:normals, else normals."""
    from graph.sim.usd import UsdGeom

    found = painter.primvar(surface, "normals", 3)
    if found is None:
        schema = UsdGeom.Mesh(prim)
        given = array_of(schema.GetNormalsAttr(), np.float64, 3)
        corners = painter.corners(surface) if len(given) else None
        found = None if corners is None else corners.values(given, str(schema.GetNormalsInterpolation()))
    return None if found is None or len(found) != len(surface.triangles) else found.astype(np.float64)
