"""Durations that a user gives a node."""

from __future__ import annotations

import math
from fractions import Fraction

from graph.base.exact import duration
from graph.node import Database


def finite_duration(db: Database) -> Fraction:
    """The input `duration` [s], exactly. Fails the node if it is not a finite number."""
    if not math.isfinite(db.inputs.duration):
        db.fail(f"input duration is {db.inputs.duration} s; give it a finite number of seconds")
    return duration(db.inputs.duration)
