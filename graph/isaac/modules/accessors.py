"""Calls that set and get one attribute of each wrapped prim, made from the attribute's name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from graph.isaac.parameters import renamed
from graph.isaac.results import Result, numbers, result, rows, words
from graph.sim.usd import Sdf, UsdGeom

Calls = tuple[Callable[..., Any], Callable[..., Any]]
"""A setter and a getter."""

_MADE = {"float": float, "double": float, "int": int, "uint": int, "bool": bool}


def write(prim: Any, name: str, kind: str, value: Any) -> None:
    """Authors an attribute, and the extent that follows from it."""
    prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(kind), custom=False).Set(value)
    boundable = UsdGeom.Boundable(prim)
    if boundable and (extent := UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, 0)):
        boundable.CreateExtentAttr().Set(extent)


def read(prim: Any, name: str, default: Any = None) -> Any:
    """The value of an attribute; the default without one."""
    attribute = prim.GetAttribute(name)
    value = attribute.Get() if attribute else None
    return default if value is None else value


def _put(wrapper: Any, name: str, kind: str, values: Any, indices: Any, unit: float = 1.0) -> None:
    chosen, made = numbers(indices, len(wrapper)), _MADE[kind]
    given = rows(values, len(chosen), None, name)
    for one, value in zip(chosen, () if given is None else given, strict=given is not None):
        write(wrapper.prims[one], name, kind, made(value / unit))


def _column(wrapper: Any, name: str, kind: str, default: Any, indices: Any, unit: float = 1.0) -> Result:
    found = np.array([[read(wrapper.prims[one], name, default)] for one in numbers(indices, len(wrapper))])
    return result(found if unit == 1.0 else found * unit, {"bool": bool, "int": np.int32, "uint": np.uint32}.get(kind))


def number(
    name: str, plural: str, kind: str = "float", *, default: Any = 0, argument: str = "", unit: float = 1.0
) -> Calls:
    """Of an attribute of one number or truth value: (N, 1) values.

    plural: the name of the calls after `set_` and `get_`. argument: the setter's parameter, if it is another.
    unit: what 1 in the attribute is for the calls.
    """

    def setter(self: Any, values: Any, *, indices: Any = None) -> None:
        _put(self, name, kind, values, indices, unit)

    def getter(self: Any, *, indices: Any = None) -> Any:
        return _column(self, name, kind, default, indices, unit)

    return (
        renamed(setter, f"set_{plural}", argument or plural, indices=True),
        renamed(getter, f"get_{plural}", indices=True),
    )


def together(
    names: Sequence[str],
    plural: str,
    arguments: Sequence[str],
    defaults: Sequence[float],
    *,
    kind: str = "float",
    unit: float = 1.0,
) -> Calls:
    """Of attributes of one number each, which are set and got together; the setter leaves out None."""

    def setter(self: Any, *given: Any, indices: Any = None) -> None:
        for name, values in zip(names, given, strict=True):
            _put(self, name, kind, values, indices, unit)

    def getter(self: Any, *, indices: Any = None) -> Any:
        pairs = zip(names, defaults, strict=True)
        return tuple(_column(self, name, kind, default, indices, unit) for name, default in pairs)

    return (
        renamed(setter, f"set_{plural}", *arguments, indices=True, optional=True),
        renamed(getter, f"get_{plural}", indices=True),
    )


def texts(names: Sequence[str], plural: str, arguments: Sequence[str], default: str) -> Calls:
    """Of attributes of one word each, which are set and got together; the setter leaves out None."""
    each = [text(name, argument, default=default) for name, argument in zip(names, arguments, strict=True)]

    def setter(self: Any, *given: Any, indices: Any = None) -> None:
        for (put, _), values in zip(each, given, strict=True):
            if values is not None:
                put(self, values, indices=indices)

    def getter(self: Any, *, indices: Any = None) -> Any:
        return tuple(get(self, indices=indices) for _, get in each)

    return (
        renamed(setter, f"set_{plural}", *arguments, indices=True, optional=True),
        renamed(getter, f"get_{plural}", indices=True),
    )


def text(name: str, plural: str, kind: str = "token", *, default: str = "", argument: str = "") -> Calls:
    """Of an attribute of one word or file: lists of N."""

    def setter(self: Any, values: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, value in zip(chosen, words(values, len(chosen)), strict=True):
            write(self.prims[one], name, kind, str(value))

    def getter(self: Any, *, indices: Any = None) -> Any:
        found = [read(self.prims[one], name, default) for one in numbers(indices, len(self))]
        return [one.path if isinstance(one, Sdf.AssetPath) else str(one) for one in found]

    return (
        renamed(setter, f"set_{plural}", argument or plural, indices=True),
        renamed(getter, f"get_{plural}", indices=True),
    )


def colors_of(colors: Any, count: int) -> np.ndarray | None:
    """(count, 3) of numbers, or of names and codes as Matplotlib has them ("C2", "0.5", "#abc", "tab:green")."""
    if isinstance(colors, str) or (isinstance(colors, (list, tuple)) and any(isinstance(one, str) for one in colors)):
        from graph.base.plotting import color

        colors = [color(one) for one in words(colors, count)]
    return rows(colors, count, 3, "colors")
