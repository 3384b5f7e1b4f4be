"""The run loop, the wall clock that paces it (virtual or real), and how fast the simulation runs on it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from fractions import Fraction
from typing import Protocol

from graph.base.exact import NANOSECONDS
from graph.sim import settings as keys
from graph.sim.phases import Phases, Unsubscribe
from graph.sim.settings import Settings

from .clocks import MICROSECONDS, Counter, PhysicsClock


class WallClock(Protocol):
    """The interface of a wall clock."""

    catch_up: Fraction
    """The lateness [s] that later updates may catch up by not pausing."""

    def now(self) -> Fraction:
        """UNIX time [s]."""

    def pace(self, period: Fraction) -> None:
        """Ends an update that is to last `period` [s]: returns when that has passed since the last one ended."""


class VirtualClock:
    """Advances only when paced: two runs read the same times. Starts at `start` [s] (default 0, 1970-01-01)."""

    def __init__(self, start: Fraction | int = 0) -> None:
        self._numerator, self._denominator = Fraction(start).as_integer_ratio()
        self.catch_up = Fraction(0)  # it is never late
        self._period: Fraction | None = None
        self._ticks = 0

    def now(self) -> Fraction:
        """The virtual UNIX time [s]."""
        return Fraction(self._numerator, self._denominator)

    def pace(self, period: Fraction) -> None:
        """Jumps ahead by `period`."""
        if period is not self._period:
            unit = math.lcm(self._denominator, period.denominator)
            self._numerator *= unit // self._denominator
            self._denominator = unit
            self._period, self._ticks = period, period.numerator * (unit // period.denominator)
        self._numerator += self._ticks


class RealClock:
    """The machine's clock: UNIX time at construction plus the time of the steady clock since.

    Updates end on a steady beat. A late one (the first one is) shifts the beat; up to `catch_up` [s] of that is caught
    up by later updates, which do not wait.
    """

    def __init__(self) -> None:
        self.catch_up = Fraction(0)
        self._origin_ns = time.time_ns() - time.monotonic_ns()
        self._due_ns = 0

    def now(self) -> Fraction:
        """UNIX time [s] in whole nanoseconds; it never goes back."""
        return Fraction(self._origin_ns + time.monotonic_ns(), NANOSECONDS)

    def pace(self, period: Fraction) -> None:
        """Sleeps until the next beat."""
        now = time.monotonic_ns()
        due = self._due_ns + period.numerator * NANOSECONDS // period.denominator
        if due <= now:
            kept_ns = int(self.catch_up * NANOSECONDS) if self._due_ns else 0
            self._due_ns = max(due, now - kept_ns)
            return
        time.sleep((due - now) / NANOSECONDS)
        self._due_ns = due


class RunLoop:
    """Manual mode gives every update the manual step size; else dt is the wall time since the last update began.

    An update lasts 1 / rateLimitFrequency on the wall clock: a virtual clock jumps there, a real one sleeps. After a
    lag it catches up, by not sleeping, as much as `/app/player/CompensatePlayDelayInSecs` allows. `manual_mode` acts at
    once; its setting is read after an update has taken its dt, so it acts on the update after that one.
    """

    def __init__(self, settings: Settings, wall_clock: WallClock, step: Fraction) -> None:
        self.wall_clock = wall_clock
        self.manual_step = step
        self.manual_mode = bool(settings.get(keys.MANUAL_MODE))
        self.dt = step
        """The dt of the update that runs or ran last [s]; before the first one the manual step size."""
        self._time = Counter(step)
        self._period = Fraction(1, 60)
        self._began: Fraction | None = None
        self._wanted_mode: bool | None = None
        settings.subscribe(keys.MANUAL_MODE, self._want_mode)
        settings.subscribe(keys.RATE_LIMIT_FREQUENCY, lambda value: self._set_period(settings))
        settings.subscribe(keys.PLAY_DELAY, lambda value: self._set_catch_up(settings))
        self._set_period(settings)
        self._set_catch_up(settings)

    @property
    def time(self) -> Fraction:
        """The sum of all updates' dt since construction [s], playing or not."""
        return self._time.time

    @property
    def period(self) -> Fraction:
        """The duration of an update on the wall clock [s]."""
        return self._period

    def begin(self) -> Fraction:
        """Starts an update; returns its dt [s]: the manual step size, or whole microseconds of wall time."""
        if self.manual_mode:
            dt = self.manual_step
            self._began = None
        else:
            dt = self._measured()
        if self._wanted_mode is not None:
            self.manual_mode, self._wanted_mode = self._wanted_mode, None
        self.dt = dt
        self._time.advance(dt)
        return dt

    def end(self) -> None:
        """Waits until the update has lasted its full time."""
        self.wall_clock.pace(self._period)

    def _measured(self) -> Fraction:
        now = self.wall_clock.now()
        elapsed = self._period if self._began is None else now - self._began
        self._began = now
        return Fraction(math.floor(elapsed * MICROSECONDS), MICROSECONDS)

    def _want_mode(self, value: bool) -> None:
        self._wanted_mode = value

    def _set_period(self, settings: Settings) -> None:
        self._period = 1 / settings.rate(keys.RATE_LIMIT_FREQUENCY)

    def _set_catch_up(self, settings: Settings) -> None:
        self.wall_clock.catch_up = settings.rate(keys.PLAY_DELAY)


FIRST = -1000
"""Order among the subscribers of an event: before all others."""


class Speed:
    """Simulated over wall time, since the first update after play or resume; constant while the timeline holds."""

    def __init__(self, now: Callable[[], Fraction]) -> None:
        self._now = now
        self._began: tuple[Fraction, Fraction] | None = None
        self._held: Fraction | None = None

    def begin(self, simulated: Fraction) -> None:
        """The first update after play or resume, at monotonic simulation time `simulated` [s]."""
        self._began, self._held = (simulated, self._now()), None

    def hold(self, simulated: Fraction) -> None:
        """Pause or stop."""
        self._held, self._began = self.ratio(simulated), None

    def ratio(self, simulated: Fraction) -> Fraction | None:
        """Simulated seconds per second of wall time; None if nothing was measured."""
        if self._began is None:
            return self._held
        start, began = self._began
        passed = self._now() - began
        return (simulated - start) / passed if passed > 0 else None


def follow_timeline(
    speed: Speed, clock: PhysicsClock, loop: RunLoop, settings: Settings, phases: Phases, *, switches_mode: bool
) -> None:
    """Measures while the timeline plays.

    `switches_mode`: the loop then takes manual steps, and measured ones otherwise.
    """
    ends: list[Unsubscribe] = []

    def start() -> None:
        while ends:
            ends.pop()()
        speed.begin(clock.monotonic)

    def begin() -> None:
        ends.append(phases.on("timeline", start, FIRST))  # warm-up steps and the building of the world are not measured
        if switches_mode:
            loop.manual_mode = True
            settings.set_default(keys.MANUAL_MODE, True)

    def hold() -> None:
        if ends:
            ends.pop()()
        else:
            speed.hold(clock.monotonic)
        if switches_mode:
            loop.manual_mode = False
            settings.set_default(keys.MANUAL_MODE, False)

    for event, callback in (("play", begin), ("resume", begin), ("pause", hold), ("stop", hold)):
        phases.on(event, callback, FIRST)
