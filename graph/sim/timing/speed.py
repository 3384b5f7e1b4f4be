"""Reacts to the start and hold of an App's timeline: measures its speed, switches the loop's manual mode."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from graph.sim import settings as keys
from graph.sim.phases import Phases, Unsubscribe
from graph.sim.settings import Settings

from .clocks import PhysicsClock
from .run_loop import RunLoop

FIRST = -1000
"""Order among the subscribers of an event: before all others."""


class Speed:
    """Simulated over wall time, since the first update after play or resume; constant while the timeline holds."""

    def __init__(self, now: Callable[[], Fraction]) -> None:
        self._now = now
        self._began: tuple[Fraction, Fraction] | None = None
        self._held: Fraction | None = None

    def begin(self, simulated: Fraction) -> None:
        """The first update after play or resume, at monotonic simulation time `simulated` [s]."""
        self._began, self._held = (simulated, self._now()), None

    def hold(self, simulated: Fraction) -> None:
        """Pause or stop."""
        self._held, self._began = self.ratio(simulated), None

    def ratio(self, simulated: Fraction) -> Fraction | None:
        """Simulated seconds per second of wall time; None if nothing was measured."""
        if self._began is None:
            return self._held
        start, began = self._began
        passed = self._now() - began
        return (simulated - start) / passed if passed > 0 else None


def follow_timeline(
    speed: Speed, clock: PhysicsClock, loop: RunLoop, settings: Settings, phases: Phases, *, switches_mode: bool
) -> None:
    """Measures while the timeline plays.

    `switches_mode`: the loop then takes manual steps, and measured ones otherwise.
    """
    ends: list[Unsubscribe] = []

    def start() -> None:
        while ends:
            ends.pop()()
        speed.begin(clock.monotonic)

    def begin() -> None:
        ends.append(phases.on("timeline", start, FIRST))  # warm-up steps and the building of the world are not measured
        if switches_mode:
            loop.manual_mode = True
            settings.set_default(keys.MANUAL_MODE, True)

    def hold() -> None:
        if ends:
            ends.pop()()
        else:
            speed.hold(clock.monotonic)
        if switches_mode:
            loop.manual_mode = False
            settings.set_default(keys.MANUAL_MODE, False)

    for event, callback in (("play", begin), ("resume", begin), ("pause", hold), ("stop", hold)):
        phases.on(event, callback, FIRST)
