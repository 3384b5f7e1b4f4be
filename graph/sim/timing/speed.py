"""What an App does when its timeline starts and holds: measure its speed, switch the loop's manual mode."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING

from graph.sim import settings as keys
from graph.sim.phases import Unsubscribe

if TYPE_CHECKING:
    from graph.sim.app import App

FIRST = -1000
"""Order among the subscribers of an event: ahead of all others."""


class Speed:
    """Simulated over wall time, since the first update after play or resume; it stands while the timeline does."""

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
        """Simulated seconds per second of wall time; None where neither was measured."""
        if self._began is None:
            return self._held
        start, began = self._began
        passed = self._now() - began
        return (simulated - start) / passed if passed > 0 else None


def follow_timeline(app: App, speed: Speed) -> None:
    """Measures while the timeline plays; the experience `full` takes manual steps then, and measured ones otherwise."""
    settings, loop = app.settings, app.run_loop
    switches = app.experience == "full" and not settings.is_authored(keys.MANUAL_MODE)

    ends: list[Unsubscribe] = []

    def start() -> None:
        while ends:
            ends.pop()()
        speed.begin(app.simulation.monotonic_time)

    def begin() -> None:
        ends.append(app.on("timeline", start, FIRST))  # warm-up steps and the building of the world are not measured
        if switches:
            loop.manual_mode = True
            settings.set_default(keys.MANUAL_MODE, True)

    def hold() -> None:
        if ends:
            ends.pop()()
        else:
            speed.hold(app.simulation.monotonic_time)
        if switches:
            loop.manual_mode = False
            settings.set_default(keys.MANUAL_MODE, False)

    for event, callback in (("play", begin), ("resume", begin), ("pause", hold), ("stop", hold)):
        app.on(event, callback, FIRST)
