"""The triangles of one prim in its own space: every UsdGeom prim that has a surface."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from graph.base.limits import allowed, most
from graph.base.records import dataclass
from graph.sim.arrays import array_of, number_of
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom

from . import tessellation
from .closed_forms import ClosedForm, closed_form
from .mesh_shapes import FromMesh, mesh_surface, tet_mesh_surface
from .polygons import Complain, Integers
from .solids import SOLIDS
from .tessellation import Triangles

SIZES: dict[str, tuple[str, ...]] = {
    "Cube": ("size",),
    "Sphere": ("radius",),
    "Plane": ("width", "length"),
    **dict.fromkeys(("Capsule", "Cylinder", "Cone"), ("radius", "height")),
    **dict.fromkeys(("Capsule_1", "Cylinder_1"), ("radiusBottom", "radiusTop", "height")),
}
"""The attributes that give the size of each solid."""

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
        return _from_mesh(mesh_surface(prim, tolerance, refine, time, complain))
    if prim.IsA(UsdGeom.TetMesh):
        return _from_mesh(tet_mesh_surface(prim, time, complain))
    kind = str(prim.GetTypeName())
    found: Shape | None
    if prim.IsA(UsdGeom.Curves):
        from .curves import curves

        found = curves(prim, tolerance, time, complain)
    elif prim.IsA(UsdGeom.NurbsPatch):
        from .patches import patch

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


def _from_mesh(found: FromMesh | None) -> Surface | None:
    return None if found is None else Surface(*found)


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
    for name in SIZES[kind]:
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
