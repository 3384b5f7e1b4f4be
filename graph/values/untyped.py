"""Values written without a type, or with an explicit one: the type that an open attribute takes from its value."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .coercion import coerce, dtype_of
from .types import TYPES, Type, concrete_type

_STORAGES = ("bool", "uchar", "int", "uint", "int64", "uint64", "half", "float", "double")


def natural_type(value: Any) -> list[Type]:
    """The types that an untyped value may have, most likely first.

    An unconnected open attribute takes the first that fits.
    """
    if hasattr(value, "tolist") and hasattr(value, "dtype"):
        own = next((s for s in _STORAGES if dtype_of(TYPES[s]) == value.dtype), None)
        if own is not None and value.ndim == 0:
            return [TYPES[own], *natural_type(value.tolist())]
        value = value.tolist()
        return _sequence_types(value, own)
    if isinstance(value, bool):
        return [TYPES["bool"]]
    if isinstance(value, int):
        return [TYPES[name] for name in ("int", "int64", "uint64", "uint", "uchar", "double", "float", "half")]
    if isinstance(value, float):
        return [TYPES[name] for name in ("double", "float", "half")]
    if isinstance(value, str):
        return [TYPES[name] for name in ("token", "string", "path")]
    if isinstance(value, (list, tuple)):
        return _sequence_types(list(value), None)
    return []


def _sequence_types(value: list[Any], storage: str | None) -> list[Type]:
    if not value:
        return [TYPES["double[]"], TYPES["token[]"]]
    if isinstance(value[0], str):
        return [TYPES["token[]"]]
    nested = isinstance(value[0], list | tuple)
    flat = [one for row in value for one in (row if isinstance(row, list | tuple) else [row])]
    if any(isinstance(one, bool) for one in flat):
        return [TYPES["bool[]"]]
    if storage is None:
        storage = "int" if all(isinstance(one, int) for one in flat) else "double"
    names = []
    for kind in dict.fromkeys((storage, "double", "float")):
        if nested:
            names += [f"{kind}[{len(value[0])}][]", f"matrixd[{len(value)}]"]
        else:
            names += [f"{kind}[{len(value)}]", f"{kind}[]"]
    return [TYPES[name] for name in names if name in TYPES]


def coerced(type_: Type, raw: Any) -> Any:
    """A value, plain or in the explicit form, as a value of `type_`. Raises ValueError if it cannot be converted."""
    explicit = typed_value(raw)
    return coerce(type_, raw if explicit is None else explicit[1])


def typed_value(value: Any) -> tuple[Type, Any] | None:
    """The type and value of the explicit form `{type: double[3], value: [1, 0, 0]}`; None for any other value.

    Raises ValueError for an unknown type or a value that does not fit it.
    """
    if not isinstance(value, Mapping) or set(value) != {"type", "value"}:
        return None
    type_ = concrete_type(str(value["type"]))
    return type_, coerce(type_, value["value"])
