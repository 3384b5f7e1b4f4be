"""The playhead of a timeline: its time, its range, and what happens at the range's end."""

from __future__ import annotations

import math
from fractions import Fraction

from graph.base import exact
from graph.base.suggesting import Suggesting

from .clocks import Counter


class Playhead(Suggesting):
    """An exact time between a start and an end. At the end it loops back to the start, or stops."""

    def __init__(self, end: Fraction) -> None:
        self._start = Fraction(0)
        self._end = end
        self._looping = True
        self._clock = Counter(Fraction(1, 60))
        # The count of the clock's present segment beyond which the end time is passed.
        self._limit = 0
        self._limit_base: Fraction | None = None
        self._limit_step: Fraction | None = None

    @property
    def current_time(self) -> Fraction:
        """The exact time [s]."""
        return self._clock.time

    def get_current_time(self) -> float:
        """The time [s]."""
        return float(self._clock.time)

    def set_current_time(self, time: float | Fraction) -> None:
        """Moves to `time` [s]. Raises ValueError below 0 and before the start."""
        moment = exact.duration(time)
        if moment < min(self._start, Fraction(0)):
            raise ValueError(f"current time {float(moment):g} s: give 0 s or more")
        self._clock.set(moment)

    @property
    def start_time(self) -> Fraction:
        """The exact time [s] to which stop and loops return."""
        return self._start

    def get_start_time(self) -> float:
        """The time [s] to which stop and loops return."""
        return float(self._start)

    def set_start_time(self, time: float | Fraction) -> None:
        """Sets the start [s]."""
        self._start = exact.duration(time)

    @property
    def end_time(self) -> Fraction:
        """The exact time [s] at which the timeline loops or stops."""
        return self._end

    def get_end_time(self) -> float:
        """The time [s] at which the timeline loops or stops."""
        return float(self._end)

    def set_end_time(self, time: float | Fraction) -> None:
        """Sets the end [s]."""
        self._end = exact.duration(time)
        self._limit_base = None

    def set_range(self, start: Fraction, end: Fraction) -> None:
        """Plays from `start` to `end` [s], and moves to the start."""
        self._start, self._end = start, end
        self._limit_base = None
        self._clock.set(start)

    def is_looping(self) -> bool:
        """Whether it returns to the start at the end; otherwise it stops."""
        return self._looping

    def set_looping(self, looping: bool) -> None:
        """Chooses what happens at the end."""
        self._looping = looping

    def stop(self) -> None:
        """Called at the end of a range that does not loop."""

    def _move(self, step: Fraction) -> None:
        clock = self._clock
        clock.advance(step)
        if clock.base is not self._limit_base or step is not self._limit_step:
            self._limit_base, self._limit_step = clock.base, clock.step
            self._limit = math.floor((self._end - clock.base) / clock.step)
        if clock.count > self._limit:
            self._at_end()

    def _at_end(self) -> None:
        length = self._end - self._start
        if self._looping and length > 0:
            self._clock.set(self._start + (self._clock.time - self._start) % length)
        else:
            self._clock.set(self._end)
            self.stop()
