"""Converts values of stage attributes to and from node values: OGN types, NumPy arrays, quaternions x, y, z, w."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from graph.values.coercion import dtype_of
from graph.values.types import TYPES, Type

_PATTERNS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], str]], ...] = (
    (re.compile(r"(point|vector|normal|color|texCoord)([234])([hfd])"), lambda m: f"{m[1].lower()}{m[3]}[{m[2]}]"),
    (re.compile(r"quat([hfd])"), lambda m: f"quat{m[1]}[4]"),
    (re.compile(r"matrix([234])d"), lambda m: f"matrixd[{m[1]}]"),
    (re.compile(r"(int|half|float|double)([234])"), lambda m: f"{m[1]}[{m[2]}]"),
)
_NAMES = {"frame4d": "frame[4]", "asset": "token"}


def attribute_type(attribute: Any) -> Type | None:
    """The OGN type of a stage attribute; None if OGN has no such type."""
    type_name = attribute.GetTypeName()
    element = str(type_name.scalarType)
    name = _NAMES.get(element, element)
    for pattern, naming in _PATTERNS:
        match = pattern.fullmatch(element)
        if match:
            name = naming(match)
    return TYPES.get(f"{name}[]" if type_name.isArray else name)


def read(value: Any, type_: Type) -> Any:
    """The node value of a USD value of an attribute of this type."""
    import numpy as np

    if type_.array:
        return [str(getattr(one, "path", one)) for one in value] if type_.storage == "token" else np.array(value)
    if type_.role == "quat":
        return np.array([*value.GetImaginary(), value.GetReal()], dtype_of(type_))
    if type_.count > 1:
        return np.array(value, dtype_of(type_))
    if type_.role == "timecode":
        return float(value.GetValue() if hasattr(value, "GetValue") else value)
    return str(getattr(value, "path", value)) if type_.storage in ("token", "string") else value


def written(value: Any, type_: Type, attribute: Any) -> Any:
    """The USD value, for the attribute, of a node's value of this type."""
    import numpy as np

    type_name = attribute.GetTypeName()
    kind = type(type_name.defaultValue)
    if type_.array:
        return kind(list(value)) if type_.storage == "token" else kind.FromNumpy(np.array(value, dtype_of(type_)))
    if type_.role == "quat":
        x, y, z, w = map(float, value)
        return kind(w, x, y, z)
    if type_.square:
        return kind(np.asarray(value, float).tolist())
    if type_.count > 1:
        number = int if type_.storage == "int" else float
        return kind(*map(number, value))
    return kind(value)
