"""A short memory of what the clocks read: the time samples that nodes look up by reference time."""

from __future__ import annotations

from collections import deque
from fractions import Fraction
from itertools import pairwise
from typing import Literal, NamedTuple

from .clocks import PhysicsClock, Reading

CAPACITY = 31
Which = Literal["simulation", "monotonic", "system"]


class Sample(NamedTuple):
    """What the clocks read at `key` [s]: simulation and monotonic time, and wall-clock time at that physics step."""

    key: Fraction
    simulation: Fraction
    monotonic: Fraction
    system: Fraction


class TimeSamples:
    """The last 31 samples. Each update with a physics step adds one, holding the last substep's times.

    The key is the external time, or the run loop's where multi-tick rendering is off. A sample with the key of the
    newest one replaces it. Look-ups match exactly or interpolate between neighbours; outside there is no answer.
    """

    def __init__(self) -> None:
        self._entries: deque[tuple[Reading, Fraction, Fraction | None]] = deque(maxlen=CAPACITY)

    def record(self, clock: PhysicsClock, system: Fraction, key: Fraction | None = None) -> None:
        """Adds what the clocks read now; `key` None stands for the simulation time itself."""
        reading = clock.reading()
        entries = self._entries
        if entries:
            last, _, last_key = entries[-1]
            if last_key == key and (key is not None or last.same_time(reading)):
                entries.pop()
        entries.append((reading, system, key))

    def clear(self) -> None:
        """Forgets everything (stop)."""
        self._entries.clear()

    def __len__(self) -> int:
        return len(self._entries)

    def all(self) -> list[Sample]:
        """Every sample, oldest first."""
        return [
            Sample(reading.time if key is None else key, reading.time, reading.monotonic, system)
            for reading, system, key in self._entries
        ]

    def at(self, time: Fraction, which: Which) -> Fraction | None:
        """The `which` time at key `time`, exact; None with nothing at or around it."""
        samples = self.all()
        for sample in reversed(samples):
            if sample.key == time:
                return _value(sample, which)
        for before, after in pairwise(samples):
            if before.key < time < after.key:
                share = (time - before.key) / (after.key - before.key)
                low, high = _value(before, which), _value(after, which)
                return low + share * (high - low)
        return None


def _value(sample: Sample, which: Which) -> Fraction:
    if which == "simulation":
        return sample.simulation
    return sample.monotonic if which == "monotonic" else sample.system
