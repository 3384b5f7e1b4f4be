"""`omni.isaac.IsaacSensorSchema`: the prims of sensors, as typed schemas."""

from __future__ import annotations

import re
from typing import Any

from graph.sim.usd import Sdf

_SCHEMAS: dict[str, dict[str, tuple[str, Any]]] = {
    "IsaacBaseSensor": {"enabled": ("bool", True)},
    "IsaacContactSensor": {"threshold": ("float2", (0.0, 100000.0)), "radius": ("float", -1.0)},
    "IsaacImuSensor": {
        "linearAccelerationFilterWidth": ("uint", 1),
        "angularVelocityFilterWidth": ("uint", 1),
        "orientationFilterWidth": ("uint", 1),
    },
    "IsaacLightBeamSensor": {"numRays": ("int", 5), "curtainLength": ("float", 0.0), "forwardAxis": ("float3", None)},
    "IsaacRaycastSensor": {
        "minRange": ("float", 0.4),
        "maxRange": ("float", 100.0),
        "numRays": ("uint", 0),
        "rayOrigins": ("float3[]", None),
        "rayDirections": ("float3[]", None),
        "rayTimeOffsets": ("float[]", None),
        "outputFrameOfReference": ("token", "SENSOR"),
        "reportHitPrimPaths": ("bool", False),
    },
}
__all__ = [*_SCHEMAS]  # noqa: PLE0604


class _Schema:
    name = ""

    def __init__(self, prim: Any = None) -> None:
        self._prim = prim.GetPrim() if hasattr(prim, "GetPrim") else prim

    @classmethod
    def Define(cls, stage: Any, path: Any) -> Any:
        return cls(stage.DefinePrim(path, cls.name))

    @classmethod
    def Get(cls, stage: Any, path: Any) -> Any:
        return cls(stage.GetPrimAtPath(path))

    def GetPrim(self) -> Any:
        return self._prim

    def GetPath(self) -> Any:
        return self._prim.GetPath()

    def __bool__(self) -> bool:
        kind = str(self._prim.GetTypeName()) if self._prim else ""
        return kind == self.name or (self.name == "IsaacBaseSensor" and kind in _SCHEMAS)

    def __getattr__(self, name: str) -> Any:
        found = re.fullmatch(r"(Get|Create)(\w+)Attr", name)
        words = "" if found is None else found[2][0].lower() + found[2][1:]
        known = {**_SCHEMAS["IsaacBaseSensor"], **_SCHEMAS[self.name]}
        if found is None or words not in known:
            raise AttributeError(f"{self.name} has no {name}")
        kind, default = known[words]

        def attribute(value: Any = None, *_: Any) -> Any:
            made = self._prim.GetAttribute(words)
            if not made:
                made = self._prim.CreateAttribute(words, Sdf.ValueTypeNames.Find(kind), custom=False)
                value = default if value is None else value
            if value is not None:
                made.Set(value)
            return made

        return attribute


for _name in _SCHEMAS:
    globals()[_name] = type(_name, (_Schema,), {"name": _name, "__module__": "omni.isaac.IsaacSensorSchema"})
