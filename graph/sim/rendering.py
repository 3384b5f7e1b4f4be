"""The rendering side of an App: its sensor scheduler, and the calls of Isaac Sim's RenderingManager."""

from __future__ import annotations

import inspect
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import count
from typing import TYPE_CHECKING, Any

from graph import exact

from . import settings as keys
from .products import RenderProduct, SensorRuntime
from .scheduler import SensorScheduler

if TYPE_CHECKING:
    from .app import App

__all__ = ["NEW_FRAME", "RenderProduct", "Rendering", "RenderingEvent", "SensorRuntime"]

NEW_FRAME = "isaacsim.rendering.new_frame"


@dataclass(frozen=True, slots=True)
class RenderingEvent:
    """What a rendering callback is told: the event and the products with a new frame."""

    event: str
    products: tuple[RenderProduct, ...]

    NEW_FRAME = NEW_FRAME


class Rendering(SensorScheduler):
    """Render products and their schedule, dt of the run loop, NEW_FRAME callbacks."""

    def __init__(self, app: App) -> None:
        super().__init__(app.simulation.clock, None, lambda: app.loop_time)
        self._app = app
        self._callbacks: list[tuple[int, int, Callable[[], Callable[[RenderingEvent], object] | None]]] = []
        self._ids = count()

    def set_dt(self, dt: float | Fraction) -> None:
        """Makes every update last `dt` [s]: manual loop step, rate limit, target frame rate and time codes per second.

        The physics rate stays. Raises ValueError unless dt > 0.
        """
        step = exact.duration(dt)
        if step <= 0:
            raise ValueError(f"dt {dt}: give a time step above 0 s")
        self._app.set_loop_step(step)

    def get_dt(self) -> float:
        """The dt of an update [s]: the rate limit's if that is on, else the manual step if manual, else the limit's."""
        settings, loop = self._app.settings, self._app.run_loop
        if loop.manual_mode and not settings.get(keys.RATE_LIMIT_ENABLED):
            return float(loop.manual_step)
        return float(1 / settings.rate(keys.RATE_LIMIT_FREQUENCY))

    def render(self) -> None:
        """One app update without physics; a playing timeline still moves."""
        settings = self._app.settings
        play_simulations = settings.get(keys.PLAY_SIMULATIONS)
        settings.set(keys.PLAY_SIMULATIONS, False)
        try:
            self._app.update()
        finally:
            settings.set(keys.PLAY_SIMULATIONS, play_simulations)

    async def render_async(self) -> None:
        """As `render`."""
        self.render()

    def register_callback(self, event: str, *, callback: Callable[[RenderingEvent], object], order: int = 0) -> int:
        """Calls `callback(event)` in each update that delivered a frame; returns an id.

        Bound methods are held weakly. Raises ValueError for another event than NEW_FRAME.
        """
        if event != NEW_FRAME:
            raise ValueError(f"there is no rendering event {event!r}; the one there is: {NEW_FRAME!r}")
        held: Callable[[], Callable[[RenderingEvent], object] | None]
        held = weakref.WeakMethod(callback) if inspect.ismethod(callback) else lambda: callback
        uid = next(self._ids)
        self._callbacks.append((order, uid, held))
        self._callbacks.sort(key=lambda entry: entry[:2])
        return uid

    def deregister_callback(self, uid: int) -> None:
        """Ends a callback; an unknown id is a warning."""
        left = [entry for entry in self._callbacks if entry[1] != uid]
        if len(left) == len(self._callbacks):
            self._app.warn("unknown-callback", "rendering", f"there is no callback with id {uid}")
        self._callbacks = left

    def deregister_all_callbacks(self) -> None:
        """Ends all callbacks."""
        self._callbacks = []

    def hand_over(self) -> None:
        """Gives this update's frames to the NEW_FRAME callbacks and to the products' writers."""
        if self._callbacks:
            event = RenderingEvent(NEW_FRAME, tuple(self.new_frames))
            for entry in tuple(self._callbacks):
                callback: Any = entry[2]()
                if callback is None:
                    self._callbacks.remove(entry)
                else:
                    callback(event)
        for product in tuple(self.new_frames):
            for writer in tuple(product.writers):
                writer(product.frame)
