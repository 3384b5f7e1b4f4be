"""Writes prims directly into a layer: each of thousands of prims costs only a few calls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from graph.sim.transforms import Floats
from graph.sim.usd import Gf, Sdf, Vt

_TYPES = Sdf.ValueTypeNames
_UNIFORM = ("xformOpOrder", "purpose", "subdivisionScheme", "axis", "physics:axis", "orientation")


class Author:
    """Defines prims in one layer; the types of their attributes are given, because schemas are not consulted."""

    def __init__(self, layer: Any) -> None:
        self.layer = layer

    def prim(self, path: str, type_name: str, schemas: Sequence[str] = (), class_: bool = False) -> Any:
        """The spec of a prim; its parents must exist."""
        spec = Sdf.CreatePrimInLayer(self.layer, path)
        spec.specifier = Sdf.SpecifierClass if class_ else Sdf.SpecifierDef
        if type_name:
            spec.typeName = type_name
        if schemas:
            spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=list(schemas)))
        return spec

    def set(self, spec: Any, name: str, kind: str, value: Any) -> None:
        """Writes an attribute; `mjc:` ones are custom. kind: of the value, such as Double; None leaves it empty."""
        variability = Sdf.VariabilityUniform if name in _UNIFORM else Sdf.VariabilityVarying
        attribute = Sdf.AttributeSpec(spec, name, getattr(_TYPES, kind), variability)
        attribute.custom = name.startswith(("mjc:", "isaac:"))
        if value is not None:
            attribute.default = value

    def connect(self, spec: Any, name: str, kind: str, source: str) -> None:
        """Writes an attribute that takes its value from another."""
        attribute = Sdf.AttributeSpec(spec, name, getattr(_TYPES, kind))
        attribute.connectionPathList.explicitItems = [Sdf.Path(source)]

    def relate(self, spec: Any, name: str, target: str) -> None:
        """Writes a relationship to one prim."""
        Sdf.RelationshipSpec(spec, name, custom=False).targetPathList.explicitItems = [Sdf.Path(target)]

    def place(self, spec: Any, position: Floats, quaternion: Floats, scale: Sequence[float] | None = None) -> None:
        """Writes translate and orient (w, x, y, z), and scale if given."""
        self.set(spec, "xformOp:translate", "Double3", vector(position))
        self.set(spec, "xformOp:orient", "Quatd", turn(quaternion))
        order = ["xformOp:translate", "xformOp:orient"]
        if scale is not None:
            self.set(spec, "xformOp:scale", "Double3", vector(scale))
            order.append("xformOp:scale")
        self.set(spec, "xformOpOrder", "TokenArray", Vt.TokenArray(order))


def vector(values: Any) -> Any:
    """Three numbers as `Gf.Vec3d`."""
    return Gf.Vec3d(*(float(value) for value in values))


def turn(quaternion: Any) -> Any:
    """w, x, y, z as `Gf.Quatd`."""
    return Gf.Quatd(*(float(value) for value in quaternion))


def points(vertices: Any) -> Any:
    """(n, 3) as an array of points."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(vertices, dtype=np.float32))


def integers(values: Any) -> Any:
    """Whole numbers as an array."""
    return Vt.IntArray.FromNumpy(np.ascontiguousarray(values, dtype=np.int32).ravel())
