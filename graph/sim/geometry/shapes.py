"""The triangles of one prim in its own space: every UsdGeom prim that has a surface.

Meshes have holes, an orientation and subdivision; refined surfaces and curves are in `nurbs`, `curves`, `subdivision`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from graph.base.limits import allowed, most
from graph.base.records import dataclass
from graph.sim.attributes import array_of, number_of
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom

from . import tessellation
from .closed_forms import SOLIDS, ClosedForm, closed_form
from .polygons import Complain, Integers, Polygons, triangles_of, usable_faces
from .subdivision import SCHEMES, Cage, Sharp, refine
from .tessellation import Triangles

REFINE_HERE, LEVELS = "refinementEnableOverride", "refinementLevel"
"""Attributes of Omniverse: whether a mesh sets its own refinement, and the number of levels."""

MOST_LEVELS_HERE = 6


def mesh_surface(prim: Any, tolerance: float, refined: bool, time: Any, complain: Complain) -> Surface | None:
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
    return _hittable(points, *triangles_of(points, faces, flip))


def tet_mesh_surface(prim: Any, time: Any, complain: Complain) -> Surface | None:
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
    return _hittable(points, *triangles_of(points, faces, flip))


def _hittable(points: Floats, triangles: Triangles, source: Integers) -> Surface | None:
    """The mesh with finite points alone, so that it has bounds; None without triangles.

    No triangle has a point that is not finite: they are put where the first triangle begins.
    """
    if not len(triangles):
        return None
    strange = ~np.isfinite(points).all(axis=1, keepdims=True)
    return Surface(np.where(strange, points[triangles[0, 0]], points) if strange.any() else points, triangles, source)


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


Shape = tuple[Floats, Triangles]


@dataclass(frozen=True, eq=False)
class Surface:
    """vertices (n, 3), triangles (m, 3), and for meshes the face that each triangle comes from, (m,)."""

    vertices: Floats
    triangles: Triangles
    faces: Integers | None = None


def surface_of(
    prim: Any, tolerance: float, complain: Complain, *, refine: bool = False, time: Any = EARLIEST
) -> Surface | None:
    """The surface of a gprim in its own space; None if it has no surface (reported to `complain`).

    tolerance: the largest distance of a triangle from a curved surface, in the prim's own units (`mesh.tolerance`
    divided by the scale). refine: whether subdivision surfaces are refined instead of cast as their cages. Normals face
    out, also for left-handed meshes. A Plane is its rectangle, curves are tubes, Points are spheres.
    """
    if prim.IsA(UsdGeom.Mesh):
        return mesh_surface(prim, tolerance, refine, time, complain)
    if prim.IsA(UsdGeom.TetMesh):
        return tet_mesh_surface(prim, time, complain)
    kind = str(prim.GetTypeName())
    found: Shape | None
    if prim.IsA(UsdGeom.Curves):
        from .curves import curves

        found = curves(prim, tolerance, time, complain)
    elif prim.IsA(UsdGeom.NurbsPatch):
        from .nurbs import patch

        found = patch(prim, tolerance, time, complain)
    elif prim.IsA(UsdGeom.Points):
        found = points_surface(prim, tolerance, time, complain)
    elif kind in SOLIDS:
        found = _solid(prim, kind, tolerance, time, complain)
    else:
        complain(f"rays do not see a {kind}; it has no surface that they could meet")
        return None
    return None if found is None else Surface(*found)


def shape_of(prim: Any, tolerance: float, complain: Complain) -> Shape | None:
    """Vertices (n, 3) and triangles (m, 3) of `surface_of`, with cages instead of subdivision surfaces."""
    found = surface_of(prim, tolerance, complain)
    return None if found is None else (found.vertices, found.triangles)


def exact_solid(prim: Any, tolerance: float, complain: Complain) -> tuple[ClosedForm, Callable[[], Shape]] | None:
    """The closed form of a gprim's surface in its own space, and a call that makes its triangles; None without one."""
    kind = str(prim.GetTypeName())
    read = _sizes_of(prim, kind, EARLIEST, complain) if kind in SOLIDS else None
    form = None if read is None else closed_form(kind, *read)
    if read is None or form is None:
        return None
    sizes, axis = read

    def make() -> Shape:
        made = solid(kind, sizes, axis, tolerance, lambda message: None)
        assert made is not None, "a solid with a closed form has a surface"
        return made

    return form, make


def _solid(prim: Any, kind: str, tolerance: float, time: Any, complain: Complain) -> Shape | None:
    read = _sizes_of(prim, kind, time, complain)
    return None if read is None else solid(kind, *read, tolerance, complain)


def _sizes_of(prim: Any, kind: str, time: Any, complain: Complain) -> tuple[dict[str, float], str] | None:
    """The sizes of a solid and its axis; None, and reported, if they make no surface."""
    sizes = {}
    for name in SOLIDS[kind]:
        sizes[name] = number_of(prim.GetAttribute(name), time)
    if not all(0 <= value < math.inf for value in sizes.values()):
        complain(f"its sizes {sizes} are not all finite and positive; it is left out")
        return None
    if not any(sizes.values()):
        complain("its size is 0; nothing can hit it")
        return None
    axis = "Z" if kind in ("Cube", "Sphere") else str(prim.GetAttribute("axis").Get(EARLIEST))
    if axis not in ("X", "Y", "Z"):
        complain(f"its axis {axis!r} is not one of X, Y, Z; Z is used")
        axis = "Z"
    return sizes, axis


def solid(kind: str, sizes: dict[str, float], axis: str, tolerance: float, complain: Complain) -> Shape | None:
    """One of `SOLIDS` from its sizes (named as in UsdGeom)."""
    radius = max((sizes[name] for name in sizes if name.startswith("radius")), default=0.0)
    if kind == "Cube":
        return tessellation.cube(sizes["size"])
    if kind == "Plane":
        return tessellation.rectangle(sizes["width"], sizes["length"], axis)
    round_parts = tessellation.sphere_parts if kind[:3] in ("Sph", "Cap") else tessellation.circle_parts
    parts = round_parts(radius, tolerance)
    if parts == tessellation.MOST_PARTS:
        complain(f"mesh.tolerance would need more than {parts} parts for its radius {radius:g}; it has {parts}")
    if kind == "Sphere":
        return tessellation.sphere(radius, parts)
    bottom = sizes.get("radiusBottom", sizes.get("radius", 0.0))
    top = sizes.get("radiusTop", 0.0 if kind == "Cone" else bottom)
    height = sizes["height"]
    if radius == 0:
        complain("its radius is 0; nothing can hit it")
        return None
    if kind.startswith("Capsule"):
        return tessellation.capsule(bottom, top, height, axis, parts)
    if bottom == 0:
        vertices, triangles = tessellation.cylinder(top, bottom, height, axis, parts)
        return -vertices, np.ascontiguousarray(triangles[:, ::-1])
    return tessellation.cylinder(bottom, top, height, axis, parts)


def points_surface(prim: Any, tolerance: float, time: Any, complain: Complain) -> Shape | None:
    """A sphere around each point of a Points prim, with the point's width."""
    schema = UsdGeom.Points(prim)
    points = array_of(schema.GetPointsAttr(), np.float64, 3, time)
    widths = array_of(schema.GetWidthsAttr(), np.float64, time=time)
    if not len(points) or not len(widths):
        complain("the points have no places or no widths, so they have no surface; nothing can hit them")
        return None
    if len(widths) not in (1, len(points)):
        complain(f"there are {len(points)} points and {len(widths)} widths; it is left out")
        return None
    radii = np.broadcast_to(widths / 2, len(points))
    good = np.isfinite(points).all(axis=1) & np.isfinite(radii) & (radii > 0)
    if not good.all():
        complain(f"{int((~good).sum())} points are not finite or have no width; they are left out")
    points, radii = points[good], radii[good]
    if not len(points):
        return None
    vertices, triangles = tessellation.sphere(1.0, tessellation.sphere_parts(float(radii.max()), tolerance))
    if len(points) * len(triangles) > most("scene.triangles"):
        said = f"{len(points):,} spheres of {len(triangles):,} triangles are too many; raise mesh.tolerance"
        complain(f"{said}; {allowed('scene.triangles')}")
        return None
    every = points[:, None] + radii[:, None, None] * vertices
    first = (np.arange(len(points)) * len(vertices)).astype(np.uint32)
    return every.reshape(-1, 3), (triangles[None] + first[:, None, None]).reshape(-1, 3)
