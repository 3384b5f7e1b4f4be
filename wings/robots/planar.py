"""Headings and angles in the plane that wheeled robots drive on (Z up, counted from x towards y)."""

from __future__ import annotations

import math
from collections.abc import Iterable


def heading(quaternion: Iterable[float]) -> float:
    """The heading [rad, -pi to pi] of an orientation x, y, z, w of any length; 0 for an invalid one."""
    x, y, z, w = (float(part) for part in quaternion)
    norm = x * x + y * y + z * z + w * w
    if not (math.isfinite(norm) and norm > 0):
        return 0.0
    return math.atan2(2 * (w * z + x * y), norm - 2 * (y * y + z * z))


def wrapped(angle: float) -> float:
    """The angle in [-pi, pi]."""
    return math.remainder(angle, 2 * math.pi)
