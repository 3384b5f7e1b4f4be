"""Exact clocks: the number of physics steps in an update, and the time after them.

Every value is an integer count of an exact step, so nothing drifts; fractions are made when a value is read.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

from graph.base.errors import RunError, UserError

MICROSECONDS = 1_000_000
MAX_NANOSECONDS = 2**63 - 1
"""Stamps are int64 nanoseconds: about 292 years."""


def checked_rate(value: Fraction, what: str) -> Fraction:
    """`value` if it is valid for a clock. Raises UserError unless 10**-9 <= value <= 10**9 Hz."""
    if not Fraction(1, 10**9) <= value <= 10**9:
        raise UserError(f"{what}: {float(value):g} Hz is not a rate that can be run; give one above 0 (up to 1e9)")
    return value


class Counter:
    """A time that grows in equal exact steps: `base + count * step` [s]; a new step starts a new segment."""

    __slots__ = ("base", "count", "step")

    def __init__(self, step: Fraction, base: Fraction = Fraction(0)) -> None:
        self.step = step
        self.base = base
        self.count = 0

    @property
    def time(self) -> Fraction:
        """The exact time [s]."""
        base, step = self.base, self.step  # one new fraction instead of two
        ticks = base.numerator * step.denominator + self.count * step.numerator * base.denominator
        return Fraction(ticks, base.denominator * step.denominator)

    def advance(self, step: Fraction, count: int = 1) -> None:
        """Adds `count` steps of `step` [s]."""
        if step is not self.step:
            if step != self.step:
                self.base, self.count = self.time, 0
            self.step = step
        self.count += count

    def set(self, time: Fraction) -> None:
        """Sets the clock to `time`."""
        self.base, self.count = time, 0


class Reading(NamedTuple):
    """The values of a physics clock at one moment, as integers; times are computed on request."""

    steps: int
    numerator: int
    denominator: int
    base: Fraction
    start: int

    @property
    def time(self) -> Fraction:
        """Simulation time [s]."""
        return Fraction(self.steps * self.denominator, self.numerator)

    @property
    def monotonic(self) -> Fraction:
        """Monotonic time [s]."""
        return self.base + Fraction((self.steps - self.start) * self.denominator, self.numerator)

    @property
    def microseconds(self) -> int:
        """Simulation time in whole microseconds, rounded down."""
        return self.steps * self.denominator * MICROSECONDS // self.numerator

    def same_time(self, other: Reading) -> bool:
        """Whether both have the same simulation time."""
        return self.steps * self.denominator * other.numerator == other.steps * other.denominator * self.numerator


class PhysicsClock:
    """The physics clock: `count / steps_per_second`, recomputed, never a running sum.

    A new rate applies from the next step on: the whole history is then read at the new rate (the time jumps), and only
    the monotonic time stays continuous. `version` changes whenever the rate of `time` does.
    """

    __slots__ = ("_base", "_denominator", "_limit", "_numerator", "_pending", "_start", "count", "rate", "version")

    def __init__(self, steps_per_second: Fraction) -> None:
        self.count = 0
        self.version = 0
        self._base = Fraction(0)
        self._start = 0
        self._pending = False
        self.rate = steps_per_second
        """The rate of the next step [Hz]."""
        self._adopt()

    @property
    def time(self) -> Fraction:
        """Simulation time [s]."""
        return Fraction(self.count * self._denominator, self._numerator)

    @property
    def seconds(self) -> float:
        """Simulation time [s], correctly rounded."""
        return self.count * self._denominator / self._numerator

    @property
    def monotonic(self) -> Fraction:
        """Time stepped since construction [s]: survives stop and changes of rate."""
        return self._base + Fraction((self.count - self._start) * self._denominator, self._numerator)

    def reading(self) -> Reading:
        """The present values of the clock."""
        return Reading(self.count, self._numerator, self._denominator, self._base, self._start)

    def set_rate(self, steps_per_second: Fraction) -> None:
        """Sets a new rate, used from the next step on."""
        if steps_per_second != self.rate:
            self.rate = steps_per_second
            self._pending = True

    def advance(self, steps: int = 1) -> None:
        """Counts `steps` physics steps. Raises RunError if the time would exceed int64 nanoseconds."""
        if self._pending:
            self._base, self._start = self.monotonic, self.count
            self._adopt()
        count = self.count + steps
        if count > self._limit:
            raise RunError(
                "simulation time would pass 2**63 - 1 ns (292 years), the end of the stamps; stop and play to restart"
            )
        self.count = count

    def reset(self) -> None:
        """Stop: time and count go to 0, monotonic time stays."""
        self._base, self._start, self.count = self.monotonic, 0, 0
        self._adopt()

    def _adopt(self) -> None:
        rate = self.rate
        self._pending = False
        self._numerator, self._denominator = rate.numerator, rate.denominator
        self._limit = MAX_NANOSECONDS * rate.numerator // (rate.denominator * 1_000_000_000)
        self.version += 1


class Accumulator:
    """Turns elapsed time into whole physics steps, exactly: n = floor((elapsed + carry) * steps_per_second).

    With a catch-up cap (`min_frame_rate` > 0) at most M = max(1, floor(sps / min_frame_rate)) steps run in an update
    and at most M steps of time are kept for later, as in PhysX. The hot path uses integers of a common unit.
    """

    def __init__(self, steps_per_second: Fraction, min_frame_rate: int | Fraction = 0) -> None:
        self._rate = steps_per_second
        self._cap: int | None = None
        self._unit = 1  # the carry is counted in 1 / _unit seconds
        self._carry = 0
        self._period = 0
        self._elapsed: Fraction | None = None
        self._ticks = 0
        self.configure(steps_per_second, min_frame_rate)

    @property
    def carry(self) -> Fraction:
        """Time that waits for its step [s], below one step period unless capped."""
        return Fraction(self._carry, self._unit)

    @property
    def cap(self) -> int | None:
        """Most steps in one update; None without a cap."""
        return self._cap

    def configure(self, steps_per_second: Fraction, min_frame_rate: int | Fraction = 0) -> None:
        """Sets a new rate or cap; the carry stays."""
        self._rate = steps_per_second
        self._cap = max(1, int(steps_per_second // min_frame_rate)) if min_frame_rate else None
        self._regrid(1)

    def take(self, elapsed: Fraction) -> int:
        """The number of steps to run after `elapsed` [s] more."""
        if elapsed is not self._elapsed:
            if self._unit % elapsed.denominator:
                self._regrid(elapsed.denominator)
            self._ticks = elapsed.numerator * (self._unit // elapsed.denominator)
            self._elapsed = elapsed
        steps, left = divmod(self._carry + self._ticks, self._period)
        cap = self._cap
        if cap is not None and steps > cap:
            left = min(left + (steps - cap) * self._period, cap * self._period)
            steps = cap
        self._carry = left
        return steps

    def clear(self) -> None:
        """Drops the carry (stop, direct steps)."""
        self._carry = 0

    def _regrid(self, denominator: int) -> None:
        carry = self.carry
        self._unit = math.lcm(denominator, carry.denominator, self._rate.numerator)
        self._carry = carry.numerator * (self._unit // carry.denominator)
        self._period = self._rate.denominator * (self._unit // self._rate.numerator)
        self._elapsed = None
