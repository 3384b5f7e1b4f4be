"""The wall clock an App is given: virtual (reproducible, as fast as the machine) or real (paced)."""

from __future__ import annotations

import time
from fractions import Fraction
from typing import Protocol


class WallClock(Protocol):
    """What an App asks of a wall clock."""

    def now(self) -> Fraction:
        """UNIX time [s]."""

    def wait_until(self, moment: Fraction) -> None:
        """Returns when `now()` has reached `moment` (at once if it already has)."""


class VirtualClock:
    """Moves only when waited on: two runs read the same times. Starts at `start` [s] (default 0, 1970-01-01)."""

    def __init__(self, start: Fraction | int = 0) -> None:
        self._now = Fraction(start)

    def now(self) -> Fraction:
        """The virtual UNIX time [s]."""
        return self._now

    def wait_until(self, moment: Fraction) -> None:
        """Jumps to `moment`; never goes back."""
        if moment > self._now:
            self._now = moment


class RealClock:
    """The machine's clock: UNIX time at construction plus what the steady clock has counted since."""

    def __init__(self) -> None:
        self._origin_ns = time.time_ns() - time.monotonic_ns()

    def now(self) -> Fraction:
        """UNIX time [s] in whole nanoseconds; never steps back."""
        return Fraction(self._origin_ns + time.monotonic_ns(), 1_000_000_000)

    def wait_until(self, moment: Fraction) -> None:
        """Sleeps until `moment`."""
        remaining = moment - self.now()
        if remaining > 0:
            time.sleep(float(remaining))
