"""The present and past times of an App's simulation, now and at a reference time."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from fractions import Fraction
from typing import Protocol

from graph.sim import settings as keys
from graph.sim.settings import Settings

from .clocks import MICROSECONDS, PhysicsClock
from .samples import CAPACITY, Sample, TimeSamples, Which

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
