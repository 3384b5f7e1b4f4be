"""A short memory of the clocks: the time samples that nodes look up by reference time."""

from __future__ import annotations

from collections import deque
from fractions import Fraction
from itertools import pairwise
from typing import Literal, NamedTuple

from graph.base import exact

from .clocks import MICROSECONDS, PhysicsClock, Reading

CAPACITY = 31
Which = Literal["simulation", "monotonic", "system"]


class RationalTime(Fraction):
    """A time [s] with the call that scripts make on it."""

    def to_float(self) -> float:
        """The nearest float."""
        return float(self)


class SampleData(NamedTuple):
    """The times of a sample as floats [s]."""

    simulation: float
    monotonic: float
    system: float

    @property
    def sim_time(self) -> float:
        """As `simulation`, in Isaac Sim's words."""
        return self.simulation

    @property
    def sim_time_monotonic(self) -> float:
        """As `monotonic`, in Isaac Sim's words."""
        return self.monotonic

    @property
    def system_time(self) -> float:
        """As `system`, in Isaac Sim's words."""
        return self.system

    @property
    def valid(self) -> bool:
        """Whether it holds times: always True, since a sample is made with its times."""
        return True


class Sample(NamedTuple):
    """The clocks at `key` [s]: simulation and monotonic time, and wall-clock time at that physics step."""

    key: Fraction
    simulation: Fraction
    monotonic: Fraction
    system: Fraction

    @property
    def time(self) -> RationalTime:
        """The key."""
        return RationalTime(self.key)

    @property
    def data(self) -> SampleData:
        """The three times as floats [s]."""
        return SampleData(float(self.simulation), float(self.monotonic), float(self.system))

    @property
    def valid(self) -> bool:
        """Whether it holds times: always True."""
        return self.data.valid


class TimeSamples:
    """The last 31 time samples.

    Each update with a physics step gives one, with its last substep's times, and each direct step gives one; with
    `per_substep` every step does.

    The key is the exact external time, or the run loop's where multi-tick rendering is off; with `per_substep` the
    external time in whole microseconds, rounded down. A sample with the key of the newest one replaces it; older ones
    never change. Look-ups match exactly or interpolate between neighbours; outside of all samples they fail.
    """

    def __init__(self, *, per_substep: bool = False) -> None:
        self.per_substep = per_substep
        self._entries: deque[tuple[Reading, Fraction, Fraction | int | None]] = deque(maxlen=CAPACITY)

    def record(self, clock: PhysicsClock, system: Fraction, key: Fraction | None = None, steps: int = 1) -> None:
        """Adds the present clocks, and those after each of the `steps` - 1 steps before (all of one rate).

        `key` None means the simulation time itself; `system` is the wall time [s] of them all.
        """
        now = clock.reading()
        if steps > 1 and key is None:
            for count in range(max(now.steps - min(steps, CAPACITY), now.start) + 1, now.steps):
                self._add(now._replace(steps=count), system, None)
        self._add(now, system, key)

    def _add(self, reading: Reading, system: Fraction, key: Fraction | None) -> None:
        entries = self._entries
        kept = reading.microseconds if self.per_substep and key is None else key
        if entries:
            last, _, last_key = entries[-1]
            if last_key == kept and (kept is not None or last.same_time(reading)):
                entries.pop()
        entries.append((reading, system, kept))

    def clear(self) -> None:
        """Drops all samples (stop)."""
        self._entries.clear()

    def __len__(self) -> int:
        return len(self._entries)

    def all(self) -> list[Sample]:
        """Every sample, oldest first."""
        return [
            Sample(_key(reading, key), reading.time, reading.monotonic, system)
            for reading, system, key in self._entries
        ]

    def at(self, time: Fraction, which: Which) -> Fraction | None:
        """The `which` time at key `time`, exact; None outside of the samples.

        Whole nanoseconds, as in stamps of frames, find the key that is rounded to them.
        """
        samples = self.all()
        stamp = time * exact.NANOSECONDS
        for sample in reversed(samples):
            if sample.key == time or (stamp.denominator == 1 and exact.nanoseconds(sample.key) == stamp):
                return _value(sample, which)
        for before, after in pairwise(samples):
            if before.key < time < after.key:
                share = (time - before.key) / (after.key - before.key)
                low, high = _value(before, which), _value(after, which)
                return low + share * (high - low)
        return None


def _key(reading: Reading, key: Fraction | int | None) -> Fraction:
    if key is None:
        return reading.time
    return Fraction(key, MICROSECONDS) if isinstance(key, int) else key


def _value(sample: Sample, which: Which) -> Fraction:
    if which == "simulation":
        return sample.simulation
    return sample.monotonic if which == "monotonic" else sample.system
