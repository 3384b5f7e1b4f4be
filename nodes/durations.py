"""Durations that a user gives a node."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from graph.base.exact import duration


def finite_duration(db: Any) -> Fraction:
    """The input `duration` [s], exactly. Fails the node if it is no finite number."""
    if not math.isfinite(db.inputs.duration):
        db.fail(f"input duration is {db.inputs.duration} s; give it a finite number of seconds")
    return duration(db.inputs.duration)
