"""Reads attributes of PhysX sensor prims as the decimals that their authors wrote."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from graph.base import exact
from graph.base.errors import UserError

if TYPE_CHECKING:
    from pxr import Usd

FARTHEST_M = 10**9
"""The largest range [m]."""


def fail(prim: Usd.Prim, name: str, problem: str) -> NoReturn:
    """Raises UserError with the attribute, its value and what is wrong."""
    raise UserError(f"{prim.GetPath()}.{name} is {prim.GetAttribute(name).Get()}; {problem}")


def number(
    prim: Usd.Prim, name: str, *, least: int | None = None, most: int | None = None, above: int | None = None
) -> Fraction:
    """A float attribute as its shortest decimal. Raises UserError outside the bounds and if it is not a number."""
    try:
        value = exact.rate(float(prim.GetAttribute(name).Get()), stored_as_float32=True)
    except ValueError:
        fail(prim, name, "give a finite number")
    if above is not None and value <= above:
        fail(prim, name, f"give a number above {above}")
    if least is not None and value < least:
        fail(prim, name, f"give {least} or more")
    if most is not None and value > most:
        fail(prim, name, f"give at most {most}")
    return value


def read_ranges(prim: Usd.Prim) -> tuple[float, float]:
    """minRange and maxRange [m]. Raises UserError unless 0 <= minRange <= maxRange <= 1e9."""
    nearest = number(prim, "minRange", least=0)
    farthest = number(prim, "maxRange", most=FARTHEST_M)
    if farthest < nearest:
        fail(prim, "maxRange", f"give at least minRange, {float(nearest):g}")
    return float(nearest), float(farthest)


def unit_axis(prim: Usd.Prim, name: str) -> np.ndarray:
    """A float3 attribute as a unit vector, (3,) float64. Raises UserError for one without a direction."""
    axis = np.array(prim.GetAttribute(name).Get(), np.float64)
    length = float(np.linalg.norm(axis))
    if not np.isfinite(length) or not length:
        fail(prim, name, "give a vector of a length above 0")
    return axis / length
