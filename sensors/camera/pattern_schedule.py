"""When which pattern of a projector is on: exact times, over and over."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from graph.base.records import dataclass
from sensors.errors import SensorValueError

Rational = tuple[int, int]
"""Numerator and denominator of a time [s]."""


@dataclass(frozen=True)
class PatternSchedule:
    """starts: when each pattern begins, the first at 0, rising [s]; period: after which the first begins again [s]."""

    starts: tuple[Fraction, ...]
    period: Fraction

    def active(self, time: Fraction) -> int:
        """The number of the pattern that is on at a time [s]."""
        return bisect_right(self.starts, time % self.period) - 1

    @property
    def shortest(self) -> Fraction:
        """The shortest time for which a pattern is on [s]."""
        return min(after - before for before, after in pairwise((*self.starts, self.period)))


def pattern_schedule(
    timestamps: Sequence[Rational] | None, period: Rational | None, count: int, where: str
) -> PatternSchedule:
    """The schedule of `count` patterns.

    timestamps: numerator and denominator of each start [s]; None: 30 patterns a second. period: None: the last start
    and the first interval; 1/30 s for one pattern. Raises SensorValueError, naming `where`.
    """
    given = [(number, 30) for number in range(count)] if timestamps is None else timestamps
    if not isinstance(given, (list, tuple)) or len(given) != count:
        raise SensorValueError(f"{where}: projector_timestamps {given!r}: give {count} (numerator, denominator) [s]")
    starts = tuple(_fraction(each, f"{where}: projector_timestamps[{place}]") for place, each in enumerate(given))
    if starts[0] != 0:
        raise SensorValueError(f"{where}: projector_timestamps[0] is {starts[0]} s; the first pattern begins at (0, 1)")
    for place, (before, after) in enumerate(pairwise(starts), start=1):
        if after <= before:
            raise SensorValueError(f"{where}: projector_timestamps[{place}] is {after} s, not after {before} s")
    if period is None:
        return PatternSchedule(starts, starts[-1] + starts[1] if count > 1 else Fraction(1, 30))
    found = _fraction(period, f"{where}: projector_cycle_period")
    if found <= starts[-1]:
        raise SensorValueError(f"{where}: projector_cycle_period is {found}; the last pattern begins at {starts[-1]} s")
    return PatternSchedule(starts, found)


def _fraction(value: object, where: str) -> Fraction:
    if isinstance(value, (list, tuple)) and len(value) == 2 and all(type(part) is int for part in value) and value[1]:
        return Fraction(value[0], value[1])
    raise SensorValueError(f"{where} is {value!r}; give two whole numbers, (numerator, denominator) [s]")
