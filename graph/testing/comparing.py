"""Compares a value with the expected one, within a tolerance, and shows both."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from graph.values.coercion import coerce
from graph.values.types import Type

_SHOWN = 120


def difference(expected: Any, got: Any, type_: Type | None, tolerance: float) -> str | None:
    """The difference between `got` and `expected`, as `expected ..., got ...`; None if they agree.

    With a type, `expected` is first converted to it. Numbers agree within `tolerance`, absolute up to 1 and relative
    above; NaN agrees with NaN; whole numbers, booleans and text agree exactly.
    """
    wanted = expected
    if type_ is not None:
        try:
            wanted = coerce(type_, expected)
        except ValueError as error:
            return f"expected {show(expected)}, which cannot be: {error}; got {show(got)}"
    off = _distance(wanted, got)
    if off is None or off <= tolerance:
        # None means two equal values that are not numbers.
        return None
    by = f" (error {off:.3g}, tolerance {tolerance:g})" if math.isfinite(off) else ""
    return f"expected {show(expected)}, got {show(got)}{by}"


def _distance(wanted: Any, got: Any) -> float | None:
    """The distance of two values: 0 or None if they are equal, inf if they have no numeric distance."""
    wanted, got = _plain(wanted), _plain(got)
    if isinstance(wanted, list) or isinstance(got, list):
        if not (isinstance(wanted, list) and isinstance(got, list)) or len(wanted) != len(got):
            return math.inf
        # Not max(), which does not handle NaN.
        return max((_distance(a, b) or 0.0 for a, b in zip(wanted, got, strict=True)), default=0.0)
    if isinstance(wanted, Mapping) and isinstance(got, Mapping):
        if wanted.keys() != got.keys():
            return math.inf
        return max((_distance(wanted[key], got[key]) or 0.0 for key in wanted), default=0.0)
    numbers = all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in (wanted, got))
    if not numbers or (isinstance(wanted, int) and isinstance(got, int)):
        return None if type(wanted) is type(got) and wanted == got else math.inf
    return _apart(float(wanted), float(got))


def _apart(wanted: float, got: float) -> float:
    if wanted == got or (math.isnan(wanted) and math.isnan(got)):
        return 0.0
    if not (math.isfinite(wanted) and math.isfinite(got)):
        return math.inf
    return abs(got - wanted) / max(1.0, abs(wanted))


def _plain(value: Any) -> Any:
    """Arrays, their scalars and tuples as lists and Python numbers."""
    if hasattr(value, "dtype"):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def show(value: Any) -> str:
    """A value as written in a test file, shortened in the middle if it is long."""
    text = _written(_plain(value))
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 40]} ... {text[-35:]}"


def _written(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {_written(_plain(one))}' for key, one in value.items())}}}"
    if isinstance(value, list):
        long = len(value) > 60
        shown = [_written(_plain(one)) for one in (value[:30] if long else value)]
        return f"[{', '.join(shown)}{f', ... {len(value)} in all' if long else ''}]"
    return repr(value) if isinstance(value, (int, float)) else str(value)
