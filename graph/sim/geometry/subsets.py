"""GeomSubsets: faces of a mesh that are separate surfaces."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass
from graph.sim.attributes import array_of
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom, UsdShade

from .closed_forms import ClosedForm
from .polygons import Complain, Integers
from .shapes import Shape, Surface
from .tessellation import Triangles

MATERIALS = str(UsdShade.Tokens.materialBind)


@dataclass(frozen=True, eq=False)
class Part:
    """Vertices (n, 3) and triangles (m, 3) of a prim, or of the faces of one of its subsets (`name`, else empty).

    mine: which triangles of the whole surface these are, (all,) bool, and used: its vertices that they use, (n,); None
    for the whole.
    """

    name: str
    vertices: Floats
    triangles: Triangles
    mine: NDArray[np.bool_] | None = None
    used: Integers | None = None


class SolidPart:
    """A prim that is one solid: its closed form, and its triangles, which are made when they are read.

    make: gives vertices (n, 3) and triangles (m, 3) in the prim's own space.
    """

    name = ""

    def __init__(self, form: ClosedForm, make: Callable[[], Shape]) -> None:
        self.form, self._make = form, make

    @cached_property
    def shape(self) -> Shape:
        """Vertices (n, 3) and triangles (m, 3)."""
        return self._make()


def parts_of(prim: Any, surface: Surface, complain: Complain) -> tuple[Part, ...]:
    """The surface cut by the prim's face subsets that bind materials or carry labels; faces in no subset come first.

    A face in several subsets belongs to the first: those of the family `materialBind` before others, then in stage
    order. Subsets without faces are not surfaces.
    """
    whole = (Part("", surface.vertices, surface.triangles),)
    if surface.faces is None:
        return whole
    subsets = [each for each in prim.GetChildren() if each.IsA(UsdGeom.Subset) and _counts(each)]
    if not subsets:
        return whole
    subsets.sort(key=lambda each: _family(each) != MATERIALS)
    size = int(surface.faces.max()) + 1
    total = _face_count(prim)
    owner = np.full(max(size, total), -1, np.int64)
    for number, subset in enumerate(subsets):
        indices = array_of(UsdGeom.Subset(subset).GetIndicesAttr(), np.int64)
        good = indices[(indices >= 0) & (indices < total)]
        if len(good) < len(indices):
            complain(f"its subset {subset.GetName()} names {len(indices) - len(good)} faces that do not exist")
        free = good[owner[good] < 0]
        if len(free) < len(np.unique(good)):
            complain(f"its subset {subset.GetName()} shares faces with another one, which keeps them")
        owner[free] = number
    of_triangle = owner[surface.faces]
    return tuple(
        _part(subsets[number].GetName() if number >= 0 else "", surface, of_triangle == number)
        for number in range(-1, len(subsets))
        if (of_triangle == number).any()
    )


def _part(name: str, surface: Surface, mine: NDArray[np.bool_]) -> Part:
    used, compact = np.unique(surface.triangles[mine], return_inverse=True)
    return Part(name, surface.vertices[used], compact.reshape(-1, 3).astype(np.uint32), mine, used.astype(np.int64))


def _counts(subset: Any) -> bool:
    schema = UsdGeom.Subset(subset)
    if schema.GetElementTypeAttr().Get(EARLIEST) != UsdGeom.Tokens.face:
        return False
    return (
        _family(subset) == MATERIALS
        or "semantic" in _family(subset).lower()
        or any("Semantics" in each or each == "MaterialBindingAPI" for each in subset.GetAppliedSchemas())
    )


def _family(subset: Any) -> str:
    return str(UsdGeom.Subset(subset).GetFamilyNameAttr().Get(EARLIEST) or "")


def _face_count(prim: Any) -> int:
    return len(array_of(UsdGeom.Mesh(prim).GetFaceVertexCountsAttr(), np.int64)) if prim.IsA(UsdGeom.Mesh) else 0
