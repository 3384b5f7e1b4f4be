"""Wrappers of prims of one type of USD: they define what is missing and refuse prims of another type."""

from __future__ import annotations

from typing import Any, ClassVar

from graph.isaac.results import Result, result
from graph.sim.usd import Sdf

from .prim_base import XformPrim, found_or_new
from .stage import usd_stage


def define(paths: Any, kind: str) -> list[str]:
    """Defines missing prims of a type. Raises AssertionError for an existing prim of another."""
    stage = usd_stage()
    found = found_or_new([paths] if isinstance(paths, str) else list(paths))
    for path in found:
        if not Sdf.Path.IsValidPathString(path):
            raise ValueError(f"no prim matches {path}, and a prim cannot be named so")
        prim = stage.GetPrimAtPath(path)
        if prim and prim.GetTypeName() != kind and prim.GetTypeName():
            raise AssertionError(f"{path} is a {prim.GetTypeName()}, not a {kind}")
        if not prim or not prim.GetTypeName():
            stage.DefinePrim(path, kind)
    return found


class Typed(XformPrim):
    kind: ClassVar[str] = ""
    """The type of USD; "" for a family, of which `fetch_instances` gives members."""

    def __init__(self, paths: Any, *, reset_xform_op_properties: bool = True, **options: Any) -> None:
        pose = {key: options.pop(key, None) for key in ("positions", "translations", "orientations", "scales")}
        super().__init__(
            define(paths, self.kind), resolve_paths=False, reset_xform_op_properties=reset_xform_op_properties, **pose
        )
        for name, value in options.items():
            if value is not None:
                getattr(self, f"set_{name}")(value)

    @classmethod
    def _members(cls) -> dict[str, Any]:
        """The classes that it stands for, by the type of USD."""
        below = {kind: one for sub in cls.__subclasses__() for kind, one in sub._members().items()}
        return below | ({cls.kind: cls} if cls.kind else {})

    @classmethod
    def are_of_type(cls, paths: Any) -> Result:
        members = cls._members()
        return result([prim.GetTypeName() in members for prim in prims_of(paths)], bool)

    @classmethod
    def fetch_instances(cls, paths: Any) -> list[Any]:
        members = cls._members()
        kinds = [(prim, members.get(prim.GetTypeName())) for prim in prims_of(paths)]
        return [None if made is None else made(str(prim.GetPath())) for prim, made in kinds]


def prims_of(paths: Any) -> list[Any]:
    """The prims of one path or prim, or of a list of these."""
    listed = paths if isinstance(paths, (list, tuple)) else [paths]
    return [usd_stage().GetPrimAtPath(one) if isinstance(one, str) else one for one in listed]
