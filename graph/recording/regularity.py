"""How regular the stamps of a topic are, and which ticks of its sensor have no message.

A sensor of rate r ticks at k / r. The message of tick k is stamped from k / r until before (k + 1) / r: at the tick, at
the physics state or at the update that follows it; so floor(stamp r) is its tick, less a constant for scans that are
stamped at their start. Without a sensor the period is the most frequent distance between stamps.
"""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from graph.base.exact import NANOSECONDS, rate
from graph.sim.messages.message import EVERY, RATE, SENSOR

from .sources import WALL_CLOCK_NS

LISTED = 8
"""Most gaps of a topic that are kept."""
_DISTANCES = 10_000
"""Most different distances that are counted; a topic with more has no period."""


@dataclass(slots=True)
class Regularity:
    """The stamps of one topic, given one after another to `add`; memory does not grow with their number.

    sensor, rate: the prim path and rate [Hz] of the sensor that the topic follows; "" and None without one, rate 0 for
    one message in every update. every: ticks for one message.
    """

    sensor: str = ""
    rate: Fraction | None = None
    every: int = 1
    messages: int = 0
    size: int = 0
    """Bytes of the encoded messages."""
    first_ns: int | None = None
    last_ns: int | None = None
    restarts: int = 0
    """Times at which the stamps started again at an earlier time, as after stop and play."""
    repeats: int = 0
    """Messages with the stamp, or of the tick, of the message before."""
    wall: bool = False
    """Whether the stamps are of a wall clock; then the times of publishing count instead."""
    _ticks: int = 0
    _missing: int = 0
    _tick: int | None = None
    _off: tuple[Fraction, Fraction] | None = None
    _distances: Counter[int] = field(default_factory=Counter)
    _longest: list[tuple[int, int]] = field(default_factory=list)

    @classmethod
    def of_channel(cls, metadata: Mapping[str, str]) -> Regularity:
        """For a topic with this metadata of its channel; unreadable metadata is ignored."""
        try:
            hertz, every = rate(metadata[RATE]), int(metadata.get(EVERY, "1"))
        except (KeyError, ValueError):
            return cls()
        return cls(metadata.get(SENSOR, ""), hertz, every) if hertz >= 0 and every > 0 else cls()

    @property
    def scheduled(self) -> bool:
        """Whether its messages belong to ticks at k / rate."""
        return bool(self.rate) and not self.wall

    @property
    def ticks(self) -> int:
        """Ticks that have a message; for a topic without ticks, stamps without repeats."""
        return self._ticks if self.scheduled else self.messages - self.repeats

    @property
    def missing(self) -> int:
        """Ticks without a message, between the first and the last."""
        return self._missing

    @property
    def period_ns(self) -> Fraction | None:
        """The period of the schedule, else the most frequent distance between stamps [ns]; None without one."""
        if self.rate and self.scheduled:
            return NANOSECONDS * self.every / self.rate
        if not self._distances:
            return None
        ((distance, _),) = self._distances.most_common(1)
        near = {one: times for one, times in self._distances.items() if abs(one - distance) <= 1}
        return Fraction(sum(one * times for one, times in near.items()), sum(near.values()))

    @property
    def exact(self) -> bool:
        """Whether every stamp is at the same place of its period, to the nanosecond."""
        period = self.period_ns
        if period is None or self.messages < 2:
            return False
        if self._off is not None and self.scheduled:
            return self._off[1] - self._off[0] <= 1 and not self.repeats
        # Rounded to whole nanoseconds, equal steps differ by one.
        return not self.repeats and all(abs(one - period) <= 1 for one in self._distances)

    @property
    def late_ns(self) -> tuple[int, int] | None:
        """The least and the most time from a tick to its message's stamp [ns]; None without ticks."""
        if self._off is None or not self.scheduled:
            return None
        return round(self._off[0]), round(self._off[1])

    @property
    def distances_ns(self) -> tuple[int, int] | None:
        """The shortest and the longest distance between neighbouring stamps [ns]."""
        return (min(self._distances), max(self._distances)) if self._distances else None

    def gaps(self) -> list[tuple[int, int]]:
        """(stamp before [ns], length [ns]) of the longest gaps, by time: between ticks with ticks missing, without a
        schedule distances over one and a half periods.
        """
        least = 0 if self.scheduled else (self.period_ns or 0) * 3 / 2
        return sorted((at, length) for length, at in self._longest if length > least)

    def add(self, stamp_ns: int, log_ns: int, size: int = 0) -> None:
        """Counts one message. stamp_ns: of its header; log_ns: when it was published."""
        self.messages += 1
        self.size += size
        self.wall = self.wall or stamp_ns >= WALL_CLOCK_NS
        at = log_ns if self.wall else stamp_ns
        before, self.last_ns = self.last_ns, at
        if before is None:
            self.first_ns = at
        elif at < before:
            self.restarts += 1
            self._tick = None
        else:
            self._note_distance(before, at - before)
        if self.scheduled:
            self._note_tick(at, before)

    def _note_distance(self, before: int, distance: int) -> None:
        if not distance:
            self.repeats += 1
            return
        if distance in self._distances or len(self._distances) < _DISTANCES:
            self._distances[distance] += 1
        if not self.scheduled:
            self._note_gap(before, distance)

    def _note_gap(self, before: int, distance: int) -> None:
        place = (distance, before)
        if len(self._longest) < LISTED:
            heapq.heappush(self._longest, place)
        elif distance > self._longest[0][0]:
            heapq.heapreplace(self._longest, place)

    def _note_tick(self, at: int, before: int | None) -> None:
        assert self.rate
        # A stamp is rounded to a whole nanosecond, so it may lie half of one before its tick.
        tick = math.floor((at + 1) * self.rate / NANOSECONDS)
        if tick == self._tick:
            self.repeats += before != at  # an equal stamp is counted already
        else:
            skipped = 0 if self._tick is None else (tick - self._tick) // self.every - 1
            if skipped > 0 and before is not None:
                self._missing += skipped
                self._note_gap(before, at - before)
            self._ticks += 1
        self._tick = tick
        off = at - tick * NANOSECONDS / self.rate
        low, high = self._off or (off, off)
        self._off = min(low, off), max(high, off)
