"""Rounding to the precision of `float` and `half` attributes, whose values are Python floats.

A `float` attribute holds only numbers that float32 has, a `half` only those of float16 (IEEE 754, ties to even):
0.1 + 16777216 is 16777216 there, as in OmniGraph's own attributes.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from ctypes import c_float

Rounder = Callable[[float], float]

_HALF = struct.Struct("e")


def single(value: float) -> float:
    """The nearest float32; infinite beyond its largest number."""
    return c_float(value).value  # a third of NumPy's cost, and safe among threads


def half(value: float) -> float:
    """The nearest float16; infinite beyond its largest number."""
    try:
        found: float = _HALF.unpack(_HALF.pack(float(value)))[0]
    except OverflowError:
        return math.copysign(math.inf, value)
    return found


ROUNDERS: dict[str, Rounder] = {"half": half, "float": single}
"""By storage; other storages need no rounding. The first is the coarser one."""


def coarser(*storages: str) -> Rounder | None:
    """The rounding that a number passes on its way through attributes of these storages; None for none."""
    return next((ROUNDERS[storage] for storage in ROUNDERS if storage in storages), None)
