"""`usdrt`: paths, and the stage with Fabric's values."""

from __future__ import annotations

from typing import Any

from graph.isaac.session import app
from graph.sim.usd import Gf as PxrGf
from graph.sim.usd import Sdf as PxrSdf
from graph.sim.usd import UsdGeom as PxrUsdGeom
from graph.sim.usd import Vt as PxrVt

__all__ = ["Gf", "Rt", "Sdf", "Usd", "UsdGeom", "Vt"]
Gf, Vt = PxrGf, PxrVt


class Sdf:
    Path = PxrSdf.Path
    ValueTypeNames = PxrSdf.ValueTypeNames
    AssetPath = PxrSdf.AssetPath


class _Prim:
    """A prim of the stage; transforms and values that only Fabric has come from there."""

    def __init__(self, prim: Any) -> None:
        self._prim = prim

    def __bool__(self) -> bool:
        return bool(self._prim)

    IsValid = __bool__

    def GetPath(self) -> Any:
        return self._prim.GetPath()

    def GetName(self) -> str:
        return str(self._prim.GetName())

    def GetTypeName(self) -> str:
        return str(self._prim.GetTypeName())

    def HasAttribute(self, name: str) -> bool:
        return bool(self.GetAttribute(name).IsValid())

    def GetAttribute(self, name: str) -> _Attribute:
        return _Attribute(self._prim, name)

    def CreateAttribute(self, name: str, type_name: Any, custom: bool = True) -> _Attribute:
        self._prim.CreateAttribute(name, type_name, custom)
        return _Attribute(self._prim, name)

    def GetRelationship(self, name: str) -> Any:
        return self._prim.GetRelationship(name)

    def GetChildren(self) -> list[_Prim]:
        return [_Prim(one) for one in self._prim.GetChildren()]


class _Attribute:
    def __init__(self, prim: Any, name: str) -> None:
        self._prim, self._name = prim, name

    @property
    def _found(self) -> Any:
        return app().fabric.get_prim_at_path(str(self._prim.GetPath())).get_attribute(self._name)

    def IsValid(self) -> bool:
        return bool(self._found)

    __bool__ = IsValid

    def GetName(self) -> str:
        return self._name

    def Get(self) -> Any:
        found = self._found
        return found.get() if found else None

    def Set(self, value: Any) -> bool:
        self._found.set(value)
        return True


class _Stage:
    @staticmethod
    def Attach(stage_id: int) -> _Stage:
        return _Stage()

    def GetPrimAtPath(self, path: Any) -> _Prim:
        return _Prim(app().stage.GetPrimAtPath(str(path)))

    def Traverse(self) -> Any:
        return (_Prim(one) for one in app().stage.Traverse())

    def GetPrimsWithTypeName(self, type_name: str) -> list[Any]:
        return [one.GetPath() for one in app().stage.Traverse() if one.GetTypeName() == type_name]

    def GetPrimsWithAppliedAPIName(self, api_name: str) -> list[Any]:
        return [one.GetPath() for one in app().stage.Traverse() if api_name in one.GetAppliedSchemas()]

    def SynchronizeToFabric(self, *_: Any) -> None:
        return None


class Usd:
    Prim, Attribute, Stage = _Prim, _Attribute, _Stage


class _Xformable:
    def __init__(self, prim: _Prim) -> None:
        self._prim = prim

    def GetFabricHierarchyWorldMatrixAttr(self) -> _Attribute:
        return self._prim.GetAttribute("omni:fabric:worldMatrix")

    def GetFabricHierarchyLocalMatrixAttr(self) -> _Attribute:
        return self._prim.GetAttribute("omni:fabric:localMatrix")


class Rt:
    Xformable = _Xformable


class UsdGeom:
    Tokens = PxrUsdGeom.Tokens
