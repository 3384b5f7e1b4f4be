"""`pxr.OmniGraphSchema`: graphs and nodes among the prims of a stage."""

from __future__ import annotations

from typing import Any

__all__ = ["OmniGraph", "OmniGraphNode"]


class _Schema:
    kind = ""

    def __init__(self, prim: Any = None) -> None:
        self._prim = prim

    @classmethod
    def Get(cls, stage: Any, path: Any) -> _Schema:
        return cls(stage.GetPrimAtPath(path))

    @classmethod
    def Define(cls, stage: Any, path: Any) -> _Schema:
        return cls(stage.DefinePrim(path, cls.kind))

    def GetPrim(self) -> Any:
        return self._prim

    def __bool__(self) -> bool:
        return bool(self._prim) and self._prim.GetTypeName() == self.kind


class OmniGraph(_Schema):
    kind = "OmniGraph"


class OmniGraphNode(_Schema):
    kind = "OmniGraphNode"

    def GetNodeTypeAttr(self) -> Any:
        return self._prim.GetAttribute("node:type")

    def GetNodeTypeVersionAttr(self) -> Any:
        return self._prim.GetAttribute("node:typeVersion")
