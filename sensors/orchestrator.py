"""The orchestrator: steps of data capture, in Replicator's calls."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Protocol

from graph.base import exact
from graph.base.suggesting import Suggesting
from graph.sim import settings as keys
from graph.sim.renderer.scheduler import SensorScheduler
from graph.sim.settings import Settings
from graph.sim.timing.clocks import checked_rate
from graph.sim.timing.run_loop import RunLoop
from graph.sim.timing.timeline import Timeline


class Stepped(Protocol):
    """The interface that an orchestrator steps: a `graph.sim.driver.Driver`."""

    rendering: SensorScheduler
    timeline: Timeline
    run_loop: RunLoop
    settings: Settings

    def check_drivable(self) -> None:
        """Raises RunError if no update can run."""

    def play(self) -> None:
        """Starts or resumes at once."""

    def pause(self) -> None:
        """Pauses at once."""

    def update(self) -> None:
        """Runs one update."""

    async def next_update_async(self) -> float:
        """Waits for the next update and triggers it."""

    def deliver_frames(self) -> None:
        """Delivers rendered frames that would arrive only with the next update."""

    def warn(self, code: str, where: str, message: str) -> None:
        """Gives a warning."""


class Orchestrator(Suggesting):
    """Steps an App one update at a time; each step returns after the writers have received its frames.

    driver: gives that of the App, at each step.
    """

    def __init__(self, driver: Callable[[], Stepped]) -> None:
        self._driver = driver

    def step(
        self,
        rt_subframes: int = -1,
        pause_timeline: bool = True,
        delta_time: float | Fraction | None = None,
        wait_for_render: bool = True,
    ) -> None:
        """Plays if the timeline does not, runs one app update, hands its frames to writers and post-render graphs.

        `pause_timeline` pauses afterwards; the next step plays on. `delta_time` [s] is the dt of this one update: None
        keeps that of the loop; 0 holds the timeline, and every render product gives a frame of the world as it stands,
        a lidar one whole scan. In fixed stepping other values are ignored: warning `delta-time-ignored`.
        `wait_for_render` matters in the profile `isaacsim-6.0.1`, where frames arrive one update late: they are
        delivered at once. `rt_subframes` above 1 has no effect, because ideal sensors do not converge over subframes:
        warning `rt-subframes-ignored`. Raises ValueError for a negative time or fewer than -1 subframes.
        """
        with self._one_step(rt_subframes, pause_timeline, delta_time, wait_for_render):
            self._driver().update()

    async def step_async(
        self,
        rt_subframes: int = -1,
        pause_timeline: bool = True,
        delta_time: float | Fraction | None = None,
        wait_for_render: bool = True,
    ) -> None:
        """As `step`; other coroutines that wait for the next update resume too."""
        with self._one_step(rt_subframes, pause_timeline, delta_time, wait_for_render):
            await self._driver().next_update_async()

    @contextmanager
    def _one_step(
        self, rt_subframes: int, pause_timeline: bool, delta_time: float | Fraction | None, wait_for_render: bool
    ) -> Iterator[None]:
        driver = self._driver()
        step = None if delta_time is None else exact.duration(delta_time)
        if step is not None and step < 0:
            raise ValueError(f"delta_time {delta_time}: give a time of 0 s or more")
        if rt_subframes < -1:
            raise ValueError(f"rt_subframes {rt_subframes}: give a number of subframes, or -1")
        if rt_subframes > 1:
            message = "ideal sensors have nothing to converge; one rendering of each update is all there is"
            driver.warn("rt-subframes-ignored", "orchestrator.step", message)
        driver.check_drivable()
        if not driver.timeline.is_playing():
            driver.play()
        before, driver.rendering.stepped = driver.rendering.stepped, True
        try:
            with self._lasting(step):
                yield
        finally:
            driver.rendering.stepped = before
        if wait_for_render:
            driver.deliver_frames()
        if pause_timeline and driver.timeline.is_playing():
            driver.pause()

    @contextmanager
    def _lasting(self, step: Fraction | None) -> Iterator[None]:
        """For one update the timeline advances by `step` [s]; None: by its usual step."""
        driver = self._driver()
        if step is None:
            yield
        elif not step:
            moves = driver.timeline.is_auto_updating()
            driver.timeline.set_auto_update(False)
            driver.rendering.capture_held = True
            try:
                yield
            finally:
                driver.rendering.capture_held = False
                driver.timeline.set_auto_update(moves)
        else:
            if driver.settings.get(keys.FIXED_STEPPING):
                message = "in fixed stepping the timeline moves by 1 / timeCodesPerSecond; set that instead"
                driver.warn("delta-time-ignored", "orchestrator.step", message)
            checked_rate(1 / step, "loop")
            loop = driver.run_loop
            manual = loop.manual_mode, loop.manual_step
            loop.manual_mode, loop.manual_step = True, step
            try:
                yield
            finally:
                loop.manual_mode, loop.manual_step = manual
