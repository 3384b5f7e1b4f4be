"""What Isaac Sim's calls give and take: arrays of Warp if the script imported it, else of NumPy with the same calls."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any, cast

import numpy as np

from .run import RUN


class Result(np.ndarray):
    """A NumPy array with the calls that scripts make on Warp's arrays."""

    def numpy(self) -> np.ndarray:
        """A plain NumPy array."""
        return np.asarray(self)

    def list(self) -> list[Any]:
        """Nested lists."""
        found: list[Any] = self.tolist()
        return found

    @property
    def device(self) -> Any:
        """Where it is."""
        return "cpu"

    def cpu(self) -> Result:
        """Itself."""
        return self

    detach = contiguous = clone = cpu


def result(values: Any, dtype: Any = None) -> Result:
    """The values as Isaac Sim gives them: an array of Warp if the script imported Warp, else a `Result`.

    dtype: of NumPy or of Warp; float32 if it is not given.
    """
    made = np.array(values, number_type(dtype))
    warp = _warp()
    return made.view(Result) if warp is None else cast(Result, warp.array(made, device="cpu"))


def _warp() -> Any:
    """The module `warp` for a script that uses it; None for others."""
    run, found = RUN.get(), sys.modules.get("warp")
    return found if found is not None and (run is None or run.uses_warp) else None


def number_type(dtype: Any) -> Any:
    """NumPy's type for one of NumPy or of Warp; float32 for None."""
    if dtype is None:
        return np.float32
    warp = sys.modules.get("warp")
    known = None if warp is None else getattr(warp, "dtype_to_numpy", None)
    is_warps = known is not None and getattr(dtype, "__module__", "").partition(".")[0] == "warp"
    return known(dtype) if known is not None and is_warps else dtype


def array(values: Any, dtype: Any = None) -> np.ndarray:
    """NumPy's array of what a script gives: numbers, lists of them, arrays of NumPy, Warp or Torch."""
    if hasattr(values, "numpy"):
        values = (values.cpu() if hasattr(values, "cpu") else values).numpy()
    return np.asarray(values, dtype)


def rows(values: Any, count: int, width: int | None, name: str) -> np.ndarray | None:
    """(count, width) of values for one or for each; None stays None. Without a width: (count,).

    Raises ValueError for another shape.
    """
    if values is None:
        return None
    given = array(values, np.float64)
    if width is None:
        flat = given.reshape(-1)
        if flat.size not in (1, count):
            raise ValueError(f"{name}: give one value, or {count}, not {flat.size}")
        return np.broadcast_to(flat, (count,))
    if given.size == 1:
        return np.broadcast_to(given.reshape(1, 1), (count, width))
    shaped = given.reshape(-1, width) if given.size and given.size % width == 0 else given
    if shaped.shape not in ((1, width), (count, width)):
        raise ValueError(f"{name}: give {width} numbers, or {count} times {width}, not shape {given.shape}")
    return np.broadcast_to(shaped, (count, width))


def numbers(which: Any, count: int) -> list[int]:
    """The chosen numbers below `count`; None: all."""
    if which is None:
        return list(range(count))
    if isinstance(which, slice):
        return list(range(count))[which]
    return [int(one) for one in array(which).reshape(-1)]


def words(values: Any, count: int) -> list[Any]:
    """One word or truth value for all, or one for each; rows of one element count as the element."""
    if hasattr(values, "numpy") or isinstance(values, np.ndarray):
        values = array(values).reshape(-1).tolist()
    listed = [values] if isinstance(values, str) or not isinstance(values, Iterable) else list(values)
    listed = [one[0] if isinstance(one, (list, tuple)) and len(one) == 1 else one for one in listed]
    return listed * count if len(listed) == 1 else listed
