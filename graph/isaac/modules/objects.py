"""`isaacsim.core.experimental.objects`: the shapes of USD."""

from __future__ import annotations

from typing import Any

from graph.isaac.results import Result, numbers, result
from graph.sim.usd import UsdGeom

from .accessors import colors_of, number, text
from .prims import GeomPrim
from .typed import Typed

__all__ = ["Capsule", "Cone", "Cube", "Cylinder", "Plane", "Shape", "Sphere"]


class Colored(Typed, GeomPrim):
    def set_display_colors(self, colors: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        given = colors_of(colors, len(chosen))
        for row, one in enumerate(chosen):
            if given is not None:
                UsdGeom.Gprim(self.prims[one]).CreateDisplayColorAttr().Set([tuple(map(float, given[row]))])

    set_colors = set_display_colors

    def get_display_colors(self, *, indices: Any = None) -> Result:
        found = [UsdGeom.Gprim(self.prims[one]).GetDisplayColorAttr().Get() for one in numbers(indices, len(self))]
        return result([(value or [(0.5, 0.5, 0.5)])[0] for value in found])

    @staticmethod
    def update_extents(geoms: list[Any]) -> None:
        for geom in geoms:
            geom.CreateExtentAttr().Set(UsdGeom.Boundable.ComputeExtentFromPlugins(geom, 0))


class Shape(Colored):
    set_sizes, get_sizes = number("size", "sizes", "double")
    set_radii, get_radii = number("radius", "radii", "double")
    set_heights, get_heights = number("height", "heights", "double")
    set_widths, get_widths = number("width", "widths", "double")
    set_lengths, get_lengths = number("length", "lengths", "double")
    set_axes, get_axes = text("axis", "axes", default="Z")


def _shape(kind: str) -> Any:
    return type(kind, (Shape,), {"kind": kind, "__module__": "isaacsim.core.experimental.objects"})


Cube, Sphere, Cylinder, Cone, Capsule = map(_shape, ("Cube", "Sphere", "Cylinder", "Cone", "Capsule"))
Plane = _shape("Plane")
