"""What moves an App from outside: the timeline's states, updates called or awaited."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, cast

from graph.base import exact
from graph.base.errors import RunError, UserError

from .async_updates import AsyncUpdates
from .loop_runner import LoopRunner
from .orchestrator import Orchestrator

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.rendering import Rendering
    from graph.sim.timing.timeline import Timeline

    from .simulation_manager import ManagedSimulation

StepCallback = Callable[[int, int], object]
"""Called after step i = 1, 2, ... of n as (i, n); False ends the steps."""


class Drivers:
    """The part of an App that drives it. Every way of running n updates gives the same n updates."""

    if TYPE_CHECKING:  # what the App brings
        timeline: Timeline
        simulation: ManagedSimulation
        rendering: Rendering
        exit_requested: bool

        update: Callable[..., None]
        free_world: Callable[[], None]
        warn: Callable[[str, str, str], None]

    def _make_drivers(self) -> None:
        app = cast("App", self)
        self.loop = LoopRunner(app)
        """Manual mode and step size of the run loop."""
        self.orchestrator = Orchestrator(app)
        """Steps that return once attached writers have fired."""
        self._async_updates = AsyncUpdates(app)

    def play(self, *, commit: bool | None = True) -> None:
        """Starts or resumes.

        `commit` True: now, with all callbacks; None: now, without warm-up and SimulationManager callbacks; False: in
        the next update.
        """
        self.timeline.play()
        self._settle(commit)

    def pause(self, *, commit: bool | None = True) -> None:
        """Pauses: every clock holds. `commit` as for `play`."""
        self.timeline.pause()
        self._settle(commit)

    def stop(self, *, commit: bool | None = True) -> None:
        """Stops: clocks at 0, physics freed, the stage as it was before play. `commit` as for `play`."""
        self.timeline.stop()
        self._settle(commit)
        if commit is not False and self.simulation.built and self.timeline.is_stopped():
            self.free_world()  # built by initialize_physics, never played

    def update_app(self, *, steps: int = 1, callback: StepCallback | None = None) -> None:
        """Runs `steps` app updates; `callback(i, steps)` after each, False ends them."""
        steps = exact.count(steps, "steps")
        for done in range(1, steps + 1):
            self.update()
            if (callback is not None and callback(done, steps) is False) or self.exit_requested:
                return

    async def next_update_async(self) -> float:
        """Waits for the next update and makes it run; returns its loop dt [s]. All who wait share one update."""
        return await self._async_updates.next()

    async def update_app_async(self, *, steps: int = 1, callback: StepCallback | None = None) -> None:
        """Awaits `steps` app updates; `callback(i, steps)` after each, False ends them."""
        steps = exact.count(steps, "steps")
        for done in range(1, steps + 1):
            await self.next_update_async()
            if (callback is not None and callback(done, steps) is False) or self.exit_requested:
                return

    async def next_render_simulation_async(
        self, render_product_paths: str | Iterable[str], num_simulation_frames: int = 1
    ) -> None:
        """Awaits updates until each of some render products has delivered that many more frames (deprecated).

        Raises UserError for a product that is not there, RunError where no frame can come: nothing plays, or a product
        is off or goes away.
        """
        paths = [render_product_paths] if isinstance(render_product_paths, str) else list(render_product_paths)
        message = "next_render_simulation_async is deprecated; use await app.update_app_async(steps=n)"
        self.warn("next-render-simulation-deprecated", ", ".join(paths) or "no product", message)
        for path in paths:
            if path not in self.rendering.products:
                known = ", ".join(self.rendering.products) or "none"
                raise UserError(f"render product {path} does not exist; there are: {known}")
        more = exact.count(num_simulation_frames, "num_simulation_frames")
        wanted = {path: self.rendering.products[path].frames + more for path in paths}
        while wanted := {path: frames for path, frames in wanted.items() if self._frames_of(path) < frames}:
            await self.next_update_async()

    def _frames_of(self, path: str) -> int:
        product: Any = self.rendering.products.get(path)
        if product is None or not product.enabled:
            raise RunError(f"render product {path} is {'gone' if product is None else 'off'}; no frame of it can come")
        if not self.timeline.is_playing():
            raise RunError(f"render product {path}: no frame comes while the timeline does not play; call app.play()")
        return int(product.frames)

    def _settle(self, commit: bool | None) -> None:
        if commit is None:
            self.timeline.commit_silently()
        elif commit:
            self.timeline.commit()
