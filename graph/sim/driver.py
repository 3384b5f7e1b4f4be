"""Drives an App: the timeline's states, and updates that are called, stepped or awaited."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base import exact
from graph.base.callables import check_callable
from graph.base.errors import RunError, UserError
from graph.sim.timing.run_loop import Speed, follow_timeline

from .messages.bus import MessageBus
from .phases import Phases
from .settings import Settings
from .timing.run_loop import RunLoop
from .timing.timeline import DEFAULT_END_TIME_CODE, Timeline
from .update_loop import UpdateLoop
from .world import World

if TYPE_CHECKING:
    import asyncio

    from .renderer.scheduler import SensorScheduler
    from .simulation import Simulation

StepCallback = Callable[[int, int], object]
"""Called after step i = 1, 2, ... of n as (i, n); False ends the steps."""


_LAST = 1 << 30
"""Order among the subscribers of a phase: after all others."""


class Driver(UpdateLoop):
    """Drives the parts of one App. Every way of running n updates gives the same n updates.

    `switches_mode`: manual mode is on while the timeline plays and off otherwise (the experience `full`).

    Awaited updates have no background loop. The first coroutine that waits puts an update at the end of asyncio's
    queue; those that wait before it runs share it, and all resume after it in the order in which they came. So an App
    that is driven this way does the same in every run, as long as its coroutines wait for nothing else.
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
        super().__init__(world, simulation, rendering, timeline, run_loop, bus, phases)
        self.settings, self.warn = settings, world.warn
        self._clock = simulation.clock
        self._waiting: list[asyncio.Future[float]] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._scheduled = self._listening = False
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
        return self.phases.running

    def update_app(self, *, steps: int = 1, callback: StepCallback | None = None) -> None:
        """Runs `steps` app updates and calls `callback(i, steps)` after each; False ends them."""
        steps = _checked(steps, callback)
        for done in range(1, steps + 1):
            self.update()
            if self._ends(done, steps, callback):
                return

    def _ends(self, done: int, steps: int, callback: StepCallback | None) -> bool:
        """Calls the callback after a step, and says whether no other one follows."""
        return (callback is not None and callback(done, steps) is False) or self.exit_requested

    async def next_update_async(self) -> float:
        """Waits for the next update, called from anywhere, and triggers it; returns its loop dt [s].

        All waiting coroutines share one update. Raises what that update raised.
        """
        import asyncio  # a coroutine that waits has imported it; other Apps and checks need not

        loop = asyncio.get_running_loop()
        if not self._listening:
            self._listening = True
            self.phases.on("end", self._updated, _LAST)
        if loop is not self._loop:  # an ended loop never runs what was scheduled on it
            self._loop, self._scheduled, self._waiting = loop, False, []
        future: asyncio.Future[float] = loop.create_future()
        self._waiting.append(future)
        if not self._scheduled:
            self._scheduled = True
            loop.call_soon(self._drive)
        return await future

    def _drive(self) -> None:
        self._scheduled = False
        if all(future.done() for future in self._waiting):  # an update ran meanwhile, or they were cancelled
            self._waiting.clear()
            return
        try:
            self.update()
        except BaseException as error:
            failure = error
            self._resume(lambda future: future.set_exception(failure))
            if not isinstance(error, Exception):
                raise

    def _updated(self) -> None:
        dt = float(self.run_loop.dt)
        self._resume(lambda future: future.set_result(dt))

    def _resume(self, settle: Callable[[asyncio.Future[float]], None]) -> None:
        waiting, self._waiting = self._waiting, []
        for future in waiting:
            if not future.done():
                settle(future)

    async def update_app_async(self, *, steps: int = 1, callback: StepCallback | None = None) -> None:
        """Awaits `steps` app updates and calls `callback(i, steps)` after each; False ends them."""
        steps = _checked(steps, callback)
        for done in range(1, steps + 1):
            await self.next_update_async()
            if self._ends(done, steps, callback):
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

    def take_stage(self, stage: Any = None) -> None:
        """Replaces the stage by another (a path, a `Usd.Stage`, None: an empty one).

        The timeline stops first; render products, graphs and bodies end with their stage. Timeline, settings, message
        bus, callbacks and the count of updates go on. The physics rate is the one that the stage authors, else 60 Hz.
        Raises RunError inside an update, and UserError for a file that cannot be opened; then nothing has changed.
        """
        from .options import DEFAULT_RATE
        from .scene.stage import open_stage
        from .scene.stage_metadata import time_range

        self.check_drivable()
        if stage is None or isinstance(stage, (str, Path)):
            stage = open_stage(stage, None, self.warn)
        self.stop()
        self.phases["stage_closing"]()
        self._world.take_stage(stage)
        self.rendering.take_stage(stage)
        self._simulation.take_stage(DEFAULT_RATE)
        start, end = time_range(stage, self.warn) or (
            Fraction(0),
            DEFAULT_END_TIME_CODE / self.timeline.time_codes_per_second,
        )
        self.timeline.set_range(start, end)
        self.phases["stage_opened"]()

    def close(self) -> None:
        """Refuses all further updates."""
        self.closed = True


def _checked(steps: int, callback: StepCallback | None) -> int:
    """A number of steps. Raises for a wrong one, and for a callback that cannot be called."""
    steps = exact.count(steps, "steps", least=0)
    if callback is not None:
        check_callable(callback, "update_app(callback=...)")
    return steps
