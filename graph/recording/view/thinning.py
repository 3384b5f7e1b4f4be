"""Which messages a page shows: it holds some of each topic, spread over its time, within a budget of bytes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def chosen(count: int, most: int) -> tuple[int, ...]:
    """At most `most` numbers from 0 to count - 1, evenly spread, with the first and the last."""
    if count <= most:
        return tuple(range(count))
    if most < 2:
        return (count - 1,) if most == 1 else ()
    return tuple(round(place * (count - 1) / (most - 1)) for place in range(most))


def some(count: int, most: int) -> NDArray[np.int64]:
    """At most `most` numbers from 0 to count - 1 in order, drawn at random: every second could be half of the rings."""
    if count <= most:
        return np.arange(count)
    found: NDArray[np.int64] = np.sort(np.random.default_rng(count).choice(count, most, replace=False))
    return found
