"""Rounding to the precision of `float` and `half` attributes, whose values are Python floats.

A `float` attribute holds only numbers of float32, a `half` only those of float16 (IEEE 754, ties to even): 0.1 +
16777216 is 16777216 in a `float`, as in OmniGraph's own attributes.
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
"""The rounding of each storage that needs it, coarsest first."""


def coarser(*storages: str) -> Rounder | None:
    """The rounding of a number that passes attributes of both storages; None if neither rounds."""
    return next((ROUNDERS[storage] for storage in ROUNDERS if storage in storages), None)
