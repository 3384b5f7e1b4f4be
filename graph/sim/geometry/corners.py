"""What a mesh authors at its corners, by triangle: primvars and normals of every interpolation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass
from graph.sim.attributes import array_of
from graph.sim.usd import EARLIEST, UsdGeom

from .polygons import Complain, Integers
from .shapes import surface_of
from .subsets import parts_of
from .surfaces import Mesh


@dataclass(frozen=True, eq=False)
class Corners:
    """The triangles of a mesh by the arrays of its prim, in the order of `Mesh.triangles`.

    face: (m,), its face. point: (m, 3), the points of its corners; place: (m, 3), their entries of
    faceVertexIndices.
    """

    face: Integers
    point: Integers
    place: Integers

    def values(self, given: NDArray[Any], interpolation: str, indices: Integers | None = None) -> NDArray[Any] | None:
        """(m, 3, k) float32, authored values (n, k) at each corner; None if they are too few or not finite.

        indices: into the values, if the primvar has them.
        """
        index = {
            "uniform": self.face[:, None] + np.zeros((1, 3), np.int64),
            "vertex": self.point,
            "varying": self.point,
            "faceVarying": self.place,
        }.get(interpolation, np.zeros_like(self.point))
        for length, chosen in ((None if indices is None else len(indices), indices), (len(given), None)):
            if length is not None and (index.max(initial=0) >= length or index.min(initial=0) < 0):
                return None
            index = index if chosen is None else chosen[index]
        found = given[index].astype(np.float32)
        return found if np.isfinite(found).all() else None


def corners_of(prim: Any, mesh: Mesh) -> Corners | None:
    """The corners of a mesh that was collected from a Mesh prim or from one of its subsets (`Mesh.source`).

    None for other prims, and for refined subdivision surfaces, whose corners are not those of the prim.
    """
    name = ""
    if prim and prim.IsA(UsdGeom.Subset):
        name, prim = prim.GetName(), prim.GetParent()
    if not prim or not prim.IsA(UsdGeom.Mesh):
        return None
    surface = surface_of(prim, 1.0, _ignore)
    if surface is None or surface.faces is None:
        return None
    part = next((each for each in parts_of(prim, surface, _ignore) if each.name == name), None)
    if part is None or part.triangles.shape != mesh.triangles.shape:
        return None
    if not any(np.array_equal(mesh.triangles, each) for each in (part.triangles, part.triangles[:, ::-1])):
        return None
    face = surface.faces if part.mine is None else surface.faces[part.mine]
    point = mesh.triangles.astype(np.int64)
    if part.used is not None:
        point = part.used[point]
    place = _places(prim, face, point)
    return None if place is None else Corners(face, point, place)


def _ignore(message: str) -> None:
    """What is wrong with the mesh was said when it was collected."""


def _places(prim: Any, face: Integers, point: Integers) -> Integers | None:
    """(m, 3), the entries of faceVertexIndices that are the points (m, 3) of faces (m,)."""
    schema = UsdGeom.Mesh(prim)
    counts = np.maximum(array_of(schema.GetFaceVertexCountsAttr(), np.int64), 0)
    indices = array_of(schema.GetFaceVertexIndicesAttr(), np.int64)
    owner = np.repeat(np.arange(len(counts)), counts)[: len(indices)]
    size = int(point.max(initial=0)) + 1
    usable = np.flatnonzero((indices[: len(owner)] >= 0) & (indices[: len(owner)] < size))
    keys = owner[usable] * size + indices[usable]
    order = np.argsort(keys, kind="stable")
    wanted = face[:, None] * size + point
    at = np.searchsorted(keys[order], wanted)
    if at.max(initial=0) >= len(keys):
        return None
    found = order[at]
    return np.asarray(usable[found]) if np.array_equal(keys[found], wanted) else None


def primvar_at_corners(primvar: Any, corners: Corners, width: int, complain: Complain) -> NDArray[Any] | None:
    """(m, 3, width) float32 of a `UsdGeom.Primvar`; None, told to `complain`, if it does not fit to the mesh."""
    given = array_of(primvar.GetAttr(), np.float64, width if width > 1 else 0).reshape(-1, width)
    indices = np.asarray(primvar.GetIndices(EARLIEST), np.int64).reshape(-1) if primvar.IsIndexed() else None
    found = corners.values(given, str(primvar.GetInterpolation()), indices) if len(given) else None
    if found is None:
        complain(f"{primvar.GetPrimvarName()} does not fit to its mesh, or is not finite; it is left out")
    return found
