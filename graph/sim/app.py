"""The App: one world, its clocks, and the driver that moves them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from graph.base import exact
from graph.base.errors import RunError, UserError

from . import settings as keys
from .driver import Driver, StepCallback
from .fidelity import Fidelity
from .managers.loop_runner import LoopRunner
from .managers.orchestrator import Orchestrator
from .managers.simulation_manager import ManagedSimulation
from .messages.bus import MessageBus
from .options import clock_rates, experience_settings, refuse_unavailable
from .phases import Callback, Phases, Unsubscribe
from .physics import MUJOCO
from .renderer.rendering import Rendering
from .scene.editing import WhenPlaying, checked_choice
from .settings import Settings
from .state.reset import Reset, reset
from .timing.clocks import PhysicsClock
from .timing.parity import apply_profile
from .timing.run_loop import RunLoop
from .timing.timeline import Timeline
from .timing.wall_clock import VirtualClock, WallClock
from .warnings import WarningList
from .world import open_world

if TYPE_CHECKING:
    from types import TracebackType

    from .geometry.surfaces import Mesh, Plane
    from .physics.protocol import EngineFactory, PhysicsEngine
    from .scene.live_stage import LiveStage
    from .state.prim_poses import PrimPoses


class App:
    """One world and its clocks. Several may live in one process; the most recently entered one is the default.

    `stage` is a path, a `Usd.Stage` or None for an empty stage; `mjcf`, instead of it, an MJCF file or a loaded
    `MjcfScene`. `physics_hz` beats the stage's physics scene or the MJCF time step, which beat 60; `loop_hz` defaults
    to 60. `fidelity` maps knobs (`lidar.motion`) to values. `physics` makes the physics engine, MuJoCo unless given
    (see `graph.sim.physics.protocol.EngineFactory`). `allow`: folders beside the USD
    file's own that it may refer to. Raises UserError for options that cannot be run.

    An App holds its parts and passes calls on to them: `world` (stage, Fabric, physics, edits), `simulation` (builds,
    steps and frees the world), `rendering` (sensors), `timeline`, `driver` (states and updates), `phases` (whoever is
    called in them), `bus` (messages), `settings`. No part knows the App.
    """

    _entered: ClassVar[list[App]] = []

    def __init__(
        self,
        stage: Any = None,
        *,
        mjcf: Any = None,
        physics_hz: float | str | Fraction | None = None,
        loop_hz: float | str | Fraction | None = None,
        experience: str = "base",
        parity: str = "documented",
        settings: Mapping[str, Any] | None = None,
        fidelity: Mapping[str, Any] | Fidelity | None = None,
        seed: int = 0,
        wall_clock: WallClock | None = None,
        when_playing: str | None = None,
        physics: EngineFactory = MUJOCO,
        allow: Iterable[str | Path] = (),
    ) -> None:
        from .scene.stage import time_range

        knobs = fidelity if isinstance(fidelity, Fidelity) else Fidelity.from_mapping(fidelity or {})
        refuse_unavailable(experience, parity, knobs)
        self.experience, self.parity, self.seed = experience, parity, exact.count(seed, "seed")
        self.settings = Settings(settings)
        apply_profile(self.settings, parity)
        self.warnings = WarningList()
        self.warn: Callable[[str, str, str], None] = self.warnings.add
        """`warn(code, where, message)` notes a warning: said once per code and place, counted."""
        warn = self.warn
        self.settings.on_misspelt(
            lambda path, known: warn("setting-unknown", path, f'no part of this run reads it; did you mean "{known}"?')
        )
        choice = checked_choice(when_playing or str(self.settings.get(keys.WHEN_PLAYING)))
        self.world = open_world(
            stage, mjcf, engine=physics, fidelity=knobs, when_playing=choice, warn=self.warn, allow=allow
        )
        authored = self.world.authored_rate
        physics_rate, loop_rate = clock_rates(
            physics_hz,
            loop_hz,
            experience,
            authored,
            knobs.physics_hz,
            whole=self.settings.get(keys.TRUNCATE_STEPS),
            warn=self.warn,
        )
        experience_settings(self.settings, experience, loop_rate if loop_hz is not None else None, self.stage)

        self.phases = Phases()
        self.bus = MessageBus()
        self.wall_clock: WallClock = wall_clock if wall_clock is not None else VirtualClock()
        self.run_loop = RunLoop(self.settings, self.wall_clock, 1 / loop_rate)
        self.timeline = Timeline(self.settings)
        if played := time_range(self.stage, self.warn):
            self.timeline.set_range(*played)
        clock = self.bus.clock = PhysicsClock(physics_rate)
        self.rendering = Rendering(clock, self.run_loop, self.timeline, self.settings, self.stage, self.warn)
        self.simulation = ManagedSimulation(
            self.world,
            clock,
            self.rendering,
            self.timeline,
            self.bus,
            self.settings,
            self.phases,
            self.wall_clock.now,
            follows_stage_rate=physics_hz is None and knobs.physics_hz is None and experience != "zero_delay",
        )
        if authored == 0 and physics_hz is None and knobs.physics_hz is None:
            self.simulation.setup.refuse_rate_zero()
        if self.mjcf is not None:
            from .mjcf.controls import serve

            serve(self.mjcf, self.world, self.phases)
        self.on("resume", self.simulation.times.resample, -1)
        self.driver = Driver(
            self.world,
            self.simulation,
            self.rendering,
            self.timeline,
            self.run_loop,
            self.bus,
            self.settings,
            self.phases,
            switches_mode=experience == "full" and not self.settings.is_authored(keys.MANUAL_MODE),
        )
        self.timeline.on_change = self.simulation.follow
        self.rendering.updates = self.driver
        self.graphs: dict[str, Any] = {}
        """The graphs bound to this App, by path; filled by whoever binds them."""
        self.folders: tuple[Path, ...] = ()
        """What nodes may read files from: the graph file's folder and those the user allows; the first is for names."""
        self.output_folder: Path | None = None
        """Where the run writes; None where it writes nothing."""
        self._told_closing = False

    @classmethod
    def from_file(cls, path: str | Path, **options: Any) -> App:
        """The App of a graph file, its graphs bound to it. Options as in `graph.session.open.open_session`."""
        app: App = import_module("graph.session.open").open_app(cls, path, **options)
        return app

    @classmethod
    def current(cls) -> App:
        """The most recently entered App. Raises UserError if none is."""
        if not cls._entered:
            raise UserError("there is no current App; use `with App(...) as app:` or pass app=")
        return cls._entered[-1]

    @classmethod
    def of_stage(cls, stage: Any) -> App | None:
        """The most recently entered App that has this stage; None if none has."""
        return next((app for app in reversed(cls._entered) if app.stage == stage), None)

    # -- the world ---------------------------------------------------------------------------------------------------

    @property
    def stage(self) -> Any:
        """The `Usd.Stage`."""
        return self.world.stage

    @property
    def mjcf(self) -> Any:
        """The MJCF model (`graph.sim.mjcf.MjcfScene`) that the stage mirrors, if it does."""
        return self.world.mjcf

    @property
    def meters_per_unit(self) -> float:
        """Metres in a unit of the stage."""
        return self.world.meters_per_unit

    @property
    def fabric(self) -> PrimPoses:
        """Where every prim is now, and attributes beside the stage."""
        return self.world.fabric

    @property
    def fidelity(self) -> Fidelity:
        """The fidelity knobs."""
        return self.world.fidelity

    @property
    def physics(self) -> PhysicsEngine | None:
        """The physics engine; None while stopped or when nothing is dynamic."""
        return self.world.physics

    @property
    def live(self) -> LiveStage | None:
        """Keeps the playing world and its stage together; None while stopped."""
        return self.world.live

    @property
    def when_playing(self) -> WhenPlaying:
        """What becomes of edits while playing: "refuse", "restart" or "recompile"."""
        return self.world.when_playing

    @when_playing.setter
    def when_playing(self, choice: str) -> None:
        self.world.when_playing = checked_choice(choice)

    def geometry(self) -> tuple[Mesh | Plane, ...]:
        """What rays can hit (`graph.sim.geometry.collect.collect_geometry`), collected once per play."""
        return self.world.geometry()

    def forget_geometry(self) -> None:
        """Has what rays can hit collected again when it is needed next."""
        self.world.forget_geometry()

    def edit(self, when_playing: str | None = None) -> AbstractContextManager[Any]:
        """`with app.edit(when_playing="recompile") as stage:` changes the world while it plays too; see `EditStage`."""
        return self.world.edit(self.driver, when_playing)

    def add_prims(self, prims: Mapping[str, Mapping[str, Any]], when_playing: str | None = None) -> None:
        """Authors prims, path to keys as under `scene.prims` in a graph file, inside an `edit`."""
        self.world.add_prims(self.driver, prims, when_playing)

    def remove_prims(self, *paths: str, when_playing: str | None = None) -> None:
        """Removes prims, inside an `edit`. Raises UserError for one that is not there."""
        self.world.remove_prims(self.driver, *paths, when_playing=when_playing)

    def reset(self, scope: str | Reset = "all") -> None:
        """Starts again while playing: the clocks, the bodies, without what was added, or all of it; see `Reset`."""
        reset(self.world, self.driver, scope)

    # -- clocks and figures ------------------------------------------------------------------------------------------

    @property
    def external_time(self) -> Fraction:
        """The renderer's clock [s], exact: the time that sensors are stamped with."""
        return self.rendering.time

    @property
    def loop_rate(self) -> Fraction:
        """App updates per second of loop time [Hz]."""
        return 1 / self.run_loop.manual_step

    @property
    def loop_time(self) -> Fraction:
        """The run loop's time since the App was made [s], playing or not."""
        return self.run_loop.time

    @property
    def speed(self) -> Fraction | None:
        """Simulated seconds per second of this App's wall clock since the last play or resume; None before the first.

        1 is real time, below 1 slow motion. Measured: on the real clock it holds what the machine and the pacing gave.
        """
        return self.driver.speed

    @property
    def timing(self) -> dict[str, float]:
        """Real time spent so far [s] in physics, render, graph and io."""
        return self.driver.updates.timing

    @property
    def update_index(self) -> int:
        """Index of the running update, else the number of updates done."""
        return self.driver.updates.update_index

    @property
    def updating(self) -> bool:
        """Whether an update runs."""
        return self.phases.running

    @property
    def exit_requested(self) -> bool:
        """Whether something (a node ExitApplication) asked the run to end; nothing is updated after that update."""
        return self.driver.updates.exit_requested

    @exit_requested.setter
    def exit_requested(self, requested: bool) -> None:
        self.driver.updates.exit_requested = requested

    # -- driving -----------------------------------------------------------------------------------------------------

    @property
    def loop(self) -> LoopRunner:
        """Manual mode and step size of the run loop."""
        return self.driver.loop

    @property
    def orchestrator(self) -> Orchestrator:
        """Steps that return once attached writers have fired."""
        return self.driver.orchestrator

    def on(self, phase: str, callback: Callback, order: int = 0) -> Unsubscribe:
        """Calls `callback()` in a phase of every update or at an event, see `Phases.on`; returns what ends that."""
        return self.phases.on(phase, callback, order)

    def play(self, *, commit: bool | None = True) -> None:
        """Starts or resumes; see `Driver.play` for `commit`."""
        self.driver.play(commit=commit)

    def pause(self, *, commit: bool | None = True) -> None:
        """Pauses: every clock holds."""
        self.driver.pause(commit=commit)

    def stop(self, *, commit: bool | None = True) -> None:
        """Stops: clocks at 0, physics freed, the stage as it was before play."""
        self.driver.stop(commit=commit)

    def check_drivable(self) -> None:
        """Raises RunError where no update can run: inside one, or after `close`."""
        self.driver.check_drivable()

    def update(self, steps: int = 1) -> None:
        """Runs `steps` app updates, each through all phases; fewer once the run is asked to end."""
        self.driver.updates.update(steps)

    def update_app(self, *, steps: int = 1, callback: StepCallback | None = None) -> None:
        """Runs `steps` app updates; `callback(i, steps)` after each, False ends them."""
        self.driver.update_app(steps=steps, callback=callback)

    async def next_update_async(self) -> float:
        """Waits for the next update and makes it run; returns its loop dt [s]. All who wait share one update."""
        return await self.driver.next_update_async()

    async def update_app_async(self, *, steps: int = 1, callback: StepCallback | None = None) -> None:
        """Awaits `steps` app updates; `callback(i, steps)` after each, False ends them."""
        await self.driver.update_app_async(steps=steps, callback=callback)

    async def next_render_simulation_async(
        self, render_product_paths: str | Iterable[str], num_simulation_frames: int = 1
    ) -> None:
        """Awaits more frames of render products (deprecated); see `Driver.next_render_simulation_async`."""
        await self.driver.next_render_simulation_async(render_product_paths, num_simulation_frames)

    def deliver_frames(self) -> None:
        """Delivers now what was rendered and would only arrive with the next update (profile `isaacsim-6.0.1`)."""
        self.driver.deliver_frames()

    # -- the end -----------------------------------------------------------------------------------------------------

    def tell_closing(self) -> None:
        """Tells the "closing" subscribers, once, that the App is about to close: world and sinks are as they were.

        `close` does so first; who reads results before that (a report, a recording) calls it ahead of reading them.
        """
        if not self._told_closing:
            self._told_closing = True
            self.phases["closing"]()

    def close(self) -> None:
        """Tells the "closing" subscribers, stops, tells the "close" subscribers and closes the bus's sinks.

        Each also when one before it fails. What the parts know of each other ends too, so that a closed App is freed
        with its last reference; its clocks, products and warnings can still be read.
        """
        if self.driver.updates.closed:
            return
        self.driver.close()
        failure: BaseException | None = None
        closing = self.phases["close"]
        for action in (
            self.tell_closing,
            self.stop,
            *closing.before,
            *closing.after,
            self.simulation.close,
            self.bus.close,
            self.world.close,
            self.phases.clear,
            self.settings.close,
            self.timeline.close,
            self.rendering.close,
        ):
            try:
                action()
            except BaseException as error:
                failure = failure or error
        if failure is not None:
            raise failure

    def __enter__(self) -> App:
        App._entered.append(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self in App._entered:
            App._entered.reverse()
            App._entered.remove(self)
            App._entered.reverse()
        try:
            self.close()
        except RunError:
            if error is None:  # what ended the run says more than what its end led to
                raise
