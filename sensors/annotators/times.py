"""When a frame is of, as annotators hand it out: its reference time, and what the clocks read at it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .types import Reading


def reference_time(reading: Reading) -> dict[str, int]:
    """The reference time by which look-ups find the frame's own; before the first frame 0/0, which stands for now."""
    numerator = denominator = 0
    if reading.frame is not None:
        numerator, denominator = reading.app.simulation.frame_key(reading.frame.reference).as_integer_ratio()
    return {"referenceTimeNumerator": numerator, "referenceTimeDenominator": denominator}


def simulation_time(reading: Reading) -> dict[str, float]:
    """The frame's simulation time [s], or without resetOnStop that which no stop resets; 0 before the first frame."""
    return {"simulationTime": _time(reading, "simulation" if reading.options["resetOnStop"] else "monotonic")}


def system_time(reading: Reading) -> dict[str, float]:
    """The wall clock's time [UNIX s] of the physics step that the frame shows; 0 before the first frame."""
    return {"systemTime": _time(reading, "system")}


def _time(reading: Reading, which: Any) -> float:
    return 0.0 if reading.frame is None else float(reading.app.simulation.of_frame(reading.frame.reference, which))
