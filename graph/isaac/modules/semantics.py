"""`pxr.Semantics`: the former labels of prims."""

from __future__ import annotations

from typing import Any

from graph.sim.usd import Sdf

from .own_schemas import OwnSchema, applied, take_own_schemas

__all__ = ["SemanticsAPI"]


class SemanticsAPI(OwnSchema):
    name = "SemanticsAPI"

    def __init__(self, prim: Any, instance: str = "Semantics") -> None:
        self._prim, self._instance = prim, instance

    @classmethod
    def Apply(cls, prim: Any, instance: str = "Semantics") -> SemanticsAPI:
        prim.AddAppliedSchema(f"SemanticsAPI:{instance}")
        return cls(prim, instance)

    @classmethod
    def Get(cls, prim: Any, instance: str = "Semantics") -> SemanticsAPI:
        return cls(prim, instance)

    def __bool__(self) -> bool:
        return f"SemanticsAPI:{self._instance}" in applied(self._prim)

    def GetPrim(self) -> Any:
        return self._prim

    def _attribute(self, name: str) -> Any:
        return self._prim.CreateAttribute(f"semantic:{self._instance}:params:{name}", Sdf.ValueTypeNames.String)

    def CreateSemanticTypeAttr(self, *_: Any) -> Any:
        return self._attribute("semanticType")

    def CreateSemanticDataAttr(self, *_: Any) -> Any:
        return self._attribute("semanticData")

    def GetSemanticTypeAttr(self) -> Any:
        return self._prim.GetAttribute(f"semantic:{self._instance}:params:semanticType")

    def GetSemanticDataAttr(self) -> Any:
        return self._prim.GetAttribute(f"semantic:{self._instance}:params:semanticData")


take_own_schemas()
