"""Which types may be connected, and how a value is converted on a connection:

OmniGraph's implicit conversions, no others.

Allowed: the same type; the same storage in another role (double[3] to vectord[3]); one number to another; one text to
another. Refused: bool to number, tuple to scalar, scalar to tuple, element to array, and execution, target or bundle to
anything else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from .coercion import dtype_of, shown
from .precision import coarser
from .types import INTEGER_RANGES, TYPES, AnyType, Extended, Type

Converter = Callable[[Any], Any]


def convertible(source: Type, target: Type) -> bool:
    """Whether a value of `source` may feed an attribute of `target`."""
    if source is target:
        return True
    if (source.number and target.number) or (source.text and target.text):
        return True
    return (source.storage, source.shape, source.array) == (target.storage, target.shape, target.array)


@cache
def converter(source: Type, target: Type) -> Converter | None:
    """The function that turns a value of `source` into one of `target`; None if the value passes unchanged.

    A float is truncated to an integer; a number out of range raises ValueError at the conversion. If either end is
    `float` or `half`, a real number is rounded to that precision. Raises TypeError if the types cannot be connected.
    """
    if not convertible(source, target):
        raise TypeError(f"{source} cannot feed {target}")
    if target.numeric and not target.scalar:
        return _as_array(target)
    if not target.number:
        return None
    if target.storage in INTEGER_RANGES:
        low, high = INTEGER_RANGES[target.storage]
        least, most = INTEGER_RANGES.get(source.storage, (-float("inf"), float("inf")))
        return None if low <= least and most <= high else _as_integer(source, target)
    return coarser(source.storage, target.storage) or (float if source.storage in INTEGER_RANGES else None)


def way_between(source: Type | None, target: AnyType | None) -> str:
    """The tail of a message about two types that cannot be connected: the node that converts one to the other, if any.

    For a union without such a node: the types it accepts.
    """
    if source is None or target is None:
        return ""
    if isinstance(target, Extended):
        return _way_into(source, target)
    if (source.storage == "execution") != (target.storage == "execution"):
        return ""
    if source.array != target.array:
        return "; take an element with ArrayIndex" if source.array else "; make an array with ConstructArray"
    if target.number or (target.numeric and source.number):
        if source.storage == "bool" and source.scalar and target.number:
            return "; convert it with ToDouble"
        tuple_ = target if source.number else source
        if 2 <= tuple_.count <= 4 and not tuple_.square:
            way = "make one with MakeVector" if source.number else "take a component with BreakVector"
            return f"; {way}{tuple_.count}"
    if target.text and (source.numeric or source.storage == "bool"):
        return "; convert it with ToString"
    if target.storage == "target" and source.text:
        return "; convert it with ToTarget"
    return ""


def _way_into(source: Type, target: Extended) -> str:
    """As `way_between`, for an open target."""
    if source.storage == "execution" or settle(source, target) is not None:
        return ""
    nearest: list[tuple[Type, str]] = []
    if source.array:
        nearest.append((source.element, "take an element with ArrayIndex"))
    elif source.name + "[]" in TYPES:
        nearest.append((source.array_of(), "make an array with ConstructArray"))
    if source.scalar and source.storage == "bool":
        nearest.append((TYPES["double"], "convert it with ToDouble"))
    if source.number:
        nearest.append((TYPES["double[2]"], "make a tuple with MakeVector2, MakeVector3 or MakeVector4"))
    elif not source.array and 2 <= source.count <= 4 and not source.square:
        nearest.append((source.component, f"take a component with BreakVector{source.count}"))
    if source.numeric or source.storage == "bool":
        nearest.append((TYPES["string"], "convert it with ToString"))
    if source.text:
        nearest.append((TYPES["target"], "convert it with ToTarget"))
    way = next((way for type_, way in nearest if settle(type_, target) is not None), "")
    return f"; {way or f'give it {_kinds(target)}'}"


def _kinds(target: Extended) -> str:
    """The types a union accepts, in words: each type if they are few, else their kinds."""
    members = target.members
    if len(members) <= 4:
        return _either([one.name for one in members])
    numeric = [one for one in members if one.numeric]
    kinds = [
        "a number" * any(one.number for one in numeric),
        "a matrix" * any(one.square and not one.array for one in numeric),
        "a tuple of numbers" * any(not one.array and one.count > 1 and not one.square for one in numeric),
        "an array of numbers" * any(one.array for one in numeric),
        "a bool" * any(one.storage == "bool" and one.scalar for one in members),
        "a text" * any(one.text for one in members),
        "a token[] or bool[]" * any(one.array and not one.numeric for one in members),
    ]
    return _either([kind for kind in kinds if kind])


def _either(words: Sequence[str]) -> str:
    return " or ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def settle(source: Type, target: Extended) -> Type | None:
    """The type that an open `target` takes from a connected `source`; None if they do not match.

    The source's own type if the target accepts it, else the first member it converts to, reals before integers.
    """
    if target.accepts(source):
        return source
    members = sorted(target.members, key=lambda member: member.storage in INTEGER_RANGES)
    return next((member for member in members if convertible(source, member)), None)


def _as_integer(source: Type, target: Type) -> Converter:
    low, high = INTEGER_RANGES[target.storage]
    rounded = coarser(source.storage)

    def convert(value: Any) -> int:
        try:
            whole = int(rounded(value) if rounded else value)
        except (ValueError, OverflowError):
            raise ValueError(f"{shown(value)} does not fit {target}") from None
        if low <= whole <= high:
            return whole
        raise ValueError(f"{shown(value)} does not fit {target} ({low} to {high})")

    return convert


def _as_array(target: Type) -> Converter:
    """Nodes may write tuples and lists; readers always get an array of the right dtype and shape."""
    import numpy as np

    dtype, shape, ndim = dtype_of(target), target.shape, len(target.shape) + target.array
    asarray, ndarray = np.asarray, np.ndarray

    def convert(value: Any) -> Any:
        if type(value) is not ndarray or value.dtype != dtype:
            value = asarray(value, dtype)
        if value.ndim != ndim:
            if target.array and value.size == 0:
                return value.reshape((0, *shape))
            raise ValueError(f"expected {target}, got an array of shape {value.shape}")
        if value.shape[target.array :] != shape:
            raise ValueError(f"expected {target}, got an array of shape {value.shape}")
        return value

    return convert
