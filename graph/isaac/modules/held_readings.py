"""Readings of sensors with a period: held from one time of the sensor to the next, as the former sensors of physics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any, Generic, Protocol, TypeVar

from graph.isaac.session import app


class Reading(Protocol):
    """A dataclass of a sensor's reading."""

    time: float
    is_valid: bool


T = TypeVar("T", bound=Reading)


class Held(Generic[T]):
    """Takes a reading at each physics step, and at each time of the sensor interpolates between the last two.

    read: gives the newest reading, a dataclass with `time` [s] and `is_valid`. period: gives the sensor's period [s];
    one that is not longer than a physics step holds nothing. length: gives how many readings are kept.
    """

    def __init__(
        self, read: Callable[[], T], period: Callable[[], float], length: Callable[[], int] = lambda: 20
    ) -> None:
        self._read, self._period, self._length = read, period, length
        self.newest: list[T] = []
        """The readings of the last physics steps, newest first."""
        self.taken: list[T] = []
        """Those of `newest` when the sensor last took one."""
        self._time = Fraction(0)
        present = app()
        ends = [present.on("physics_post_step", self._step), present.on("stop", self.clear)]

        def end() -> None:
            self.clear()
            while ends:
                ends.pop()()

        present.on("stage_closing", end)

    def filled(self) -> list[T]:
        """`taken`, with empty readings up to its length."""
        return [*self.taken, *(type(self._read())() for _ in range(self._length() - len(self.taken)))]

    def clear(self) -> None:
        """Forgets all readings; the sensor's next time is one period after the start."""
        self.newest, self.taken, self._time = [], [], Fraction(0)

    def _steps(self) -> Fraction:
        """The period in physics steps; single precision, in which prims keep it, is not a difference."""
        return Fraction(max(self._period(), 0.0) * float(app().simulation.next_rate)).limit_denominator(1000)

    def _step(self) -> None:
        now, steps = app().simulation.time, self._steps()
        self.newest = [self._read(), *self.newest][: self._length()]
        passed = (now - self._time) * app().simulation.next_rate // steps if steps > 1 else 0
        if passed >= 1:
            self.taken = list(self.newest)
            self._time += passed * steps / app().simulation.next_rate

    def reading(self, interpolate: Callable[[list[T], float], T] | None = None, *, latest: bool = False) -> T:
        """The reading at the sensor's last time; the newest before its first one, for `latest`, and without a period.

        interpolate: gives the reading from those taken (newest first) and the time [s].
        """
        now = self._read()
        if latest or not self.taken or not now.is_valid or self._steps() <= 1:
            return now
        time = float(self._time)
        if interpolate is not None:
            return interpolate(self.filled(), time)
        after = self.taken[0]
        if len(self.taken) > 1 and time < after.time:
            after = between(self.taken[1], after, time)
        return after


def between(before: Any, after: Any, time: float) -> Any:
    """The reading at a time between two: numbers change linearly, everything else is that of the second."""
    if not before.is_valid:
        return after
    share = (time - before.time) / (after.time - before.time)
    names = [one.name for one in fields(after) if isinstance(getattr(after, one.name), float)]
    values = {name: getattr(before, name) + share * (getattr(after, name) - getattr(before, name)) for name in names}
    return replace(after, **{**values, "time": time})
