"""Vectors of three numbers in compiled loops: a part of an array would be counted as a reference."""

from __future__ import annotations

from typing import Any

import numpy as np

from .compiled import inlined

Vector = tuple[Any, Any, Any]


@inlined
def row_of(table: np.ndarray, number: Any) -> Vector:
    """A vector of a table (n, 3)."""
    return table[number, 0], table[number, 1], table[number, 2]


@inlined
def dot(one: Vector, two: Vector) -> Any:
    """The dot product of two vectors."""
    return one[0] * two[0] + one[1] * two[1] + one[2] * two[2]


@inlined
def times(matrices: np.ndarray, which: Any, vector: Vector) -> Vector:
    """One of some matrices (n, 3, 3) times a vector."""
    # Written out: a part that takes 0, 1 or 2 is compiled for each of them.
    m, (x, y, z) = matrices, vector
    return (
        m[which, 0, 0] * x + m[which, 0, 1] * y + m[which, 0, 2] * z,
        m[which, 1, 0] * x + m[which, 1, 1] * y + m[which, 1, 2] * z,
        m[which, 2, 0] * x + m[which, 2, 1] * y + m[which, 2, 2] * z,
    )


@inlined
def transposed_times(matrices: np.ndarray, which: Any, vector: Vector) -> Vector:
    """The transpose of one of some matrices (n, 3, 3) times a vector."""
    m, (x, y, z) = matrices, vector
    return (
        m[which, 0, 0] * x + m[which, 1, 0] * y + m[which, 2, 0] * z,
        m[which, 0, 1] * x + m[which, 1, 1] * y + m[which, 2, 1] * z,
        m[which, 0, 2] * x + m[which, 1, 2] * y + m[which, 2, 2] * z,
    )
