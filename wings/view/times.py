"""When messages came: every topic's stamps beside its sensor's ticks, and the three clocks."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from graph.base.exact import NANOSECONDS, rate
from graph.sim.messages.message import RATE, SENSOR

MOST = 20_000
"""Stamps of a topic that are kept."""
DRAWN = 4_000
"""Ticks of a row that the page draws."""


@dataclass(slots=True)
class Times:
    """The stamps and the log times [ns] of a topic; rate: that of its sensor [Hz], None without one."""

    topic: str
    metadata: Mapping[str, str]
    stamps: array[int] = field(default_factory=lambda: array("q"))
    logged: array[int] = field(default_factory=lambda: array("q"))

    def add(self, stamp_ns: int, time_ns: int) -> None:
        """Takes the times of a message."""
        if len(self.stamps) < MOST:
            self.stamps.append(stamp_ns)
            self.logged.append(time_ns)

    def data(self) -> dict[str, Any]:
        """What the page draws: messages, and the ticks between the first and the last that are without one."""
        return {
            "name": self.topic,
            "sensor": self.metadata.get(SENSOR, ""),
            "t": [one / 1e9 for one in self.stamps[:DRAWN]],
            "missing": [float(one) for one in self.missing()[:DRAWN]],
            "more": max(0, len(self.stamps) - DRAWN),
        }

    def missing(self) -> list[Fraction]:
        """The ticks k / rate [s] between the first and the last stamp that no message belongs to."""
        try:
            hertz = rate(self.metadata[RATE])
        except (KeyError, ValueError):
            return []
        if hertz <= 0 or len(self.stamps) < 2:
            return []
        numbers = [Fraction(one, NANOSECONDS) * hertz + Fraction(1, 10**6) for one in self.stamps]
        present = {one.__floor__() for one in numbers}
        first, last = min(present), max(present)
        if last - first > MOST:
            return []
        return [Fraction(one) / hertz for one in range(first, last + 1) if one not in present]


def clocks(report: Mapping[str, Any] | None, topics: Mapping[str, Times]) -> list[dict[str, Any]]:
    """Rows of the three clocks: updates of the timeline, physics steps, updates in which a sensor's frame came.

    The rates are the report's; without it the updates are those of /clock.
    """
    rows = []
    for name, key, counted in (
        ("timeline: updates", "loop_hz", "updates"),
        ("physics: steps", "physics_hz", "physics_steps"),
    ):
        try:
            hertz, count = rate(str((report or {})[key])), int((report or {})[counted])
        except (KeyError, ValueError, TypeError):
            continue
        if hertz > 0:
            shown = min(count, DRAWN)
            times = [float(Fraction(number) / hertz) for number in range(1, shown + 1)]
            rows.append({"name": f"{name}, {float(hertz):g} Hz", "t": times, "more": count - shown})
    if not rows and "/clock" in topics:
        rows.append({"name": "clock", "t": [one / 1e9 for one in topics["/clock"].logged[:DRAWN]], "more": 0})
    frames = sorted({one for topic in topics.values() if SENSOR in topic.metadata for one in topic.logged})
    if frames:
        row = {"name": "renderer: updates with frames", "t": [one / 1e9 for one in frames[:DRAWN]]}
        rows.append({**row, "more": max(0, len(frames) - DRAWN)})
    return rows
