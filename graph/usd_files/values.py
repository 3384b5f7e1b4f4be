"""Converts types and values between OGN names with plain data, and Sdf type names with pxr values.

Quaternions are x, y, z, w here, as in OmniGraph; USD's own `Gf.Quat` has the real part first. Matrices are lists of
rows. Numbers stored as float or half become the shortest decimal that stores the same, so that 0.1 stays 0.1.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from graph.values.coercion import dtype_of
from graph.values.types import TYPES, Type, concrete_type

_PLAIN = ("bool", "uchar", "int", "uint", "int64", "uint64", "half", "float", "double", "token", "string", "timecode")
_ALIASES = {"path": "string", "objectId": "uint64", "frame[4]": "matrix4d", "execution": "uint"}
_LETTERS = {"half": "h", "float": "f", "double": "d"}


def sdf_name(type_: Type) -> str:
    """The Sdf type name of an OGN type: `point3d` for pointd[3]; "rel" for target and bundle."""
    if type_.array:
        return f"{sdf_name(type_.element)}[]"
    if type_.storage in ("target", "bundle"):
        return "rel"
    if type_.name in _ALIASES:
        return _ALIASES[type_.name]
    if type_.count == 1:
        return type_.name
    letter = _LETTERS.get(type_.storage, "i")
    match type_.role:
        case "":
            return f"{type_.storage}{type_.count}"
        case "quat":
            return f"quat{letter}"
        case "matrix":
            return f"matrix{type_.count}{letter}"
        case "texcoord":
            return f"texCoord{type_.count}{letter}"
    return f"{type_.role}{type_.count}{letter}"


@cache
def _by_sdf_name() -> dict[str, str]:
    table: dict[str, str] = {}
    for name, type_ in TYPES.items():
        if (
            name not in _ALIASES
            and name.removesuffix("[]") not in _ALIASES
            and type_.storage not in ("target", "bundle")
        ):
            table[sdf_name(type_)] = name
    return table | {"frame4d": "frame[4]", "frame4d[]": "frame[4][]", "asset": "token", "asset[]": "token[]"}


def ogn_name(sdf: str) -> str | None:
    """The OGN type of an attribute with that Sdf type; None if OmniGraph has no such type."""
    return _by_sdf_name().get(sdf)


def from_usd(value: Any, sdf: str) -> Any:
    """A USD value of an attribute with that Sdf type, as plain data."""
    return _reader(sdf)(value)


@cache
def _reader(sdf: str) -> Callable[[Any], Any]:
    name = ogn_name(sdf)
    if name is None:
        return _plain
    type_ = concrete_type(name)
    shorten = _shortener(type_.storage)
    one: Callable[[Any], Any]
    if sdf.startswith("asset"):
        one = _asset
    elif type_.role == "quat":
        one = lambda q: [shorten(x) for x in (*q.imaginary, q.real)]  # noqa: E731
    elif type_.square:
        one = lambda m: [[shorten(x) for x in m.GetRow(i)] for i in range(type_.count)]  # noqa: E731
    elif type_.count > 1:
        one = lambda v: [shorten(x) for x in v]  # noqa: E731
    elif type_.role == "timecode":
        one = lambda t: float(t.GetValue() if hasattr(t, "GetValue") else t)  # noqa: E731
    elif type_.storage == "uchar":
        one = lambda c: ord(c) if isinstance(c, str) else int(c)  # noqa: E731
    else:
        one = shorten
    if type_.array:
        return lambda values: [one(value) for value in values]
    return one


def _asset(value: Any) -> str:
    return str(value.path)


def _shortener(storage: str) -> Callable[[Any], Any]:
    if storage in ("float", "half"):
        scalar = dtype_of(TYPES[storage]).type
        return lambda x: float(str(scalar(x)))
    return {"double": float, "bool": bool, "token": str, "string": str}.get(storage, int)


_SCALARS = (bool, int, float, str)


def _plain(value: Any) -> Any:
    """A value of a type that OmniGraph does not have, or of metadata, as plain data as far as possible."""
    if isinstance(value, _SCALARS) or value is None:
        return value
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if hasattr(value, "imaginary"):
        return [*value.imaginary, value.real]
    if hasattr(value, "GetValue"):
        return float(value.GetValue())  # a time code
    if hasattr(value, "GetRow"):
        return [list(value.GetRow(i)) for i in range(value.dimension[0])]
    if hasattr(value, "__iter__"):
        return [_plain(inner) for inner in value]
    return str(value)


def plain(value: Any) -> Any:
    """Metadata as plain data: dictionaries, lists, numbers, texts."""
    return _plain(value)


def to_usd(value: Any, type_: Type) -> Any:
    """A value, coerced to an OGN type (see `graph.values.coercion.coerce`), in USD's form for `sdf_name(type_)`."""
    from graph.sim.usd import Gf, Sdf, Vt

    if type_.array:
        return _array(value, type_, Vt)
    if type_.role == "quat":
        return getattr(Gf, f"Quat{_LETTERS[type_.storage]}")(float(value[3]), *(float(x) for x in value[:3]))
    if type_.square:
        return getattr(Gf, f"Matrix{type_.count}d")(*(float(x) for x in value.flat))
    if type_.count > 1:
        kind = int if type_.storage == "int" else float
        return getattr(Gf, f"Vec{type_.count}{_LETTERS.get(type_.storage, 'i')}")(*(kind(x) for x in value))
    if type_.role == "timecode":
        return Sdf.TimeCode(value)
    return value


_VT = {"bool": "Bool", "uchar": "UChar", "int": "Int", "uint": "UInt", "int64": "Int64", "uint64": "UInt64"}


def _array(value: Any, type_: Type, vt: Any) -> Any:
    if type_.storage == "token":
        return vt.TokenArray(value)
    element = type_.element
    items = [to_usd(one, element) for one in value]
    if element.role == "quat":
        return getattr(vt, f"Quat{_LETTERS[type_.storage]}Array")(items)
    if element.square:
        return getattr(vt, f"Matrix{element.count}dArray")(items)
    if element.count > 1:
        return getattr(vt, f"Vec{element.count}{_LETTERS.get(type_.storage, 'i')}Array")(items)
    if type_.role == "timecode":
        from graph.sim.usd import Sdf

        return Sdf.TimeCodeArray(items)
    plain_items = [one.item() if hasattr(one, "item") else one for one in items]
    return getattr(vt, f"{_VT.get(type_.storage, type_.storage.capitalize())}Array")(plain_items)
