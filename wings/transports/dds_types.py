"""ROS 2 message types as IDL structs of Cyclone DDS's Python package, with the names that rmw_cyclonedds gives them."""

from __future__ import annotations

from functools import cache
from typing import Any

from graph.sim.messages.ros_types import fields

_BASE, _NAME, _ARRAY, _SEQUENCE = 1, 2, 3, 4
_NUMBERS = {"bool": "bool", "byte": "uint8", "char": "uint8", "octet": "uint8"}


def dds_name(type_name: str) -> str:
    """The DDS name of a ROS 2 type: "pkg/msg/Name" is "pkg::msg::dds_::Name_"."""
    package, kind, name = type_name.split("/")
    return f"{package}::{kind}::dds_::{name}_"


class CdrBytes(bytes):
    """A message as it came; Cyclone DDS adds `sample_info`."""


@cache
def dds_type(type_name: str) -> Any:
    """The IDL struct of a ROS 2 message type, whose samples are read as `CdrBytes`.

    Raises ValueError for types with wide texts, which the package does not have.
    """
    made = _struct(type_name)
    made.deserialize = staticmethod(CdrBytes)
    return made


@cache
def _struct(type_name: str) -> Any:
    from cyclonedds.idl import make_idl_struct

    members = {name: _member(type_name, kind, content) for name, (kind, content) in fields(type_name)}
    name = dds_name(type_name)
    return make_idl_struct(name.rpartition("::")[2], name.replace("::", "."), members)


def _member(type_name: str, kind: int, content: Any) -> Any:
    from cyclonedds.idl import types

    if kind == _NAME:
        return _struct(content)
    if kind == _BASE:
        base, bound = content
        if base == "string":
            return types.bounded_str[bound] if bound else str
        if base == "wstring":
            raise ValueError(f"{type_name} has wide texts (wstring), which Cyclone DDS's Python package cannot send")
        name = _NUMBERS.get(base, base)
        return bool if name == "bool" else getattr(types, name)
    (inner_kind, inner), length = content
    item = _member(type_name, inner_kind, inner)
    if kind == _ARRAY:
        return types.array[item, length]
    return types.sequence[item, length] if length else types.sequence[item]
