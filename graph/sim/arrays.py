"""Reads attributes of a stage as arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .usd import EARLIEST


def array_of(attribute: Any, kind: type, columns: int = 0, time: Any = EARLIEST) -> NDArray[Any]:
    """The value of an attribute, (n,) or (n, columns) of `kind`; empty for a missing value or one of another type."""
    empty: NDArray[Any] = np.zeros((0, columns) if columns else 0, kind)
    value = attribute.Get(time) if attribute else None
    if value is None:
        return empty
    try:
        found: NDArray[Any] = np.asarray(value).astype(kind)
    except (TypeError, ValueError, OverflowError):
        return empty
    if columns and found.size == 0:
        return empty
    return found if found.ndim == (2 if columns else 1) and (not columns or found.shape[1] == columns) else empty


def number_of(attribute: Any, time: Any = EARLIEST) -> float:
    """The value of an attribute; NaN for a missing value or another type."""
    value = attribute.Get(time) if attribute else None
    try:
        return float("nan") if value is None else float(value)
    except (TypeError, ValueError):
        return float("nan")
