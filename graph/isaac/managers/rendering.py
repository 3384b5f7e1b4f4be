"""`app.rendering` in Isaac Sim's names: its RenderingManager over the sensor scheduler of one App."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from fractions import Fraction
from itertools import count
from typing import Any, Protocol

from graph.base import exact
from graph.base.errors import RunError
from graph.base.suggesting import Suggesting
from graph.sim import settings as keys
from graph.sim.renderer.products import RenderProduct
from graph.sim.renderer.scheduler import SensorScheduler
from graph.sim.settings import Settings
from graph.sim.timing.clocks import PhysicsClock, checked_rate
from graph.sim.timing.run_loop import RunLoop
from graph.sim.timing.timeline import Timeline

from .callbacks import CallbackList, Event, Held, Registered, dropped_early
from .loop_runner import LoopRunner

__all__ = ["NEW_FRAME", "FrameEvent", "RenderProduct", "Rendering", "RenderingEvent"]


class RenderingEvent(StrEnum):
    """The rendering events: NEW_FRAME fires in an update that delivered frames, before the writers get them."""

    NEW_FRAME = "isaacsim.rendering.new_frame"


NEW_FRAME = RenderingEvent.NEW_FRAME


class FrameEvent(Event):
    """The argument of a NEW_FRAME callback."""

    @property
    def products(self) -> tuple[RenderProduct, ...]:
        """The products with a new frame, in the order of their creation."""
        products: tuple[RenderProduct, ...] = self.payload["products"]
        return products


class Updates(Protocol):
    """The interface that runs the updates of `render`."""

    def update(self) -> None:
        """Runs one update."""

    async def next_update_async(self) -> float:
        """Waits for the next update and triggers it."""


class Rendering(SensorScheduler, Suggesting):
    """The sensor scheduler with the RenderingManager's calls: dt of an update, updates without physics, callbacks."""

    def __init__(
        self,
        clock: PhysicsClock,
        run_loop: RunLoop,
        timeline: Timeline,
        settings: Settings,
        stage: Any,
        warn: Callable[[str, str, str], None],
    ) -> None:
        super().__init__(clock, None, lambda: run_loop.time)
        self.updates: Updates | None = None
        """Runs the updates of `render`; None before the driver exists, and after the App is closed."""
        self._run_loop, self._timeline, self._settings = run_loop, timeline, settings
        self._stage, self._warn = stage, warn
        self._time_codes: float | None = None
        self._callbacks = CallbackList()
        self._ids = count()

    def hand_over(self) -> None:
        """Gives this update's frames to the NEW_FRAME callbacks and then to the products' writers."""
        if self._callbacks:
            self._callbacks(FrameEvent(NEW_FRAME, {"products": tuple(self.new_frames)}))
        super().hand_over()

    # -- the run loop ------------------------------------------------------------------------------------------------

    def set_dt(self, dt: float | Fraction) -> None:
        """Makes every update last `dt` [s] for everything that follows the loop: manual step and mode, time codes per
        second.

        The rate limit and the target frame rate follow always, or only while rate limiting is on (see
        `graph.sim.settings`). The physics rate and the catch-up cap stay. Raises ValueError unless dt > 0.
        """
        step = exact.duration(dt)
        if step <= 0:
            raise ValueError(f"dt {dt}: give a time step above 0 s (1e-9 s at least)")
        settings, loop = self._settings, LoopRunner(self._run_loop, self._settings)
        frequency = checked_rate(1 / step, "loop")
        loop.set_manual_step_size(step)
        loop.set_manual_mode(True)
        if settings.get(keys.SET_DT_RATE_LIMIT) or settings.get(keys.RATE_LIMIT_ENABLED):
            settings.set(keys.RATE_LIMIT_FREQUENCY, frequency.numerator if frequency.denominator == 1 else frequency)
            self._timeline.set_target_framerate(frequency)
        self._time_codes = float(frequency)
        self.keep_time_codes()
        self._timeline.set_time_codes_per_second(frequency)
        period = step.limit_denominator(10**9)
        settings.set("/app/settings/fabricDefaultSimPeriodNumerator", period.numerator)
        settings.set("/app/settings/fabricDefaultSimPeriodDenominator", period.denominator)

    def keep_time_codes(self) -> None:
        """Authors again, after a stop has restored the stage, the time codes per second that `set_dt` has set."""
        if self._time_codes is not None and self._stage.GetTimeCodesPerSecond() != self._time_codes:
            self._stage.SetTimeCodesPerSecond(self._time_codes)

    def take_stage(self, stage: Any) -> None:
        """As `SensorScheduler.take_stage`; `set_dt` writes to the new stage."""
        super().take_stage(stage)
        self._stage = stage

    def get_dt(self) -> float:
        """The dt of an update [s]: the rate limit's if that is on, else the manual step in manual mode, else the
        limit's.
        """
        settings, loop = self._settings, self._run_loop
        if loop.manual_mode and not settings.get(keys.RATE_LIMIT_ENABLED):
            return float(loop.manual_step)
        return float(1 / settings.rate(keys.RATE_LIMIT_FREQUENCY))

    def render(self) -> None:
        """Runs one app update without physics, in which sensors of tickRate 0 render what is there now.

        A playing timeline still advances, so it is ahead of physics from then on.
        `/app/player/playSimulations` is false during the update; its old value is restored, also if the update raises.
        """
        updates = self._updates()
        with self._without_physics():
            updates.update()

    async def render_async(self) -> None:
        """As `render`; other coroutines that wait for the next update resume too."""
        updates = self._updates()
        with self._without_physics():
            await updates.next_update_async()

    @contextmanager
    def _without_physics(self) -> Iterator[None]:
        settings = self._settings
        simulated = settings.get(keys.PLAY_SIMULATIONS)
        idle = self.autotrigger_idle
        settings.set(keys.PLAY_SIMULATIONS, False)
        self.autotrigger_idle = True
        try:
            yield
        finally:
            self.autotrigger_idle = idle
            settings.set(keys.PLAY_SIMULATIONS, simulated)

    def _updates(self) -> Updates:
        if self.updates is None:
            raise RunError("the App is closed; make a new one")
        return self.updates

    # -- callbacks ---------------------------------------------------------------------------------------------------

    def register_callback(
        self, event: str, *misplaced: object, callback: Registered | None = None, order: int = 0
    ) -> int:
        """Calls `callback(event)`, event a `FrameEvent`, in each update that delivered a frame; returns an id.

        Lower order first, ties in the order of registration; ids count up from 0 and are never reused. A bound method
        is held weakly: it ends with its object. Raises ValueError for any other event than NEW_FRAME, and if the
        arguments are swapped (the SimulationManager takes the callback first).
        """
        if callable(event) or misplaced:
            raise ValueError(
                "the RenderingManager takes register_callback(event, callback=function): the event first, the callback "
                "by its name (the SimulationManager takes callback, event)"
            )
        if event != NEW_FRAME:
            raise ValueError(f"there is no rendering event {event!r}; the one there is: {NEW_FRAME.value!r}")
        if not callable(callback):
            raise ValueError(f"callback {callback!r} cannot be called; give callback=function")
        order = exact.count(order, "order")
        uid = next(self._ids)

        def died(called: bool) -> None:
            self._callbacks.remove(uid)
            if not called:
                self._warn("callback-dropped", f"rendering callback {uid}", dropped_early(uid))

        self._callbacks.add(uid, Held(callback, died), order)
        return uid

    def deregister_callback(self, uid: int) -> None:
        """Removes a callback; an unknown id gives a warning."""
        if not self._callbacks.remove(uid):
            self._warn("unknown-callback", "rendering", f"there is no callback with id {uid}")

    def deregister_all_callbacks(self) -> None:
        """Removes all callbacks."""
        self._callbacks.clear()

    def close(self) -> None:
        """Ends callbacks and updates; products can still be read."""
        super().close()
        self._callbacks.clear()
        self.updates = None
