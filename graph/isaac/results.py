"""What Isaac Sim's calls give: arrays with the calls of Warp's, `.numpy()` and `.list()`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np


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


def result(values: Any, dtype: Any = np.float32) -> Result:
    """The values as an array that scripts can ask as Warp's."""
    return np.array(values, dtype).view(Result)


def rows(values: Any, count: int, width: int | None, name: str) -> np.ndarray | None:
    """(count, width) of values for one or for each; None stays None. Without a width: (count,).

    Raises ValueError for another shape.
    """
    if values is None:
        return None
    given = values.numpy() if hasattr(values, "numpy") else values
    array = np.asarray(given, np.float64)
    if width is None:
        array = array.reshape(-1)
        if array.size not in (1, count):
            raise ValueError(f"{name}: give one value, or {count}, not {array.size}")
        return np.broadcast_to(array, (count,))
    array = array.reshape(-1, width) if array.size and array.size % width == 0 else array
    if array.shape not in ((1, width), (count, width)):
        raise ValueError(f"{name}: give {width} numbers, or {count} times {width}, not shape {np.shape(given)}")
    return np.broadcast_to(array, (count, width))


def numbers(which: Any, count: int) -> list[int]:
    """The chosen numbers below `count`; None: all."""
    if which is None:
        return list(range(count))
    given = which.numpy() if hasattr(which, "numpy") else which
    if isinstance(given, slice):
        return list(range(count))[given]
    return [int(one) for one in np.asarray(given).reshape(-1)]


def words(values: Any, count: int) -> list[Any]:
    """One word for all, or one for each."""
    listed = [values] if isinstance(values, str) or not isinstance(values, Iterable) else list(values)
    return listed * count if len(listed) == 1 else listed
