"""The run loop's own clock: the dt of an update and its duration on the wall clock."""

from __future__ import annotations

import math
from fractions import Fraction

from graph.sim import settings as keys
from graph.sim.settings import Settings

from .clocks import MICROSECONDS, Counter
from .wall_clock import WallClock


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
