"""ROS 2 messages as flat fields and as plain data, for any message type.

A field inside a field has its path as name, joined with ":" (`header:stamp:sec`, as OmniGraph's bridge names it).
Lists of messages are texts: one JSON object for each message.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from graph.base.records import dataclass

from .ros_types import attribute, fields, message_type

_BASE, _NAME, _ARRAY, _SEQUENCE = 1, 2, 3, 4
_FILLER = "structure_needs_at_least_one_member"

NUMBERS = {
    "bool": ("bool", np.bool_),
    "byte": ("uchar", np.uint8),
    "char": ("uchar", np.uint8),
    "uint8": ("uchar", np.uint8),
    "int8": ("int", np.int8),
    "int16": ("int", np.int16),
    "uint16": ("uint", np.uint16),
    "int32": ("int", np.int32),
    "uint32": ("uint", np.uint32),
    "int64": ("int64", np.int64),
    "uint64": ("uint64", np.uint64),
    "float32": ("float", np.float32),
    "float64": ("double", np.float64),
}
"""Primitive of a message definition -> (OmniGraph type, numpy type)."""


@dataclass(frozen=True, slots=True)
class Leaf:
    """One field of a flattened message: its name, its OmniGraph type, and the conversions between field and value.

    to_field raises ValueError for a value that the field cannot hold.
    """

    name: str
    type: str
    to_field: Callable[[Any], Any]
    to_value: Callable[[Any], Any]


@cache
def leaves(type_name: str) -> tuple[Leaf, ...]:
    """The fields of a message type, those of inner messages in place, in order. Raises KeyError for unknown types."""
    found: list[Leaf] = []
    for name, (kind, content) in fields(type_name):
        if kind == _NAME:
            inner = leaves(content)
            found += (Leaf(f"{name}:{leaf.name}", leaf.type, leaf.to_field, leaf.to_value) for leaf in inner)
        elif name != _FILLER:
            found.append(_leaf(name, kind, content))
    return tuple(found)


def pack(type_name: str, values: Sequence[Any]) -> Any:
    """The message whose leaves have these values, in the order of `leaves`.

    Raises ValueError with the name of the field.
    """
    converted = []
    for leaf, value in zip(leaves(type_name), values, strict=True):
        try:
            converted.append(leaf.to_field(value))
        except (ValueError, OverflowError, TypeError) as error:
            raise ValueError(f"field {leaf.name}: {error}") from None
    stream = iter(converted)
    return _assembled(type_name, lambda: next(stream))


def unpack(type_name: str, message: Any) -> list[Any]:
    """The values of a message's leaves, in the order of `leaves`."""
    stream = iter(_contents(type_name, message))
    return [leaf.to_value(next(stream)) for leaf in leaves(type_name)]


def from_plain(type_name: str, data: object, path: str = "") -> Any:
    """The message of plain data (nested mappings by field name); missing fields are zero or empty.

    Raises ValueError with the field's name for a name that the type does not have or a value that does not fit.
    """
    if not isinstance(data, Mapping):
        what = f"field {path.rstrip('.')}" if path else "the message"
        raise ValueError(f"{what} must be a mapping with the fields of {type_name}")
    known = dict(fields(type_name))
    unknown = [name for name in data if name not in known or name == _FILLER]
    if unknown:
        listed = ", ".join(name for name in known if name != _FILLER) or "no fields"
        raise ValueError(f"{type_name} has no field {path}{unknown[0]}; it has {listed}")
    parts = {
        attribute(name): _plain_field(f"{path}{name}", kind, content, data[name])
        if name in data
        else _zero(kind, content)
        for name, (kind, content) in known.items()
    }
    return message_type(type_name)(**parts)


def to_plain(type_name: str, message: Any) -> dict[str, Any]:
    """The message as nested mappings, lists, numbers and texts."""
    return {
        name: _plain(kind, content, getattr(message, attribute(name)))
        for name, (kind, content) in fields(type_name)
        if name != _FILLER
    }


def zero(type_name: str) -> Any:
    """The message with every number 0 and every text and list empty."""
    return from_plain(type_name, {})


def _leaf(name: str, kind: int, content: Any) -> Leaf:
    if kind == _BASE:
        base = content[0]
        if base not in NUMBERS:
            return Leaf(name, "token", str, str)
        ogn, dtype = NUMBERS[base]
        return Leaf(name, ogn, lambda value: _number(value, dtype), _same)
    (inner_kind, inner), length = content
    exact = length if kind == _ARRAY else None
    most = length if kind == _SEQUENCE and length else None
    if inner_kind == _NAME:
        return Leaf(
            name,
            "token[]",
            lambda texts: _sized([_from_json(inner, text) for text in texts], exact, most, lambda: zero(inner)),
            lambda messages: [json.dumps(to_plain(inner, one)) for one in messages],
        )
    base = inner[0]
    if base not in NUMBERS:
        return Leaf(name, "token[]", lambda texts: _sized([str(text) for text in texts], exact, most, str), list)
    ogn, dtype = NUMBERS[base]
    return Leaf(name, f"{ogn}[]", lambda values: _array(values, dtype, exact, most), _same)


def _same(value: Any) -> Any:
    return value


def _number(value: Any, dtype: Any) -> Any:
    if dtype is np.bool_:
        return bool(value)
    if issubclass(dtype, np.integer):
        number, info = int(value), np.iinfo(dtype)
        if number != value:
            raise ValueError(f"{value!r} is not a whole number")
        if not info.min <= number <= info.max:
            raise ValueError(f"{number} does not fit into {np.dtype(dtype).name}")
        return number
    return float(value)


def _array(values: Any, dtype: Any, exact: int | None, most: int | None) -> Any:
    array = np.asarray(values)
    if array.ndim != 1:
        array = array.reshape(-1)
    if issubclass(dtype, np.integer) and array.size:
        info = np.iinfo(dtype)
        if array.dtype.kind not in "iub" or array.min() < info.min or array.max() > info.max:
            raise ValueError(f"the values do not fit into {np.dtype(dtype).name}")
    array = array.astype(dtype)
    if exact is not None and not array.size:
        return np.zeros(exact, dtype)
    _check_length(array.size, exact, most)
    return array


def _sized(items: list[Any], exact: int | None, most: int | None, empty: Callable[[], Any]) -> list[Any]:
    if exact is not None and not items:
        return [empty() for _ in range(exact)]
    _check_length(len(items), exact, most)
    return items


def _check_length(length: int, exact: int | None, most: int | None) -> None:
    if exact is not None and length != exact:
        raise ValueError(f"needs {exact} values, got {length}")
    if most is not None and length > most:
        raise ValueError(f"takes at most {most} values, got {length}")


def _from_json(type_name: str, text: Any) -> Any:
    try:
        data = json.loads(text) if text else {}
    except ValueError as error:
        raise ValueError(f"{text!r:.60} is not JSON ({error})") from None
    return from_plain(type_name, data)


def _assembled(type_name: str, next_field: Callable[[], Any]) -> Any:
    parts = []
    for name, (kind, content) in fields(type_name):
        parts.append(0 if name == _FILLER else _assembled(content, next_field) if kind == _NAME else next_field())
    return message_type(type_name)(*parts)


def _contents(type_name: str, message: Any) -> list[Any]:
    found: list[Any] = []
    for name, (kind, content) in fields(type_name):
        if kind == _NAME:
            found += _contents(content, getattr(message, attribute(name)))
        elif name != _FILLER:
            found.append(getattr(message, attribute(name)))
    return found


def _plain_field(path: str, kind: int, content: Any, value: Any) -> Any:
    if kind == _NAME:
        return from_plain(content, value, f"{path}.")
    if kind != _BASE:
        if isinstance(value, str | bytes) or not hasattr(value, "__len__"):
            raise ValueError(f"field {path}: {value!r:.60} is not a list")
        (inner_kind, inner), length = content
        if inner_kind == _NAME:
            items = [from_plain(inner, one, f"{path}.") for one in value]
            return _sized(items, length if kind == _ARRAY else None, length or None, lambda: zero(inner))
    elif isinstance(value, str) != (content[0] not in NUMBERS) or isinstance(value, list | dict):
        raise ValueError(f"field {path}: {value!r:.60} is not a {content[0]}")
    try:
        return _leaf(path, kind, content).to_field(value)
    except (ValueError, OverflowError, TypeError) as error:
        raise ValueError(f"field {path}: {error}") from None


def _zero(kind: int, content: Any) -> Any:
    if kind == _NAME:
        return zero(content)
    if kind == _BASE:
        return "" if content[0] not in NUMBERS else _number(0, NUMBERS[content[0]][1])
    return _leaf("", kind, content).to_field([])


def _plain(kind: int, content: Any, value: Any) -> Any:
    if kind == _NAME:
        return to_plain(content, value)
    if kind == _BASE:
        return value
    inner_kind, inner = content[0]
    if inner_kind == _NAME:
        return [to_plain(inner, one) for one in value]
    return value.tolist() if isinstance(value, np.ndarray) else list(value)
