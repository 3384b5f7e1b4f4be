"""Which types may be connected, and what happens to a value on the way: OmniGraph's implicit conversions, no others.

Allowed: the same type; the same storage in another role (double[3] to vectord[3]); one number to another; one text to
another. Refused: bool to number, tuple to scalar, scalar to tuple, element to array, and execution, target or bundle to
anything else.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from .types import INTEGER_RANGES, Extended, Type
from .values import dtype_of, shown

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
    """The function that turns a value of `source` into one of `target`; None where the value passes as it is.

    A float becomes an integer towards zero; a number that does not fit raises ValueError when it is converted.
    Raises TypeError where the table allows no conversion.
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
        return None if low <= least and most <= high else _as_integer(target)
    return float if source.storage in INTEGER_RANGES else None


def way_between(source: Type | None, target: Type | None) -> str:
    """The tail of a message about two types that cannot meet: the node that leads from one to the other, if any."""
    if source is None or target is None:
        return ""
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


def settle(source: Type, target: Extended) -> Type | None:
    """The type an open `target` takes from a connected `source`; None if they cannot meet.

    The source's own type where the target accepts it, else the first member it converts to, reals before integers.
    """
    if target.accepts(source):
        return source
    members = sorted(target.members, key=lambda member: member.storage in INTEGER_RANGES)
    return next((member for member in members if convertible(source, member)), None)


def _as_integer(target: Type) -> Converter:
    low, high = INTEGER_RANGES[target.storage]

    def convert(value: Any) -> int:
        try:
            whole = int(value)
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
