"""`pxr.PhysxSchema`: API objects over attributes, whose names follow from the schema's."""

from __future__ import annotations

import re
from typing import Any

from graph.sim.usd import Sdf, Usd

from .own_schemas import OwnSchema, applied, take_own_schemas

_PREFIXES = {
    "PhysxSceneAPI": "physxScene",
    "PhysxRigidBodyAPI": "physxRigidBody",
    "PhysxCollisionAPI": "physxCollision",
    "PhysxArticulationAPI": "physxArticulation",
    "PhysxJointAPI": "physxJoint",
    "PhysxMaterialAPI": "physxMaterial",
    "PhysxContactReportAPI": "physxContactReport",
    "PhysxTriggerAPI": "physxTrigger",
    "PhysxTriggerStateAPI": "physxTrigger",
    "PhysxForceAPI": "physxForce",
    "PhysxSurfaceVelocityAPI": "physxSurfaceVelocity",
    "PhysxConvexHullCollisionAPI": "physxConvexHullCollision",
    "PhysxConvexDecompositionCollisionAPI": "physxConvexDecompositionCollision",
    "PhysxTriangleMeshCollisionAPI": "physxTriangleMeshCollision",
    "PhysxSDFMeshCollisionAPI": "physxSDFMeshCollision",
    "PhysxCookedDataAPI": "physxCookedData",
    "PhysxDeformableBodyAPI": "physxDeformable",
    "PhysxCharacterControllerAPI": "physxCharacterController",
    "PhysxVehicleAPI": "physxVehicle",
    "PhysxMimicJointAPI": "physxMimicJoint",
    "PhysxLimitAPI": "physxLimit",
    "JointStateAPI": "state",
}
__all__ = [*_PREFIXES, "Tokens"]  # noqa: PLE0604
_KINDS = {bool: "bool", int: "int", float: "float", str: "token"}


DEFAULTS: dict[str, Any] = {
    "physxScene:timeStepsPerSecond": 60,
    "physxScene:enableCCD": False,
    "physxScene:enableStabilization": False,
    "physxScene:enableGPUDynamics": True,
    "physxScene:broadphaseType": "GPU",
    "physxScene:solverType": "TGS",
    "physxScene:bounceThreshold": 0.2,
    "physxRigidBody:disableGravity": False,
    "physxRigidBody:linearDamping": 0.0,
    "physxRigidBody:angularDamping": 0.05,
    "physxRigidBody:enableCCD": False,
    "physxRigidBody:solverPositionIterationCount": 4,
    "physxRigidBody:solverVelocityIterationCount": 1,
    "physxArticulation:enabledSelfCollisions": True,
    "physxArticulation:solverPositionIterationCount": 4,
    "physxArticulation:solverVelocityIterationCount": 1,
    "physxJoint:armature": 0.0,
    "physxJoint:jointFriction": 0.0,
    "physxContactReport:threshold": 1.0,
}
"""What attributes of these schemas read as while nothing has set them."""


class Tokens:
    linear, angular = "linear", "angular"


def _type_of(value: Any) -> Any:
    if isinstance(value, (bool, int, float, str, type(None))):
        return Sdf.ValueTypeNames.Find(_KINDS.get(type(value), "float"))
    return Sdf.GetValueTypeNameForValue(value)


class Unset:
    """An attribute of an applied schema that nothing has authored: it reads as its default, and can be set."""

    def __init__(self, prim: Any, name: str) -> None:
        self._prim, self._name = prim, name

    def IsValid(self) -> bool:
        return bool(self._prim)

    __bool__ = IsValid

    def Get(self, *_: Any) -> Any:
        found = self._prim.GetAttribute(self._name)
        return found.Get() if found else DEFAULTS.get(self._name)

    def Set(self, value: Any, *_: Any) -> bool:
        made = self._prim.GetAttribute(self._name) or self._prim.CreateAttribute(self._name, _type_of(value), False)
        return bool(made.Set(value))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._prim.GetAttribute(self._name), name)


class _Api(OwnSchema):
    """An applied schema of a prim: `Create...Attr(value)`, `Get...Attr()`, `Get...Rel()`."""

    prefix = ""

    def __init__(self, prim: Any = None, instance: str = "") -> None:
        self._prim = prim.GetPrim() if hasattr(prim, "GetPrim") else prim
        self._instance = instance

    @classmethod
    def Apply(cls, prim: Any, instance: str = "") -> _Api:
        prim.AddAppliedSchema(f"{cls.name}:{instance}" if instance else cls.name)
        return cls(prim, instance)

    @classmethod
    def Get(cls, stage: Any, path: Any) -> _Api:
        """Of the prim at a path of a stage; or of a prim, with the name of the instance."""
        return cls(stage.GetPrimAtPath(path)) if isinstance(stage, Usd.Stage) else cls(stage, str(path))

    @classmethod
    def CanApply(cls, prim: Any, *_: Any) -> bool:
        return bool(prim)

    def GetPrim(self) -> Any:
        return self._prim

    def GetPath(self) -> Any:
        return self._prim.GetPath()

    def __bool__(self) -> bool:
        return any(one == self.name or one.startswith(f"{self.name}:") for one in applied(self._prim))

    def _full(self, words: str) -> str:
        short = words[0].lower() + words[1:]
        if self.name == "JointStateAPI":
            return f"state:{self._instance or 'angular'}:physics:{short}"
        for name in (f"{self.prefix}:{self._instance}:{short}" if self._instance else "", f"{self.prefix}:{short}"):
            if name and self._prim.HasProperty(name):
                return name
        upper = re.sub(r"^([a-z]+)([A-Z]{2,})", lambda m: m[1] + m[2], words[0].lower() + words[1:])
        return f"{self.prefix}:{self._instance}:{upper}" if self._instance else f"{self.prefix}:{upper}"

    def __getattr__(self, name: str) -> Any:
        found = re.fullmatch(r"(Get|Create)(\w+?)(Attr|Rel)", name)
        if found is None:
            raise AttributeError(f"{self.name} has no {name}")
        what, words, kind = found.groups()
        full = self._full(words)
        if kind == "Rel":
            return lambda: self._prim.GetRelationship(full) or self._prim.CreateRelationship(full, False)
        if what == "Get":
            return lambda: self._prim.GetAttribute(full) or Unset(self._prim, full)

        def create(value: Any = None, *_: Any) -> Any:
            made = self._prim.GetAttribute(full) or Unset(self._prim, full)  # its type follows from its first value
            if value is not None:
                made.Set(value)
            return made

        return create


for _name, _prefix in _PREFIXES.items():
    globals()[_name] = type(_name, (_Api,), {"name": _name, "prefix": _prefix, "__module__": "pxr.PhysxSchema"})
take_own_schemas()
