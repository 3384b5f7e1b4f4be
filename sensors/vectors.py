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
def _row(matrices: np.ndarray, which: Any, axis: Any) -> Vector:
    return matrices[which, axis, 0], matrices[which, axis, 1], matrices[which, axis, 2]


@inlined
def _column(matrices: np.ndarray, which: Any, axis: Any) -> Vector:
    return matrices[which, 0, axis], matrices[which, 1, axis], matrices[which, 2, axis]


@inlined
def times(matrices: np.ndarray, which: Any, vector: Vector) -> Vector:
    """One of some matrices (n, 3, 3) times a vector."""
    first, second, third = _row(matrices, which, 0), _row(matrices, which, 1), _row(matrices, which, 2)
    return dot(first, vector), dot(second, vector), dot(third, vector)


@inlined
def transposed_times(matrices: np.ndarray, which: Any, vector: Vector) -> Vector:
    """The transpose of one of some matrices (n, 3, 3) times a vector."""
    first, second, third = _column(matrices, which, 0), _column(matrices, which, 1), _column(matrices, which, 2)
    return dot(first, vector), dot(second, vector), dot(third, vector)
