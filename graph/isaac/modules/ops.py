"""`isaacsim.core.experimental.utils.ops`: arrays of one device, type and shape."""

from __future__ import annotations

import sys
from functools import cache
from typing import Any

import numpy as np

from graph.isaac.results import Result, array, number_type, result
from graph.isaac.session import warn
from graph.sim.devices import warp

__all__ = ["broadcast_to", "parse_device", "place", "resolve_indices"]


def parse_device(device: Any, *, raise_on_invalid: bool = False) -> Any:
    """The device of Warp. Raises ValueError, or warns and gives the default one, for one that is not here."""
    try:
        return _warp().get_device(device)
    except (RuntimeError, ValueError, AttributeError, TypeError) as error:
        if raise_on_invalid:
            raise ValueError(f"there is no device {device!r}: {error}") from None
        warn("device-not-there", str(device), f"{error}; the default device is used")
        return _warp().get_device()


def _warp() -> Any:
    """Warp as the script imported it, else as the engine does."""
    return sys.modules.get("warp") or warp()


def place(x: Any, *, dtype: Any = None, device: Any = None) -> Result:
    """An array of the numbers, of their own type unless another is asked for. Raises TypeError for other things."""
    given = array(x)
    if given.dtype.kind not in "biuf":
        raise TypeError(f"numbers, lists of them, or an array are wanted, not {type(x).__name__}")
    _check(device)
    kind = given.dtype if dtype is None else number_type(dtype)
    if (
        not isinstance(x, (bool, int, float, list, tuple))
        and kind == given.dtype
        and isinstance(x, type(result([], kind)))
    ):
        return x
    return result(np.atleast_1d(given), kind)


def resolve_indices(x: Any, *, count: int | None = None, dtype: Any = None, device: Any = None) -> Result:
    """(N,) numbers of elements; None: all of `count`, one array for all calls alike."""
    _check(device)
    if x is None and count is None:
        raise ValueError("give numbers, or the count of all elements")
    if x is None:
        return _all(count, np.dtype(np.int32 if dtype is None else number_type(dtype)).str)
    return place(array(x).reshape(-1), dtype=dtype)


@cache
def _all(count: int, kind: str) -> Result:
    return result(np.arange(count), np.dtype(kind))


def broadcast_to(x: Any, *, shape: Any, dtype: Any = None, device: Any = None) -> Result:
    """NumPy's broadcasting."""
    return place(np.broadcast_to(array(place(x, dtype=dtype, device=device)), shape))


def _check(device: Any) -> None:
    """Raises ValueError for a device other than the processor."""
    if device is not None and str(device) != "cpu":
        raise ValueError(f"arrays of scripts are on the processor here; device {str(device)!r} is not used")
