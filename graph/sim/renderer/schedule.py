"""When sensors tick: pure arithmetic on exact times, no clock, no optics.

A sensor of rate r ticks at the grid times k / r, k = 1, 2, ... from simulation time 0. An update in which the external
time goes from T0 to T renders it once if floor(T * r) > floor(T0 * r), for the newest k; skipped grid times are counted
in `missed`. Its first tick is the first k / r after its creation; for an accumulating lidar the first k whose whole
scan [(k - 1) / r, k / r) lies at or after it.

On the physics clock T = steps / steps_per_second, so a bound schedule works on integer step counts alone.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .view import WorldView

NEVER = 2**200
"""A step count or tick index that no run reaches."""


class Tick:
    """One output of a sensor: the interval it covers and the external time of the update that renders it.

    `index` is k on the sensor's grid (0 for a sensor that renders every update); `poses` is the captured state that a
    frozen sensor uses, None for the current state; `seen` is the external time [s] of that state. `scene` is the world
    that is measured, given by who renders the tick. `held` says that the world is captured as it stands, off the grid:
    the interval has length 0, and a scanning sensor gives one whole scan of the present state.
    """

    __slots__ = ("_end", "_start", "held", "index", "poses", "rate", "scene", "seen", "time")
    scene: WorldView

    def __init__(
        self,
        index: int,
        rate: Fraction,
        time: Fraction,
        start: Fraction | None = None,
        end: Fraction | None = None,
        poses: Any = None,
        *,
        held: bool = False,
    ) -> None:
        self.index = index
        self.rate = rate
        self.time = time
        self._start = start
        self._end = end
        self.poses = poses
        self.seen = time
        self.held = held

    @property
    def start(self) -> Fraction:
        """Begin of the interval [s]: (k - 1) / r, or the last output of a sensor that renders every update."""
        if self._start is None:
            self._start = (self.index - 1) / self.rate
        return self._start

    @property
    def end(self) -> Fraction:
        """End of the interval [s]: k / r, or `time` for a sensor that renders every update."""
        if self._end is None:
            self._end = self.index / self.rate
        return self._end

    def __repr__(self) -> str:
        return f"Tick(index={self.index}, start={self.start}, end={self.end}, time={self.time})"


class TickSchedule:
    """The ticks of one sensor of rate `rate` [Hz] created at external time `created_at` [s]."""

    __slots__ = (
        "_denominator",
        "_numerator",
        "_step_rate",
        "accumulates",
        "created_at",
        "due_step",
        "first_index",
        "index",
        "missed",
        "next_due",
        "rate",
    )

    def __init__(self, rate: Fraction, created_at: Fraction = Fraction(0), *, accumulates: bool = False) -> None:
        if rate <= 0:
            raise ValueError(f"a tick schedule needs a rate above 0 Hz, not {rate}; rate 0 is EveryUpdate")
        self.rate = Fraction(rate)
        self.accumulates = accumulates
        self._step_rate: Fraction | None = None
        self._numerator = self._denominator = 1
        self.due_step = NEVER
        self.restart(created_at)

    def restart(self, created_at: Fraction) -> None:
        """Restarts for a sensor created at `created_at`; nothing is rendered or missed yet."""
        self.created_at = created_at
        position = created_at * self.rate
        self.first_index = max(1, math.ceil(position) + 1 if self.accumulates else math.floor(position) + 1)
        self.index = self.first_index - 1
        self.missed = 0
        self._set_due()

    def advance(self, time: Fraction) -> Tick | None:
        """The tick to render at external time `time`, or None; then waits for the next tick."""
        return None if time < self.next_due else self._take(math.floor(time * self.rate), time)

    def bind(self, steps_per_second: Fraction) -> None:
        """From now on measures external time in steps: sets `due_step`, the first step count at which a tick is due."""
        if steps_per_second != self._step_rate:
            self._step_rate = steps_per_second
            self._numerator = self.rate.numerator * steps_per_second.denominator
            self._denominator = self.rate.denominator * steps_per_second.numerator
        self._set_due()

    def newest(self, steps: int) -> int:
        """The newest grid index at or before step count `steps` (bound schedules)."""
        return steps * self._numerator // self._denominator

    def state_step(self, index: int) -> int:
        """The first step count at or after grid time index / rate: ceil(index / r * sps) (bound schedules)."""
        return -(-index * self._denominator // self._numerator)

    def advance_steps(self, steps: int) -> Tick | None:
        """`advance` for external time = `steps` / steps per second (bound schedules)."""
        if steps < self.due_step:
            return None
        assert self._step_rate is not None
        rate = self._step_rate
        return self._take(self.newest(steps), Fraction(steps * rate.denominator, rate.numerator))

    def _take(self, newest: int, time: Fraction) -> Tick | None:
        if newest <= self.index:
            return None
        self.missed += newest - self.index - 1
        self.index = newest
        self._set_due()
        return Tick(newest, self.rate, time)

    def _set_due(self) -> None:
        self.next_due = (self.index + 1) / self.rate
        if self._step_rate is not None:
            self.due_step = self.state_step(self.index + 1)


class EveryUpdate:
    """The schedule of a sensor that renders in every update in which external time advanced.

    Its ticks cover (last output, T]; the first one starts at the creation.
    """

    __slots__ = ("created_at", "index", "last", "missed", "rate")

    accumulates = False

    def __init__(self, created_at: Fraction = Fraction(0), rate: Fraction = Fraction(0)) -> None:
        self.rate = rate
        self.restart(created_at)

    def restart(self, created_at: Fraction) -> None:
        """Restarts for a sensor created at `created_at`."""
        self.created_at = self.last = created_at
        self.missed = 0
        self.index = 0

    def advance(self, time: Fraction) -> Tick | None:
        """The tick that ends at `time`, or None if the time has not advanced."""
        if time <= self.last:
            return None
        start, self.last = self.last, time
        return Tick(0, self.rate, time, start, time)

    def repeat(self, time: Fraction) -> Tick:
        """A tick over an interval of length 0, for an update in which the time has not advanced."""
        return Tick(0, self.rate, time, time, time)
