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
    x, y, z = vector
    return (
        matrices[which, 0, 0] * x + matrices[which, 0, 1] * y + matrices[which, 0, 2] * z,
        matrices[which, 1, 0] * x + matrices[which, 1, 1] * y + matrices[which, 1, 2] * z,
        matrices[which, 2, 0] * x + matrices[which, 2, 1] * y + matrices[which, 2, 2] * z,
    )


@inlined
def transposed_times(matrices: np.ndarray, which: Any, vector: Vector) -> Vector:
    """The transpose of one of some matrices (n, 3, 3) times a vector."""
    x, y, z = vector
    return (
        matrices[which, 0, 0] * x + matrices[which, 1, 0] * y + matrices[which, 2, 0] * z,
        matrices[which, 0, 1] * x + matrices[which, 1, 1] * y + matrices[which, 2, 1] * z,
        matrices[which, 0, 2] * x + matrices[which, 1, 2] * y + matrices[which, 2, 2] * z,
    )
