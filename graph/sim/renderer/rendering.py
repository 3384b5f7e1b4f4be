"""The rendering side of an App: its sensor scheduler, and the calls of Isaac Sim's RenderingManager."""

from __future__ import annotations

from enum import StrEnum
from fractions import Fraction
from itertools import count
from typing import TYPE_CHECKING

from graph.base import exact
from graph.sim import settings as keys
from graph.sim.managers.callbacks import CallbackList, Event, Held, Registered, dropped_early
from graph.sim.timing.clocks import checked_rate

from .products import RenderProduct, SensorRuntime
from .scheduler import SensorScheduler

if TYPE_CHECKING:
    from graph.sim.app import App

__all__ = ["NEW_FRAME", "FrameEvent", "RenderProduct", "Rendering", "RenderingEvent", "SensorRuntime"]


class RenderingEvent(StrEnum):
    """The rendering events: NEW_FRAME fires in an update that delivered frames, before the writers get them."""

    NEW_FRAME = "isaacsim.rendering.new_frame"


NEW_FRAME = RenderingEvent.NEW_FRAME


class FrameEvent(Event):
    """What a NEW_FRAME callback is told."""

    @property
    def products(self) -> tuple[RenderProduct, ...]:
        """The products with a new frame, in the order of their creation."""
        products: tuple[RenderProduct, ...] = self.payload["products"]
        return products


class Rendering(SensorScheduler):
    """Render products and their schedule, dt of the run loop, NEW_FRAME callbacks."""

    def __init__(self, app: App) -> None:
        super().__init__(app.simulation.clock, None, lambda: app.loop_time)
        self._app = app
        self._callbacks = CallbackList()
        self._ids = count()

    def set_dt(self, dt: float | Fraction) -> None:
        """Makes every update last `dt` [s] on all that follows the loop: manual step and mode, time codes per second.

        The rate limit and the target frame rate follow always, or only while rate limiting is on (see
        `graph.sim.timing.parity`). The physics rate and the catch-up cap stay. Raises ValueError unless dt > 0.
        """
        step = exact.duration(dt)
        if step <= 0:
            raise ValueError(f"dt {dt}: give a time step above 0 s (1e-9 s at least)")
        app, settings = self._app, self._app.settings
        frequency = checked_rate(1 / step, "loop")
        app.loop.set_manual_step_size(step)
        app.loop.set_manual_mode(True)
        if settings.get(keys.SET_DT_RATE_LIMIT) or settings.get(keys.RATE_LIMIT_ENABLED):
            settings.set(keys.RATE_LIMIT_FREQUENCY, frequency.numerator if frequency.denominator == 1 else frequency)
            app.timeline.set_target_framerate(frequency)
        app.stage.SetTimeCodesPerSecond(float(frequency))
        app.timeline.set_time_codes_per_second(frequency)
        period = step.limit_denominator(10**9)
        settings.set("/app/settings/fabricDefaultSimPeriodNumerator", period.numerator)
        settings.set("/app/settings/fabricDefaultSimPeriodDenominator", period.denominator)

    def get_dt(self) -> float:
        """The dt of an update [s]: the rate limit's if that is on, else the manual step if manual, else the limit's."""
        settings, loop = self._app.settings, self._app.run_loop
        if loop.manual_mode and not settings.get(keys.RATE_LIMIT_ENABLED):
            return float(loop.manual_step)
        return float(1 / settings.rate(keys.RATE_LIMIT_FREQUENCY))

    def render(self) -> None:
        """One app update without physics; a playing timeline still moves, so it leads the physics from then on.

        `/app/player/playSimulations` is false meanwhile, and what it was afterwards, also where the update raises.
        """
        settings = self._app.settings
        if not settings.get(keys.PLAY_SIMULATIONS):
            self._app.update()
            return
        settings.set(keys.PLAY_SIMULATIONS, False)
        try:
            self._app.update()
        finally:
            settings.set(keys.PLAY_SIMULATIONS, True)

    async def render_async(self) -> None:
        """As `render`; others waiting for the next update resume too."""
        settings = self._app.settings
        if not settings.get(keys.PLAY_SIMULATIONS):
            await self._app.next_update_async()
            return
        settings.set(keys.PLAY_SIMULATIONS, False)
        try:
            await self._app.next_update_async()
        finally:
            settings.set(keys.PLAY_SIMULATIONS, True)

    def register_callback(
        self, event: str, *misplaced: object, callback: Registered | None = None, order: int = 0
    ) -> int:
        """Calls `callback(event)`, event a `FrameEvent`, in each update that delivered a frame; returns an id.

        Lower order first, ties in the order of registration; ids count up from 0 and are never used again. A bound
        method is held weakly: it ends with its object. Raises ValueError for another event than NEW_FRAME, and where
        event and callback have changed places (the SimulationManager takes the callback first).
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
        uid = next(self._ids)

        def died(called: bool) -> None:
            self._callbacks.remove(uid)
            if not called:
                self._app.warn("callback-dropped", f"rendering callback {uid}", dropped_early(uid))

        self._callbacks.add(uid, Held(callback, died), order)
        return uid

    def deregister_callback(self, uid: int) -> None:
        """Ends a callback; an unknown id is a warning."""
        if not self._callbacks.remove(uid):
            self._app.warn("unknown-callback", "rendering", f"there is no callback with id {uid}")

    def deregister_all_callbacks(self) -> None:
        """Ends all callbacks."""
        self._callbacks.clear()

    def hand_over(self) -> None:
        """Gives this update's frames to the NEW_FRAME callbacks and then to the products' writers."""
        if self._callbacks:
            self._callbacks(FrameEvent(NEW_FRAME, {"products": tuple(self.new_frames)}))
        for product in tuple(self.new_frames):
            for writer in tuple(product.writers):
                writer(product.frame)
