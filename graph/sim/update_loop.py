"""App updates: each advances the clocks through the phases, in their order."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from graph.base import exact
from graph.base.errors import RunError

from .messages.bus import MessageBus
from .phases import Phases
from .timing.run_loop import RunLoop
from .timing.timeline import Timeline
from .world import World

if TYPE_CHECKING:
    from .renderer.scheduler import SensorScheduler
    from .simulation import Simulation


class UpdateLoop:
    """Runs the updates of one App. Subscribers of a phase must not call it."""

    def __init__(
        self,
        world: World,
        simulation: Simulation,
        scheduler: SensorScheduler,
        timeline: Timeline,
        run_loop: RunLoop,
        bus: MessageBus,
        phases: Phases,
    ) -> None:
        self.run_loop, self.phases = run_loop, phases
        self.update_index = 0
        """Index of the running update; between updates, the number of updates done."""
        self.exit_requested = False
        """Whether the end of the run was requested (by a node ExitApplication); no update follows."""
        self.closed = False
        """Whether the App is closed, so that no update can run."""
        self._world, self._simulation, self.rendering = world, simulation, scheduler
        self.timeline, self._bus = timeline, bus
        self._timeline_state, self._timeline_phase = phases["timeline_state"], phases["timeline"]
        self._physics_phase, self._graphs_phase = phases["physics"], phases["simulation_graphs"]
        self._render_phase, self._frames_phase = phases["render"], phases["post_render_graphs"]
        self._end_phase, self._sensors_edited = phases["end"], phases["sensors_edited"]
        self._physics_s = self._render_s = self._graph_s = 0.0

    @property
    def timing(self) -> dict[str, float]:
        """Real time spent so far [s] in physics, render, graph and io."""
        return {
            "physics": self._physics_s,
            "render": self._render_s,
            "graph": self._graph_s,
            "io": self._bus.io_seconds,
        }

    def check_drivable(self) -> None:
        """Raises RunError if no update can run: inside an update, or after `close`."""
        if self.phases.running:
            raise RunError("update() was called from inside an update; a subscriber must not drive the App")
        if self.closed:
            raise RunError("the App is closed; make a new one")

    def update(self, steps: int = 1) -> None:
        """Runs `steps` app updates, each through all phases; fewer if the end of the run is requested."""
        steps = exact.count(steps, "steps", least=0)
        self.check_drivable()
        self.phases.running = True
        try:
            for _ in range(steps):
                self._update()
                self.rendering.end_update()
                self.update_index += 1
                if self.exit_requested:
                    break
        finally:
            self.rendering.end_update()
            self.phases.running = False

    def _update(self) -> None:
        scheduler, bus, timeline = self.rendering, self._bus, self.timeline
        bus.begin_update()
        dt = self.run_loop.begin()
        if scheduler.frames_later:
            scheduler.deliver_pending()
            self._hand_over()

        for callback in self._timeline_state.before:
            callback()
        timeline.commit()
        for callback in self._timeline_state.after:
            callback()
        scheduler.begin_update(dt)
        live = self._world.live
        if live is not None:
            live.check()
            if live.watch.others or live.watch.resynced:
                rendered = (product.camera_path for product in scheduler.products.values() if product.camera_path)
                if live.watch.take_changed((*(scheduler.polled or ()), *rendered)):
                    self._sensors_edited()

        for callback in self._timeline_phase.before:
            callback()
        timeline.advance(dt)
        for callback in self._timeline_phase.after:
            callback()

        started = perf_counter()
        for callback in self._physics_phase.before:
            callback()
        try:
            self._simulation.run_update(timeline.delta)  # 0 if a subscriber has stopped the timeline meanwhile
        finally:
            done = perf_counter()
            self._physics_s += done - started
        for callback in self._physics_phase.after:
            callback()

        io = bus.io_seconds
        self._graphs_phase()
        bus.release()
        started = perf_counter()
        self._graph_s += started - done - (bus.io_seconds - io)

        for callback in self._render_phase.before:
            callback()
        scheduler.render_due(playing=timeline.is_playing())
        for callback in self._render_phase.after:
            callback()
        done = perf_counter()
        self._render_s += done - started

        if scheduler.new_frames and not scheduler.frames_later:
            self._hand_over()

        self._end_phase()
        self.run_loop.end()

    def deliver_frames(self) -> None:
        """Delivers rendered frames now that would arrive only with the next update (profile `isaacsim-6.0.1`)."""
        if self.rendering.pending_frames:
            self.rendering.deliver_pending()
            self._hand_over()

    def _hand_over(self) -> None:
        if not self.rendering.new_frames:
            return
        bus = self._bus
        began, io = perf_counter(), bus.io_seconds
        for callback in self._frames_phase.before:
            callback()
        self.rendering.hand_over()
        for callback in self._frames_phase.after:
            callback()
        bus.release()
        self._graph_s += perf_counter() - began - (bus.io_seconds - io)
