"""Wrappers of prims of one type of USD: they define what is missing and refuse prims of another type."""

from __future__ import annotations

from typing import Any, ClassVar

from graph.isaac.results import Result, result

from .prim_base import define, prims_of
from .xform_prim import XformPrim


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
