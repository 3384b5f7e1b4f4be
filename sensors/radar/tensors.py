"""Two by two algebra in compiled loops, written out: vectors are two numbers, symmetric tensors (xx, xy, yy)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sensors.compiled import inlined

Pair = tuple[Any, Any]
Symmetric = tuple[Any, Any, Any]


@inlined
def pair(table: np.ndarray, number: Any) -> Pair:
    """A vector of a table (n, 2)."""
    return table[number, 0], table[number, 1]


@inlined
def symmetric(table: np.ndarray, number: Any) -> Symmetric:
    """A tensor of a table (n, 2, 2)."""
    return table[number, 0, 0], table[number, 0, 1], table[number, 1, 1]


@inlined
def form(tensor: Symmetric, vector: Pair) -> Any:
    """Vector times tensor times vector."""
    x, y = vector
    return tensor[0] * x * x + 2.0 * tensor[1] * x * y + tensor[2] * y * y


@inlined
def inverse(tensor: Symmetric) -> tuple[Symmetric, Any]:
    """The inverse of a tensor, and its determinant."""
    xx, xy, yy = tensor
    area = xx * yy - xy * xy
    return (yy / area, -xy / area, xx / area), area


@inlined
def principal(tensor: Symmetric, more: Any) -> tuple[Pair, Pair]:
    """The larger and the smaller eigenvalue of a positive tensor, plus `more`, and the unit vector of the larger."""
    xx, xy, yy = tensor
    middle, off = (xx + yy) / 2.0, math.sqrt(((xx - yy) / 2.0) ** 2 + xy * xy)
    large = middle + off
    small = max((xx * yy - xy * xy) / max(large, 1e-300), 0.0)
    turn = 0.5 * math.atan2(2.0 * xy, xx - yy)
    return (large + more, small + more), (math.cos(turn), math.sin(turn))
