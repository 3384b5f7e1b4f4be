"""`omni.isaac.IsaacSensorSchema` and `RangeSensorSchema`: the prims of sensors, as typed schemas."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

from .own_schemas import OwnSchema, applied, take_own_schemas


class _Schema:
    """A prim, with `GetXAttr` and `CreateXAttr` for each attribute of its schema."""

    kinds: tuple[str, ...] = ()
    """The types of prims that it stands for; it defines the last one."""

    def __init__(self, prim: Any = None) -> None:
        self._prim = prim.GetPrim() if hasattr(prim, "GetPrim") else prim

    @classmethod
    def Define(cls, stage: Any, path: Any) -> Any:
        return cls(stage.DefinePrim(path, cls.kinds[-1]))

    @classmethod
    def Get(cls, stage: Any, path: Any) -> Any:
        return cls(stage.GetPrimAtPath(path))

    def GetPrim(self) -> Any:
        return self._prim

    def GetPath(self) -> Any:
        return self._prim.GetPath()

    def __bool__(self) -> bool:
        return bool(self._prim) and str(self._prim.GetTypeName()) in self.kinds

    def __getattr__(self, name: str) -> Any:
        found = re.fullmatch(r"(Get|Create)(\w)(\w*)Attr", name)
        attribute = found and self._prim.GetAttribute(found[2].lower() + found[3])
        if found is None and not name.startswith("__"):
            return getattr(self._prim, name)
        if not attribute:
            raise AttributeError(f"{type(self).__name__} has no {name}")

        def call(value: Any = None, *_: Any) -> Any:
            if value is not None:
                attribute.Set(value)
            return attribute

        return call


def _schemas(base: str, *kinds: str) -> dict[str, Any]:
    """A class for each type of prim, and one for all of them."""
    stands_for = {base: (*kinds, base), **{kind: (kind,) for kind in kinds}}
    return {name: type(name, (_Schema,), {"kinds": types}) for name, types in stands_for.items()}


class _Api(OwnSchema):
    """An API schema without attributes."""

    def __init__(self, prim: Any = None) -> None:
        self._prim = prim

    @classmethod
    def Apply(cls, prim: Any) -> Any:
        prim.AddAppliedSchema(cls.name)
        return cls(prim)

    def GetPrim(self) -> Any:
        return self._prim

    def __bool__(self) -> bool:
        return self.name in applied(self._prim)


take_own_schemas()
IsaacSensorSchema = SimpleNamespace(
    **_schemas(
        *("IsaacBaseSensor", "IsaacContactSensor", "IsaacImuSensor", "IsaacLightBeamSensor", "IsaacRaycastSensor")
    ),
    **{name: type(name, (_Api,), {"name": name}) for name in ("IsaacRtxLidarSensorAPI", "IsaacRtxRadarSensorAPI")},
)
RangeSensorSchema = SimpleNamespace(**_schemas("RangeSensor", "Generic", "Lidar"))
