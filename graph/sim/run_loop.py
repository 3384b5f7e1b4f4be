"""The run loop's own clock: the dt of an update and how long an update lasts on the wall clock."""

from __future__ import annotations

import math
from fractions import Fraction

from . import settings as keys
from .clocks import Counter
from .settings import Settings
from .wall_clock import WallClock

MICROSECONDS = 1_000_000


class RunLoop:
    """Manual mode gives every update the manual step size; else dt is the wall time since the last update began.

    An update lasts 1 / rateLimitFrequency on the wall clock: a virtual clock jumps there, a real one sleeps.
    """

    def __init__(self, settings: Settings, wall_clock: WallClock, step: Fraction) -> None:
        self.wall_clock = wall_clock
        self.manual_step = step
        self.manual_mode = True
        self._time = Counter(step)
        self._period = Fraction(1, 60)
        self._began: Fraction | None = None
        settings.subscribe(keys.MANUAL_MODE, self._set_manual)
        settings.subscribe(keys.RATE_LIMIT_FREQUENCY, lambda value: self._set_period(settings))
        self._set_manual(settings.get(keys.MANUAL_MODE))
        self._set_period(settings)

    @property
    def time(self) -> Fraction:
        """The sum of all updates' dt since construction [s], playing or not."""
        return self._time.time

    def begin(self) -> Fraction:
        """Starts an update; returns its dt [s]: the manual step size, or whole microseconds of wall time."""
        dt = self.manual_step if self.manual_mode else self._measured()
        self._time.advance(dt)
        return dt

    def end(self) -> None:
        """Waits until the update has lasted its time."""
        self.wall_clock.pace(self._period)

    def _measured(self) -> Fraction:
        now = self.wall_clock.now()
        elapsed = self._period if self._began is None else now - self._began
        self._began = now
        return Fraction(math.floor(elapsed * MICROSECONDS), MICROSECONDS)

    def _set_manual(self, value: bool) -> None:
        self.manual_mode = value
        self._began = None

    def _set_period(self, settings: Settings) -> None:
        self._period = 1 / settings.rate(keys.RATE_LIMIT_FREQUENCY)
