"""`isaacsim.core.experimental.utils.foundation`: names of the types of attributes."""

from __future__ import annotations

from typing import Any

from graph.sim.usd import Sdf

from . import usdrt
from .stage import asks_fabric

__all__ = ["get_value_type_names", "resolve_value_type_name", "value_type_name_to_str"]


def _names() -> list[str]:
    return sorted({str(one) for one in vars(usdrt.Sdf.ValueTypeNames).values() if isinstance(one, usdrt.ValueTypeName)})


def get_value_type_names(*, format: Any = str) -> list[Any]:
    if format is str:
        return _names()
    if format not in (Sdf.ValueTypeNames, usdrt.Sdf.ValueTypeNames):
        raise ValueError(f"the format is str, Sdf.ValueTypeNames or usdrt.Sdf.ValueTypeNames, not {format!r}")
    make = Sdf.ValueTypeNames.Find if format is Sdf.ValueTypeNames else usdrt.ValueTypeName
    return [make(one) for one in _names()]


def resolve_value_type_name(type_name: Any, *, backend: str | None = None) -> Any:
    name = value_type_name_to_str(type_name)
    return usdrt.ValueTypeName(name) if asks_fabric(backend) else Sdf.ValueTypeNames.Find(name)


def value_type_name_to_str(type_name: Any) -> str:
    """The name as USD writes it: "color3f[]". Raises ValueError for a type that Fabric does not hold, or none."""
    name = str(Sdf.ValueTypeNames.Find(str(type_name)))
    if name not in _names():
        raise ValueError(f"{str(type_name)!r} is not the name of a type")
    return name
