"""ROS 2 message classes, their CDR bytes and their definitions, from rosbags' type store (Humble).

Types that the store does not have come from `ros_definitions`: a few shipped interfaces, then the installed ROS 2
packages, then the definitions in a recording (`register`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: TID253
from rosbags.typesys.base import TypesysError, normalize_fieldname  # noqa: TID253

from graph.base.errors import reason_of
from graph.base.limits import check

from .ros_definitions import installed, shipped

_STORE = get_typestore(Stores.ROS2_HUMBLE)
_TYPE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*/(?:msg|srv)/[A-Za-z][A-Za-z0-9_]*")
_DEEPEST = 100
"""Most types nested in one another in a definition."""
_FIELD_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def message_type(name: str) -> type[Any]:
    """The dataclass of a message type such as "sensor_msgs/msg/PointCloud2". Raises KeyError for an unknown type."""
    if not known(name):
        raise KeyError(name)
    return _STORE.types[name]


def known(name: str) -> bool:
    """Whether a message type is known, with all the types that it consists of."""
    if name not in _STORE.types:
        parts = installed(name) if name.count("/") == 2 else []
        if not parts:
            return False
        for part, text in parts:
            register(part, text)
    return True


def type_names() -> list[str]:
    """All message types known so far, sorted."""
    return sorted(_STORE.types)


def register(name: str, text: str) -> None:
    """Adds the message type `name` by its definition; further types may follow in it after a line of ===.

    Existing types stay. Raises ValueError for a text that is not a definition or needs an unknown type.
    """
    if name in _STORE.types:
        return
    if not _TYPE_NAME.fullmatch(name):
        raise ValueError(f"{name!r:.80} is not a type name; one reads package/msg/Name")
    package, kind, stem = name.split("/")
    # The parser puts every type below msg; services keep their srv.
    alias = f"{package}/msg/{stem}"
    try:
        parsed = get_types_from_msg(text, alias)
    except Exception as error:
        raise ValueError(f"{name}: no message definition: {reason_of(error)}") from None
    found = {name if part == alias and kind != "msg" else part: fields for part, (_, fields) in parsed.items()}
    fresh = {part: fields for part, fields in found.items() if part not in _STORE.types}
    for part, fields in fresh.items():
        _check(part, fields, fresh)
    _check_sizes(name, fresh)
    # Without constants: they are not used, and the store makes Python code of its input.
    try:
        _STORE.register({part: ([], fields) for part, fields in fresh.items()})
    except TypesysError as error:
        raise ValueError(f"{name}: {error}") from None


def _check(part: str, fields: Any, fresh: Any) -> None:
    """Rejects invalid names, unknown and recursive types, so that code can be made from the rest safely."""
    if not _TYPE_NAME.fullmatch(part):
        raise ValueError(f"{part!r:.80} is not a type name")
    for field, content in fields:
        if not _FIELD_NAME.fullmatch(field):
            raise ValueError(f"{part}: {field!r:.80} is not a field name")
        for inner in _named_types(content):
            if inner not in fresh and not known(inner):
                raise ValueError(f"{part}: field {field} is of the unknown type {inner}")


def _check_sizes(name: str, fresh: Any) -> None:
    """Rejects types that are recursive, too deep or too large; each type is examined once."""
    inside = {part: {one for _, content in fresh[part] for one in _named_types(content)} & set(fresh) for part in fresh}
    sizes: dict[str, tuple[int, int]] = {}
    try:
        for part in TopologicalSorter(inside).static_order():
            values, depth = sizes[part] = _size(fresh[part], sizes)
            check("recording.type", values, f"{name}: {part} holds {values:,} values")
            if depth > _DEEPEST:
                raise ValueError(f"{name}: {part} is made of types within types, {depth} deep; {_DEEPEST} are read")
    except CycleError as error:
        part, ring = error.args[1][0], set(error.args[1])
        field = next(field for field, content in fresh[part] if not ring.isdisjoint(_named_types(content)))
        raise ValueError(f"{part}: field {field} makes the type hold itself") from None


def _size(content_of: Any, known_sizes: Mapping[str, tuple[int, int]]) -> tuple[int, int]:
    """The least number of values of a type (fixed lists count, growing lists do not), and its depth."""
    total = depth = 0
    for _, content in content_of:
        kind, inner = content
        count = 1
        if kind in (3, 4):
            (kind, inner), length = inner
            count = length if content[0] == 3 else 0
        if kind == 2:
            values, below = known_sizes[inner] if inner in known_sizes else _known_size(inner)
            total, depth = total + count * values, max(depth, below)
        else:
            total += count
    return total, depth + 1


@cache
def _known_size(name: str) -> tuple[int, int]:
    return _size(fields(name), {})


@cache
def least_part(name: str) -> int:
    """Bytes of the smallest text or message in lists of a message of a known type, at any depth; 0: no such lists."""
    found = []
    for _, (kind, inner) in fields(name):
        if kind in (3, 4):
            kind, inner = inner[0]
            if kind == 2 or inner[0] == "string":
                found.append(_least_bytes(kind, inner))
        if kind == 2 and (below := least_part(inner)):
            found.append(below)
    return min(found, default=0)


@cache
def _least_bytes(kind: int, inner: Any) -> int:
    """The least bytes of a value in CDR, without alignment."""
    if kind == 1:
        return 5 if inner[0] == "string" else int(inner[0].lstrip("abcdefghijklmnopqrstuvwxyz") or 8) // 8
    if kind == 2:
        return max(1, sum(_least_bytes(*content) for _, content in fields(inner)))
    (kind, inner), length = inner
    return length * _least_bytes(kind, inner) if kind == 3 else 4


def fields(name: str) -> list[tuple[str, Any]]:
    """(field, description) of a type as rosbags describes it: (kind, content), kind 1 base, 2 named, 3 and 4 lists.

    Raises KeyError for an unknown type.
    """
    if not known(name):
        raise KeyError(name)
    return list(_STORE.fielddefs[name][1])


def attribute(field: str) -> str:
    """The name of a field as an attribute of its class: a Python keyword gets an underscore."""
    return normalize_fieldname(field)


def _named_types(content: Any) -> list[str]:
    kind, inner = content
    if kind == 2:
        return [inner]
    return _named_types(inner[0]) if kind in (3, 4) else []


def serialize(message: Any, type_name: str) -> bytes:
    """The message as little-endian CDR."""
    return bytes(_STORE.serialize_cdr(message, type_name))


def deserialize(data: bytes, type_name: str) -> Any:
    """The message in little- or big-endian CDR `data`."""
    return _STORE.deserialize_cdr(data, type_name)


@cache
def definition(type_name: str) -> str:
    """The type's definition with those it depends on, in the "ros2msg" schema encoding."""
    return _STORE.generate_msgdef(type_name, ros_version=2)[0]


@cache
def type_hash(type_name: str) -> str:
    """The type's hash, "RIHS01_" and 64 digits (REP-2011). Raises ValueError for types with wide texts."""
    try:
        return _STORE.hash_rihs01(type_name)
    except KeyError as error:
        raise ValueError(f"{type_name}: {error} cannot be part of a type hash") from None


for _name, _text in shipped():
    register(_name, _text)
