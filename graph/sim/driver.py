"""Drives an App: the timeline's states, and updates that are called, stepped or awaited."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import TYPE_CHECKING

from graph.base import exact
from graph.base.callables import check_callable
from graph.base.errors import RunError, UserError

from .async_updates import AsyncUpdates
from .messages.bus import MessageBus
from .phases import Phases
from .settings import Settings
from .timing.run_loop import RunLoop
from .timing.speed import Speed, follow_timeline
from .timing.timeline import Timeline
from .update_loop import UpdateLoop
from .world import World

if TYPE_CHECKING:
    from .renderer.scheduler import SensorScheduler
    from .simulation import Simulation

StepCallback = Callable[[int, int], object]
"""Called after step i = 1, 2, ... of n as (i, n); False ends the steps."""


class Driver:
    """Drives the parts of one App. Every way of running n updates gives the same n updates.

    `switches_mode`: manual mode is on while the timeline plays and off otherwise (the experience `full`).
    """

    def __init__(
        self,
        world: World,
        simulation: Simulation,
        rendering: SensorScheduler,
        timeline: Timeline,
        run_loop: RunLoop,
        bus: MessageBus,
        settings: Settings,
        phases: Phases,
        *,
        switches_mode: bool,
    ) -> None:
        self.timeline, self.run_loop, self.settings, self.warn = timeline, run_loop, settings, world.warn
        self.updates = UpdateLoop(world, simulation, rendering, timeline, run_loop, bus, phases)
        self.rendering = rendering
        self._world, self._simulation, self._bus = world, simulation, bus
        self._clock = simulation.clock
        self._async_updates = AsyncUpdates(self.updates)
        self._speed = Speed(run_loop.wall_clock.now)
        follow_timeline(self._speed, self._clock, run_loop, settings, phases, switches_mode=switches_mode)

    @property
    def speed(self) -> Fraction | None:
        """Simulated seconds per second of the wall clock since the last play or resume; None before the first."""
        return self._speed.ratio(self._clock.monotonic)

    # -- the timeline's states ---------------------------------------------------------------------------------------

    def play(self, *, commit: bool | None = True) -> None:
        """Starts or resumes.

        `commit` True: now, with all callbacks; None: now, without warm-up and SimulationManager callbacks; False: in
        the next update.
        """
        self.timeline.play()
        self._settle(commit)

    def pause(self, *, commit: bool | None = True) -> None:
        """Pauses: all clocks stop. `commit` as for `play`."""
        self.timeline.pause()
        self._settle(commit)

    def stop(self, *, commit: bool | None = True) -> None:
        """Stops: clocks at 0, physics freed, the stage restored to its state before play. `commit` as for `play`."""
        self.timeline.stop()
        self._settle(commit)
        if commit is not False and self._world.built and self.timeline.is_stopped():
            self._simulation.free()  # built by initialize_physics, never played

    def _settle(self, commit: bool | None) -> None:
        if commit is None:
            self.timeline.commit_silently()
        elif commit:
            self.timeline.commit()

    def halt(self) -> Callable[[], None]:
        """Stops; returns a function that restores playing or pause."""
        if self.timeline.is_stopped():  # the world was built by hand
            self._simulation.invalidate_physics()
            return self._simulation.initialize_physics
        playing = self.timeline.is_playing()
        self.stop()
        return self.play if playing else self._play_paused

    def _play_paused(self) -> None:
        self.play()
        self.pause()

    def restart_time(self) -> None:
        """Sets every clock to its value right after play, except the monotonic clock and the loop's."""
        self.timeline.set_current_time(self.timeline.start_time)
        self._simulation.restart_time()
        self.rendering.restart()
        self._bus.restart()

    # -- updates -----------------------------------------------------------------------------------------------------

    @property
    def updating(self) -> bool:
        """Whether an update runs."""
        return self.updates.phases.running

    def check_drivable(self) -> None:
        """Raises RunError if no update can run: inside an update, or after `close`."""
        self.updates.check_drivable()

    def update(self, steps: int = 1) -> None:
        """Runs `steps` app updates, each through all phases; fewer if the end of the run is requested."""
        self.updates.update(steps)

    def deliver_frames(self) -> None:
        """Delivers rendered frames now that would arrive only with the next update (profile `isaacsim-6.0.1`)."""
        self.updates.deliver_frames()

    def update_app(self, *, steps: int = 1, callback: StepCallback | None = None) -> None:
        """Runs `steps` app updates and calls `callback(i, steps)` after each; False ends them."""
        steps = exact.count(steps, "steps", least=0)
        if callback is not None:
            check_callable(callback, "update_app(callback=...)")
        for done in range(1, steps + 1):
            self.update()
            if (callback is not None and callback(done, steps) is False) or self.updates.exit_requested:
                return

    async def next_update_async(self) -> float:
        """Waits for the next update and triggers it; returns its loop dt [s].

        All waiting coroutines share one update.
        """
        return await self._async_updates.next()

    async def update_app_async(self, *, steps: int = 1, callback: StepCallback | None = None) -> None:
        """Awaits `steps` app updates and calls `callback(i, steps)` after each; False ends them."""
        steps = exact.count(steps, "steps", least=0)
        if callback is not None:
            check_callable(callback, "update_app(callback=...)")
        for done in range(1, steps + 1):
            await self.next_update_async()
            if (callback is not None and callback(done, steps) is False) or self.updates.exit_requested:
                return

    async def next_render_simulation_async(
        self, render_product_paths: str | Iterable[str], num_simulation_frames: int = 1
    ) -> None:
        """Awaits updates until each of some render products has delivered that many more frames (deprecated).

        Raises UserError for a missing product, RunError if no frame can come: the timeline does not play, or a product
        is off or is removed.
        """
        paths = [render_product_paths] if isinstance(render_product_paths, str) else list(render_product_paths)
        message = "next_render_simulation_async is deprecated; use await app.update_app_async(steps=n)"
        self.warn("next-render-simulation-deprecated", ", ".join(paths) or "no product", message)
        products = self.rendering.products
        for path in paths:
            if path not in products:
                known = ", ".join(products) or "none"
                raise UserError(f"render product {path} does not exist; there are: {known}")
        more = exact.count(num_simulation_frames, "num_simulation_frames", least=0)
        wanted = {path: products[path].frames + more for path in paths}
        while wanted := {path: frames for path, frames in wanted.items() if self._frames_of(path) < frames}:
            await self.next_update_async()

    def _frames_of(self, path: str) -> int:
        product = self.rendering.products.get(path)
        if product is None or not product.enabled:
            raise RunError(f"render product {path} is {'gone' if product is None else 'off'}; no frame of it can come")
        if not self.timeline.is_playing():
            raise RunError(f"render product {path}: no frame comes while the timeline does not play; call app.play()")
        return product.frames

    def close(self) -> None:
        """Refuses all further updates."""
        self.updates.closed = True
