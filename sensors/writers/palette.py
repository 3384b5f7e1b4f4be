"""Numbers as colours: the palette Turbo (A. Mikhailov, 2019)."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

NOTHING = (24, 26, 32)
"""Colour of what has no value."""


_STOPS = (
    "30123b3b2f80434eba466be34685fa3ba0fd28bceb1ad2d21ae4b632f298"
    "55fa7680ff53a4fc3cbef434d9e436eecf3afaba39fe9e2ffb7e21f26014"
    "e4450ad02f05b91e029b0f017a0403"
)
"""Red, green and blue of the palette at 25 evenly spaced places, between which it is linear to 2 %."""


@cache
def palette() -> NDArray[np.uint8]:
    """(256, 3) colours; the first is that of what has no value."""
    stops = np.frombuffer(bytes.fromhex(_STOPS), np.uint8).reshape(-1, 3)
    share = np.linspace(0, len(stops) - 1, 255)
    colours = np.stack([np.interp(share, np.arange(len(stops)), one) for one in stops.T], axis=1)
    found: NDArray[np.uint8] = np.concatenate([[NOTHING], np.round(colours)]).astype(np.uint8)
    return found


def indices(values: NDArray[Any], low: float, high: float) -> NDArray[np.uint8]:
    """Palette numbers of values: 1 at `low` and below, 255 at `high` and above, 0 where a value is not finite."""
    share = (np.asarray(values, np.float64) - low) / ((high - low) or 1.0)
    known = np.isfinite(share)
    found = np.where(known, 1 + np.round(np.clip(np.where(known, share, 0), 0, 1) * 254), 0)
    return found.astype(np.uint8)


NEAR = 95
"""The hundredth of distances above which all have the last colour: the horizon is far behind what is looked at."""

LEAST_SPAN = 0.02
"""What a scale spans at least, as a share of its larger end."""


def spread(values: NDArray[Any], upper: float = 99) -> tuple[float, float]:
    """The first and the `upper` hundredth of the finite values, as far apart as in `widened`; 0 and 1 without any."""
    known = np.asarray(values, np.float64)
    known = known[np.isfinite(known)]
    if not len(known):
        return 0.0, 1.0
    return widened(*(float(one) for one in np.percentile(known, (1, upper))))


def widened(low: float, high: float) -> tuple[float, float]:
    """Ends of a scale about both numbers: equal numbers get its middle, and rounding errors are not spread over it."""
    least = LEAST_SPAN * max(abs(low), abs(high)) or 1.0
    missing = max(0.0, least - (high - low)) / 2
    return low - missing, high + missing
