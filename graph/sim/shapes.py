"""The triangles of one prim in its own space: every UsdGeom solid and mesh."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import tessellation
from .tessellation import Triangles
from .transforms import Floats
from .triangulation import triangulate
from .usd import EARLIEST, UsdGeom

SOLIDS = ("Cube", "Sphere", "Capsule", "Capsule_1", "Cylinder", "Cylinder_1", "Cone", "Plane")
"""Types of UsdGeom that have a surface given by a few numbers."""

Shape = tuple[Floats, Triangles]
Complain = Callable[[str], None]


def shape_of(prim: Any, tolerance: float, complain: Complain) -> Shape | None:
    """Vertices (n, 3) and triangles (m, 3) of a gprim in its own space; None if it has no surface (told to `complain`).

    tolerance: how far a triangle may lie inside a curved surface, in the prim's own units (`mesh.tolerance` divided by
    the scale). Normals face out, also of left-handed meshes. A Plane is its rectangle.
    """
    if prim.IsA(UsdGeom.Mesh):
        return mesh(prim, complain)
    kind = str(prim.GetTypeName())
    if kind not in SOLIDS:
        complain(f"rays do not see a {kind}; only meshes and {', '.join(SOLIDS)}.")
        return None
    sizes = {
        name: float(prim.GetAttribute(name).Get(EARLIEST))
        for name in ("size", "radius", "radiusBottom", "radiusTop", "height", "width", "length")
        if prim.GetAttribute(name)
    }
    if not all(np.isfinite(value) and value >= 0 for value in sizes.values()):
        complain(f"its sizes {sizes} are not all finite and positive; it is left out.")
        return None
    if not any(sizes.values()):
        return None
    axis = str(prim.GetAttribute("axis").Get(EARLIEST)) if prim.GetAttribute("axis") else "Z"
    return solid(kind, sizes, axis, tolerance, complain)


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
        complain(f"mesh.tolerance would need more than {parts} parts for its radius {radius:g}; it has {parts}.")
    if kind == "Sphere":
        return tessellation.sphere(radius, parts)
    if kind == "Capsule" or (kind == "Capsule_1" and sizes["radiusBottom"] == sizes["radiusTop"]):
        return tessellation.capsule(radius, sizes["height"], axis, parts)
    if kind == "Capsule_1":
        complain("a Capsule_1 with two radii is not supported; give both ends one radius, or use a Mesh.")
        return None
    bottom = sizes.get("radiusBottom", sizes.get("radius", 0.0))
    top = sizes.get("radiusTop", 0.0 if kind == "Cone" else bottom)
    if bottom == 0:
        vertices, triangles = tessellation.cylinder(top, bottom, sizes["height"], axis, parts)
        return -vertices, np.ascontiguousarray(triangles[:, ::-1])
    return tessellation.cylinder(bottom, top, sizes["height"], axis, parts)


def mesh(prim: Any, complain: Complain) -> Shape | None:
    """A mesh's faces as triangles (a subdivision surface as its cage)."""
    schema = UsdGeom.Mesh(prim)
    points = _array(schema.GetPointsAttr(), np.float64).reshape(-1, 3)
    counts = _array(schema.GetFaceVertexCountsAttr(), np.int64)
    if not len(points) or not len(counts):
        complain("the mesh has no points or no faces; nothing can hit it.")
        return None
    triangles, _ = triangulate(
        points,
        counts,
        _array(schema.GetFaceVertexIndicesAttr(), np.int64),
        holes=_array(schema.GetHoleIndicesAttr(), np.int64),
        flip=schema.GetOrientationAttr().Get(EARLIEST) == UsdGeom.Tokens.leftHanded,
        complain=complain,
    )
    return (points, triangles) if len(triangles) else None


def _array(attribute: Any, kind: type) -> NDArray[Any]:
    value = attribute.Get(EARLIEST)
    return np.zeros(0, kind) if value is None else np.asarray(value).astype(kind)
