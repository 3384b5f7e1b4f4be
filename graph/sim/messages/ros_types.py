"""ROS 2 message classes, their CDR bytes and their definitions, from rosbags' type store (Humble).

What the store lacks comes from `ros_definitions`: a few shipped interfaces, then the installed ROS 2 packages, then
what a recording brings along (`register`).
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: TID253
from rosbags.typesys.base import TypesysError, normalize_fieldname  # noqa: TID253

from .ros_definitions import installed, shipped

_STORE = get_typestore(Stores.ROS2_HUMBLE)
_TYPE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*/(?:msg|srv)/[A-Za-z][A-Za-z0-9_]*")
_MOST_VALUES = 1_000_000
_FIELD_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def message_type(name: str) -> type[Any]:
    """The dataclass of a message type such as "sensor_msgs/msg/PointCloud2". Raises KeyError if there is none."""
    if not known(name):
        raise KeyError(name)
    return _STORE.types[name]


def known(name: str) -> bool:
    """Whether there is such a message type, all the types that it is made of included."""
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

    Types that are there already stay. Raises ValueError for a text that is no definition or needs an unknown type.
    """
    if name in _STORE.types:
        return
    if not _TYPE_NAME.fullmatch(name):
        raise ValueError(f"{name!r:.80} is no type name; one reads package/msg/Name")
    package, kind, stem = name.split("/")
    # The parser puts every type below msg; services keep their srv.
    alias = f"{package}/msg/{stem}"
    try:
        parsed = get_types_from_msg(text, alias)
    except Exception as error:
        reason = " ".join(str(error).split())[:120]
        raise ValueError(f"{name}: no message definition: {reason}") from None
    found = {name if part == alias and kind != "msg" else part: fields for part, (_, fields) in parsed.items()}
    fresh = {part: fields for part, fields in found.items() if part not in _STORE.types}
    for part, fields in fresh.items():
        _check(part, fields, fresh)
    if _size(name, fresh) > _MOST_VALUES:
        raise ValueError(f"{name}: its fixed lists hold more than {_MOST_VALUES} values")
    # Without constants: nobody reads them, and the store makes Python code of what it is given.
    try:
        _STORE.register({part: ([], fields) for part, fields in fresh.items()})
    except TypesysError as error:
        raise ValueError(f"{name}: {error}") from None


def _check(part: str, fields: Any, fresh: Any) -> None:
    """Refuses names that are none, unknown types, types that hold themselves; what is left is safe to make code of."""
    if not _TYPE_NAME.fullmatch(part):
        raise ValueError(f"{part!r:.80} is no type name")
    for field, content in fields:
        if not _FIELD_NAME.fullmatch(field):
            raise ValueError(f"{part}: {field!r:.80} is no field name")
        for inner in _named_types(content):
            if inner not in fresh and not known(inner):
                raise ValueError(f"{part}: field {field} is of the unknown type {inner}")
            if _reaches(inner, part, fresh):
                raise ValueError(f"{part}: field {field} makes the type hold itself")


def _reaches(start: str, target: str, fresh: Any) -> bool:
    """Whether a type is or holds another, among the fresh ones."""
    seen: set[str] = set()
    stack = [start]
    while stack:
        name = stack.pop()
        if name == target:
            return True
        if name not in seen:
            seen.add(name)
            stack += (inner for _, content in fresh.get(name, ()) for inner in _named_types(content))
    return False


def _size(name: str, fresh: Any) -> int:
    """How many values a message has at least: those of its fixed lists count, growing lists do not."""
    total = 0
    for _, content in fresh[name] if name in fresh else fields(name):
        kind, inner = content
        count = 1
        if kind in (3, 4):
            (kind, inner), length = inner
            count = length if content[0] == 3 else 0
        total += count * (_size(inner, fresh) if kind == 2 else 1)
    return total


def fields(name: str) -> list[tuple[str, Any]]:
    """(field, description) of a type as rosbags describes it: (kind, content), kind 1 base, 2 named, 3 and 4 lists.

    Raises KeyError if there is no such type.
    """
    if not known(name):
        raise KeyError(name)
    return list(_STORE.fielddefs[name][1])


def attribute(field: str) -> str:
    """What a field is called as an attribute of its class: a Python keyword gets an underscore."""
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
    """The message that little- or big-endian CDR `data` holds."""
    return _STORE.deserialize_cdr(data, type_name)


@cache
def definition(type_name: str) -> str:
    """The type's definition with those it depends on, as the "ros2msg" schema encoding wants it."""
    return _STORE.generate_msgdef(type_name, ros_version=2)[0]


for _name, _text in shipped():
    register(_name, _text)
