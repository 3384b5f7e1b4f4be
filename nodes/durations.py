"""Durations that a user gives a node."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from graph.base.exact import duration
from graph.node import Database, NodeAtLoad

from .bounds import at_least


def check_duration(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """A written `duration` that is not a finite number."""
    if "duration" in node.given and not math.isfinite(node.db.inputs.duration):
        yield "duration", f"{node.db.inputs.duration} s does not end; give it a finite number of seconds"


def check_length(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """A written `duration` that is not a finite number, or below 0."""
    yield from check_duration(node)
    yield from at_least(duration=0)(node) if math.isfinite(node.db.inputs.duration) else ()


def finite_duration(db: Database) -> Fraction:
    """The input `duration` [s], exactly. Fails the node if it is not a finite number."""
    if not math.isfinite(db.inputs.duration):
        db.fail(f"input duration is {db.inputs.duration} s; give it a finite number of seconds")
    return duration(db.inputs.duration)
