"""The present and past times of an App's simulation: now, and at a reference time by a short memory of samples."""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Literal, NamedTuple, Protocol

from graph.base import exact
from graph.sim import settings as keys
from graph.sim.settings import Settings

from .clocks import MICROSECONDS, PhysicsClock, Reading

CAPACITY = 31
Which = Literal["simulation", "monotonic", "system"]


class RationalTime(Fraction):
    """A time [s] with the call that scripts make on it."""

    def to_float(self) -> float:
        """The nearest float."""
        return float(self)


class SampleData(NamedTuple):
    """The times of a sample as floats [s], in Isaac Sim's words."""

    sim_time: float
    sim_time_monotonic: float
    system_time: float

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


_log = logging.getLogger("tickgraph.clocks")

ReferenceTime = Fraction | tuple[int, int]
"""A time [s] as a fraction, or as (numerator, denominator); denominator 0 means now."""


class ExternalClock(Protocol):
    """The renderer's clock; its time is the key of time samples."""

    multi_tick: bool

    @property
    def time(self) -> Fraction:
        """The external time [s]."""

    @property
    def sample_key(self) -> Fraction | None:
        """The key of a time sample taken now; None means the physics clock's own time."""


class TimeQueries:
    """Simulation, monotonic and system time, and their samples."""

    def __init__(
        self,
        clock: PhysicsClock,
        external: ExternalClock,
        settings: Settings,
        now: Callable[[], Fraction],
        warn: Callable[[str, str, str], None],
    ) -> None:
        """now: the wall clock's time [s]."""
        self.clock = clock
        self.samples = TimeSamples(per_substep=settings.get(keys.SAMPLE_SUBSTEPS))
        self._external, self._now, self._warn = external, now, warn
        settings.subscribe(keys.SAMPLE_SUBSTEPS, self._sample_substeps)
        self._system_time = now()

    @property
    def time(self) -> Fraction:
        """The exact simulation time [s]: steps since play / steps per second."""
        return self.clock.time

    @property
    def monotonic_time(self) -> Fraction:
        """The exact time stepped since the App was made [s]; survives stop and changes of rate."""
        return self.clock.monotonic

    @property
    def system_time(self) -> float:
        """Wall-clock time [UNIX s] at the last physics step, before the first one at the App's construction."""
        return float(self._system_time)

    def get_simulation_time(self) -> float:
        """Simulation time [s]."""
        return self.clock.seconds

    def get_simulation_time_monotonic(self) -> float:
        """Monotonic time [s]."""
        return float(self.clock.monotonic)

    def get_system_time(self) -> float:
        """As `system_time`."""
        return self.system_time

    def get_current_time(self) -> Fraction:
        """The exact external time [s], the key of time samples."""
        return self._external.time

    def get_simulation_time_at_time(self, time: ReferenceTime) -> float:
        """Simulation time [s] at reference time `time`; now if no sample matches.

        With a sample for each substep (as in the product, which then reads no store) it is `time` itself.
        """
        if self.samples.per_substep and len(self.samples) and self._external.multi_tick:
            moment = _moment(time)
            return float(self.clock.time if moment is None else moment)
        return self._at(time, "simulation", self.clock.time)

    def get_simulation_time_monotonic_at_time(self, time: ReferenceTime) -> float:
        """Monotonic time [s] at reference time `time`; now if no sample matches."""
        return self._at(time, "monotonic", self.clock.monotonic)

    def get_system_time_at_time(self, time: ReferenceTime) -> float:
        """Wall-clock time [UNIX s] of the physics step at reference time `time`; now if no sample matches."""
        return self._at(time, "system", self._system_time)

    def frame_key(self, reference: Fraction) -> Fraction:
        """The reference time [s] for look-ups of a frame's own time: the key of its sample.

        reference: the frame's time on the renderer's clock. With a sample for each substep, keys are in whole
        microseconds, rounded down.
        """
        if self.samples.per_substep and self._external.multi_tick:
            return Fraction(math.floor(reference * MICROSECONDS), MICROSECONDS)
        return reference

    def of_frame(self, reference: Fraction, which: Which) -> float:
        """Simulation, monotonic or system time [s] of the state that a frame with this reference time shows.

        The result of `get_simulation_time_at_time(frame_key(reference))` and the similar calls. If no sample matches
        (the time is older than 31 samples, or than the first one): counted back from now; for the system time, that of
        now.
        """
        key = self.frame_key(reference)
        if which == "simulation" and self.samples.per_substep and self._external.multi_tick:
            return float(key)
        found = self.samples.at(key, which)
        if found is None and which == "system":
            found = self._system_time
        if found is None:
            now = self.clock.time if which == "simulation" else self.clock.monotonic
            found = now - (self._external.time - reference)
        return float(found)

    def get_all_samples(self) -> list[Sample]:
        """The time samples, oldest first."""
        return self.samples.all()

    def get_sample_count(self) -> int:
        """The number of time samples."""
        return len(self.samples)

    def get_sample_range(self) -> tuple[Fraction, Fraction] | None:
        """The keys of the oldest and the newest time sample [s]."""
        samples = self.samples.all()
        return (samples[0].time, samples[-1].time) if samples else None

    def get_buffer_capacity(self) -> int:
        """The largest number of time samples."""
        return CAPACITY

    def log_statistics(self) -> None:
        """Logs the number of time samples and the span they cover."""
        span = self.get_sample_range()
        covered = f", from {float(span[0]):g} s to {float(span[1]):g} s" if span else ""
        _log.info("%d of %d time samples%s", len(self.samples), CAPACITY, covered)

    def stepped(self, samples: int = 0) -> None:
        """Physics has stepped: system time is now.

        The present times become a sample, and those after each of the `samples` - 1 steps before.
        """
        self._system_time = system = self._now()
        if samples:
            self.samples.record(self.clock, system, self._external.sample_key, samples)

    def resample(self) -> None:
        """Writes the present times as a sample; it replaces the newest one if that has the same key (resume)."""
        self.samples.record(self.clock, self._system_time, self._external.sample_key)

    def _sample_substeps(self, value: bool) -> None:
        self.samples.per_substep = value

    def _at(self, time: ReferenceTime, which: Which, now: Fraction) -> float:
        moment = _moment(time)
        found = None if moment is None else self.samples.at(moment, which)
        if moment is None:
            return float(now)
        if found is None and len(self.samples):
            message = "no time sample answers a reference time (31 are kept); the present time stood in for it"
            self._warn("time-sample-missing", f"simulation.{which}", message)
        return float(now if found is None else found)


def _moment(time: ReferenceTime) -> Fraction | None:
    try:
        if isinstance(time, tuple):
            numerator, denominator = time
            return Fraction(numerator, denominator) if denominator else None
        return Fraction(time)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"reference time {time!r}: give a fraction or (numerator, denominator)") from None
