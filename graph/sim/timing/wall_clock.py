"""The wall clock of an App: virtual (reproducible, as fast as the machine) or real (paced)."""

from __future__ import annotations

import math
import time
from fractions import Fraction
from typing import Protocol

NANOSECONDS = 1_000_000_000


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
