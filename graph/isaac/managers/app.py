"""`graph.sim.App`: the App that opens graph files, with Isaac Sim's names for simulation, rendering and run loop."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.sim import app
from graph.sim.timing.clocks import PhysicsClock
from sensors.orchestrator import Orchestrator

from .loop_runner import LoopRunner
from .rendering import Rendering
from .simulation_manager import ManagedSimulation

if TYPE_CHECKING:
    from typing import Self


class App(app.App):
    """One world and its clocks, in Isaac Sim's names too; `graph.sim.app.App` documents the options."""

    simulation: ManagedSimulation
    rendering: Rendering

    @classmethod
    def from_file(cls, path: str | Path, **options: Any) -> Self:
        """The App of a graph file, with its graphs bound to it. Options as in `graph.session.open.open_session`."""
        from graph.session.open import open_app

        return open_app(cls, path, **options)

    def add_prims(self, prims: Mapping[str, Mapping[str, Any]], when_playing: str | None = None) -> None:
        """Authors prims inside an `edit`; path to keys as under `scene.prims` in a graph file, sensors included."""
        from graph.sim.scene.placed_types import give_transforms
        from graph.sim.scene.prims import author_prims
        from sensors.configs import author_config
        from sensors.sensor_types import sensor_types

        author = partial(author_prims, sensor_config=author_config, sensor_types=sensor_types())
        give_transforms(self.stage)
        self.world.add_prims(self.driver, prims, when_playing, author)

    @property
    def loop(self) -> LoopRunner:
        """Manual mode and step size of the run loop."""
        return LoopRunner(self.run_loop, self.settings)

    @property
    def orchestrator(self) -> Orchestrator:
        """Makes steps that return after attached writers have been called."""
        return Orchestrator(lambda: self.driver)

    def _new_rendering(self, clock: PhysicsClock) -> Rendering:
        return Rendering(clock, self.run_loop, self.timeline, self.settings, self.stage, self.warn)

    def _new_simulation(self, clock: PhysicsClock, *, follows_stage_rate: bool) -> ManagedSimulation:
        return ManagedSimulation(
            self.world,
            clock,
            scheduler=self.rendering,
            timeline=self.timeline,
            bus=self.bus,
            settings=self.settings,
            phases=self.phases,
            now=self.wall_clock.now,
            follows_stage_rate=follows_stage_rate,
        )

    def _complete(self) -> None:
        self.rendering.updates = self.driver
