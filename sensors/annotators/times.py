"""The times of a frame as annotators give them: its reference time, and the clocks at that time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .reading import Reading


def reference_time(reading: Reading) -> dict[str, int]:
    """The reference time for look-ups of the frame's own time; before the first frame 0/0, which means now."""
    numerator = denominator = 0
    if reading.frame is not None:
        numerator, denominator = reading.app.simulation.frame_key(reading.frame.reference).as_integer_ratio()
    return {"referenceTimeNumerator": numerator, "referenceTimeDenominator": denominator}


def simulation_time(reading: Reading) -> dict[str, float]:
    """The frame's simulation time [s].

    Without resetOnStop, the one that a stop does not reset; 0 before the first frame.
    """
    return {"simulationTime": _time(reading, "simulation" if reading.options["resetOnStop"] else "monotonic")}


def system_time(reading: Reading) -> dict[str, float]:
    """The wall clock [UNIX s] at the physics step that the frame shows; 0 before the first frame."""
    return {"systemTime": _time(reading, "system")}


def _time(reading: Reading, which: Any) -> float:
    return 0.0 if reading.frame is None else float(reading.app.simulation.of_frame(reading.frame.reference, which))
