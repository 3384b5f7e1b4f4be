"""`usdrt`: paths, and the stage with Fabric's values."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.isaac.session import app
from graph.sim.usd import Gf as PxrGf
from graph.sim.usd import Sdf as PxrSdf
from graph.sim.usd import UsdGeom as PxrUsdGeom
from graph.sim.usd import Vt as PxrVt

__all__ = ["Gf", "Rt", "Sdf", "Usd", "UsdGeom", "Vt"]
Gf, Vt = PxrGf, PxrVt
_MOTION = ("physics:velocity", "physics:angularVelocity")
"""Attributes of bodies that move while physics plays."""


class ValueTypeName:
    """The type of an attribute."""

    def __init__(self, name: str) -> None:
        self._name = name

    def GetAsToken(self) -> str:
        return self._name

    GetAsString = __str__ = GetAsToken

    def __repr__(self) -> str:
        return f"Sdf.ValueTypeName({self._name!r})"

    def __eq__(self, other: object) -> bool:
        return str(self) == str(other)

    def __hash__(self) -> int:
        return hash(self._name)


def _value_types() -> dict[str, ValueTypeName]:
    held = PxrSdf.ValueTypeNames
    named = {name: getattr(held, name) for name in dir(held) if isinstance(getattr(held, name), PxrSdf.ValueTypeName)}
    lacking = ("group", "opaque", "pathExpression")  # Fabric does not hold these
    return {name: ValueTypeName(str(one)) for name, one in named.items() if str(one).removesuffix("[]") not in lacking}


class Sdf:
    Path = PxrSdf.Path
    AssetPath = PxrSdf.AssetPath
    ValueTypeName = ValueTypeName
    ValueTypeNames = type("ValueTypeNames", (), _value_types())


class _Prim:
    """A prim of the stage; transforms and values that only Fabric has come from there."""

    def __init__(self, prim: Any, path: str = "") -> None:
        self._prim, self._path = prim, path or str(prim.GetPath())

    def __bool__(self) -> bool:
        return bool(self._prim) or bool(app().fabric.get_prim_at_path(self._path))

    IsValid = __bool__

    def GetPath(self) -> Any:
        return PxrSdf.Path(self._path)

    def GetName(self) -> str:
        return self._path.rpartition("/")[2]

    def GetTypeName(self) -> str:
        return str(self._prim.GetTypeName())

    def HasAttribute(self, name: str) -> bool:
        return bool(self.GetAttribute(name).IsValid())

    def GetAttribute(self, name: str) -> _Attribute:
        return _Attribute(self._path, name)

    def GetAttributes(self) -> list[_Attribute]:
        return [_Attribute(self._path, one.GetName()) for one in self._prim.GetAttributes()]

    def CreateAttribute(self, name: str, type_name: Any, custom: bool = True) -> _Attribute:
        self._prim.CreateAttribute(name, PxrSdf.ValueTypeNames.Find(str(type_name)), custom)
        return _Attribute(self._path, name)

    def GetParent(self) -> _Prim:
        return _Prim(self._prim.GetParent())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Prim) and bool(self._prim == other._prim)

    def __hash__(self) -> int:
        return hash(self._prim)

    def GetRelationship(self, name: str) -> Any:
        return self._prim.GetRelationship(name)

    def GetChildren(self) -> list[_Prim]:
        return [_Prim(one) for one in self._prim.GetChildren()]


class _Attribute:
    def __init__(self, path: str, name: str) -> None:
        self._path, self._name = path, name

    @property
    def _found(self) -> Any:
        return app().fabric.get_prim_at_path(self._path).get_attribute(self._name)

    def IsValid(self) -> bool:
        return bool(self._found)

    __bool__ = IsValid

    def GetName(self) -> str:
        return self._name

    def Get(self) -> Any:
        physics = app().physics if self._name in _MOTION else None
        if physics is not None and self._path in physics.body_paths:
            return self._motion()
        found = self._found
        try:
            return found.get() if found else None
        except RunError:  # it is declared, and has no value
            return None

    def _motion(self) -> Any:
        """The velocity that physics gives the body now, along the world's axes."""
        motion = app().fabric.velocities((self._path,))[0]
        if self._name == _MOTION[0]:
            return PxrGf.Vec3f(*map(float, motion[:3] / app().meters_per_unit))
        return PxrGf.Vec3f(*map(float, np.degrees(motion[3:])))

    def Set(self, value: Any) -> bool:
        self._found.set(value)
        return True


class _Stage:
    @staticmethod
    def Attach(stage_id: int) -> _Stage:
        return _Stage()

    def GetPrimAtPath(self, path: Any) -> _Prim:
        return _Prim(app().stage.GetPrimAtPath(str(path)), str(path))

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


class _Schema:
    """A schema over a prim; only its prim is asked for."""

    def __init__(self, prim: _Prim) -> None:
        self._prim = prim

    def GetPrim(self) -> _Prim:
        return self._prim

    def GetPath(self) -> Any:
        return self._prim.GetPath()


_SHAPES = ["Camera", "Capsule", "Cone", "Cube", "Cylinder", "Mesh", "Plane", "Points", "Sphere", "Xform", "Xformable"]


class UsdGeom:
    Tokens = PxrUsdGeom.Tokens
    Camera, Capsule, Cone, Cube, Cylinder = (type(one, (_Schema,), {}) for one in _SHAPES[:5])
    Mesh, Plane, Points, Sphere, Xform, Xformable = (type(one, (_Schema,), {}) for one in _SHAPES[5:])
