"""The App: one world, its clocks, and the driver that moves them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from graph.base import exact
from graph.base.asset_roots import mapped
from graph.base.errors import RunError
from graph.base.suggesting import Suggesting
from graph.sim.live.editing import Reset, reset
from graph.sim.timing.run_loop import VirtualClock, WallClock

from . import entered
from . import settings as keys
from .delegation import delegate
from .driver import Driver
from .fidelity import Fidelity
from .messages.bus import MessageBus
from .options import clock_rates, experience_settings, refuse_unavailable
from .phases import Callback, Phases, Unsubscribe
from .physics import MUJOCO
from .renderer.scheduler import SensorScheduler
from .settings import of_profile
from .simulation import Simulation
from .state.playing_world import WhenPlaying, checked_choice
from .timing.clocks import PhysicsClock
from .timing.run_loop import RunLoop
from .timing.timeline import Timeline
from .warnings import WarningList
from .world import World, open_world

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from .live.live_stage import LiveStage
    from .physics.protocol import EngineFactory, PhysicsEngine
    from .state.prim_poses import PrimPoses


class App(Suggesting):
    """One world and its clocks. Several may live in one process; the most recently entered one is the default.

    `stage` is a path, a `Usd.Stage` or None for an empty stage; `mjcf`, instead of it, an MJCF file or a loaded
    `MjcfScene`. `physics_hz` is preferred over the rate of the stage's physics scene or the MJCF time step, then 60;
    `loop_hz` defaults to 60. `fidelity` maps knobs (`lidar.motion`) to values. `physics` makes the physics engine, by
    default MuJoCo (see `graph.sim.physics.protocol.EngineFactory`). `allow`: further folders to which the USD file may
    refer. `asset_roots`: folders by the prefixes of the addresses that they hold (`graph.base.asset_roots`).
    `device`: the knob of that name, such as "cuda". Raises UserError for options that cannot be run.

    An App holds its parts and passes calls on to them: `world` (stage, Fabric, physics, edits), `simulation` (builds,
    steps and frees the world), `rendering` (sensors), `timeline`, `driver` (states and updates), `phases` (their
    subscribers), `bus` (messages), `settings`. No part has a reference to the App.

    >>> from graph.sim import App
    >>> with App(physics_hz=240, loop_hz=60) as app:
    ...     app.add_prims({"/Ball": {"type": "Sphere", "radius": 0.1, "translate": [0, 0, 9], "rigid_body": True}})
    ...     app.play()
    ...     app.update(30)
    ...     app.simulation.get_num_physics_steps(), app.simulation.get_simulation_time()
    (120, 0.5)
    """

    _instead: ClassVar[Mapping[str, str]] = {
        "step": "app.update(steps=n)",
        "run": "app.update(steps=n)",
        "start": "app.play()",
        "time": "app.timeline.get_current_time() or app.external_time",
        "scene": "app.stage",
        "load": "App.from_file(path)",
    }

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
        asset_roots: Mapping[str, str | Path] | None = None,
        device: str | None = None,
    ) -> None:
        from .scene.stage_metadata import time_range

        knobs = fidelity if isinstance(fidelity, Fidelity) else Fidelity.from_mapping(fidelity or {})
        if device is not None:
            knobs = replace(knobs, device=Fidelity.from_mapping({"device": device}).device)
        refuse_unavailable(experience, parity, knobs)
        self.experience, self.parity, self.seed = experience, parity, exact.count(seed, "seed")
        self.settings = of_profile(parity, settings)
        self.warnings = WarningList()
        self.warn: Callable[[str, str, str], None] = self.warnings.add
        """`warn(code, where, message)` gives a warning, which is shown once for each code and place, and counted."""
        warn = self.warn
        self.settings.on_misspelt(
            lambda path, known: warn("setting-unknown", path, f'no part of this run reads it; did you mean "{known}"?')
        )
        loop_hz = loop_hz if knobs.loop_hz is None else knobs.loop_hz
        choice = checked_choice(when_playing or str(self.settings.get(keys.WHEN_PLAYING)))
        with mapped(asset_roots or {}):
            self.world = open_world(
                stage, mjcf, engine=physics, fidelity=knobs, when_playing=choice, warn=warn, allow=allow
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
        self.rendering = self.world.rendering = self._new_rendering(clock)
        self.rendering.scene = self.world
        self.world.settings, self.world.seed, self.world.phases = self.settings, self.seed, self.phases
        self.simulation = self.world.times = self._new_simulation(
            clock, follows_stage_rate=physics_hz is None and knobs.physics_hz is None and experience != "zero_delay"
        )
        if authored == 0 and physics_hz is None and knobs.physics_hz is None:
            self.simulation.refuse_rate_zero()
        if self.mjcf is not None:
            self.mjcf.serve(self.world, self.phases)
        self.on("resume", self.simulation.resample, -1)
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
        self.timeline.on_change, self.timeline.on_stop = self.simulation.follow, self.world.stop_requested
        self._complete()
        self.graphs: dict[str, Any] = {}
        """The graphs bound to this App, by path; filled by the code that binds them."""
        file = stage if isinstance(stage, (str, Path)) else mjcf if isinstance(mjcf, (str, Path)) else None
        if file is not None:
            self.world.folders = (Path(file).expanduser().absolute().parent, *map(Path, allow))
        self.output_folder: Path | None = None
        """Where the run writes files; None if it writes no files."""
        self.metrics: dict[str, float] = {}
        """Values that nodes write into the report, by name."""
        self._told_closing = False
        entered.living.add(self)

    def _new_rendering(self, clock: PhysicsClock) -> SensorScheduler:
        run_loop = self.run_loop
        return SensorScheduler(clock, None, lambda: run_loop.time)

    def _new_simulation(self, clock: PhysicsClock, *, follows_stage_rate: bool) -> Simulation:
        return Simulation(
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
        """Called when all parts are made."""

    @classmethod
    def current(cls) -> Self:
        """The most recently entered App. Raises UserError if there is no such App."""
        app: Self = entered.current()
        return app

    @classmethod
    def of_stage(cls, stage: Any) -> Self | None:
        """The most recently entered App with this stage, or None."""
        app: Self | None = entered.of_stage(stage)
        return app

    def __repr__(self) -> str:
        state = "closed" if self.driver.closed else "playing" if self.timeline.is_playing() else "not playing"
        physics = exact.shortest(self.simulation.steps_per_second)
        return (
            f"<App {state} at {float(self.timeline.current_time):.3f} s: loop {exact.shortest(self.loop_rate)} Hz, "
            f"physics {physics} Hz, {len(self.graphs)} graphs, {len(self.rendering.products)} render products>"
        )

    def _repr_html_(self) -> str:
        from graph.base.html import table

        rows = [("graph", path, "") for path in self.graphs]
        rows += [("render product", one.camera_path, path) for path, one in self.rendering.products.items()]
        for topic in self.bus.topics.values():
            rows.append(("topic", topic.name, f"{topic.type_name}, {topic.messages:,} messages"))
        return table(("part", "name", ""), rows, repr(self))

    # -- the world ---------------------------------------------------------------------------------------------------

    @property
    def stage(self) -> Any:
        """The `Usd.Stage`."""
        return self.world.stage

    @property
    def mjcf(self) -> Any:
        """The MJCF model (`graph.sim.physics.protocol.ModelScene`) that the stage mirrors, or None."""
        return self.world.mjcf

    @property
    def meters_per_unit(self) -> float:
        """Metres in a unit of the stage."""
        return self.world.meters_per_unit

    @property
    def fabric(self) -> PrimPoses:
        """The present transforms of all prims, and attributes that are not on the stage."""
        return self.world.fabric

    @property
    def fidelity(self) -> Fidelity:
        """The fidelity knobs."""
        return self.world.fidelity

    @property
    def folders(self) -> tuple[Path, ...] | None:
        """Folders from which nodes and textures may read files; None: from any. See `World.folders`."""
        return self.world.folders

    @folders.setter
    def folders(self, folders: tuple[Path, ...] | None) -> None:
        self.world.folders = folders

    @property
    def physics(self) -> PhysicsEngine | None:
        """The physics engine; None while stopped or when nothing is dynamic."""
        return self.world.physics

    @property
    def live(self) -> LiveStage | None:
        """Keeps the playing world and its stage consistent; None while stopped."""
        return self.world.live

    @property
    def when_playing(self) -> WhenPlaying:
        """What happens to edits while playing: "refuse", "restart" or "recompile"."""
        return self.world.when_playing

    @when_playing.setter
    def when_playing(self, choice: str) -> None:
        self.world.when_playing = checked_choice(choice)

    geometry = delegate("world", World.geometry)
    forget_geometry = delegate("world", World.forget_geometry)

    def edit(self, when_playing: str | None = None) -> AbstractContextManager[Any]:
        """`with app.edit(when_playing="recompile") as stage:` changes the world, also while playing; see
        `EditStage`.
        """
        return self.world.edit(self.driver, when_playing)

    def add_prims(self, prims: Mapping[str, Mapping[str, Any]], when_playing: str | None = None) -> None:
        """Authors prims inside an `edit`; path to keys as under `scene.prims` in a graph file."""
        self.world.add_prims(self.driver, prims, when_playing)

    def remove_prims(self, *paths: str, when_playing: str | None = None) -> None:
        """Removes prims inside an `edit`. Raises UserError for a missing prim."""
        self.world.remove_prims(self.driver, *paths, when_playing=when_playing)

    def reset(self, scope: str | Reset = "all") -> None:
        """Starts again while playing: the clocks, the bodies, without added prims, or everything; see `Reset`."""
        reset(self.world, self.driver, scope)

    take_stage = delegate("driver", Driver.take_stage)

    # -- clocks and figures ------------------------------------------------------------------------------------------

    @property
    def external_time(self) -> Fraction:
        """The renderer's clock [s], exact; sensor stamps use it."""
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

        1 is real time, below 1 slow motion. It is measured, so on the real clock it includes the machine's speed and
        the pacing.
        """
        return self.driver.speed

    @property
    def timing(self) -> dict[str, float]:
        """Real time spent so far [s] in physics, render, graph and io."""
        return self.driver.timing

    @property
    def update_index(self) -> int:
        """Index of the running update; between updates, the number of updates done."""
        return self.driver.update_index

    @property
    def updating(self) -> bool:
        """Whether an update runs."""
        return self.phases.running

    @property
    def exit_requested(self) -> bool:
        """Whether the end of the run was requested (by a node ExitApplication); no update follows."""
        return self.driver.exit_requested

    @exit_requested.setter
    def exit_requested(self, requested: bool) -> None:
        self.driver.exit_requested = requested

    # -- driving -----------------------------------------------------------------------------------------------------

    def on(self, phase: str, callback: Callback, order: int = 0) -> Unsubscribe:
        """Calls `callback()` in a phase of every update or at an event; returns a function that ends it.

        See `Phases.on`.
        """
        return self.phases.on(phase, callback, order)

    play = delegate("driver", Driver.play)
    pause = delegate("driver", Driver.pause)
    stop = delegate("driver", Driver.stop)
    check_drivable = delegate("driver", Driver.check_drivable)

    update = delegate("driver", Driver.update)
    update_app = delegate("driver", Driver.update_app)

    next_update_async = delegate("driver", Driver.next_update_async)
    update_app_async = delegate("driver", Driver.update_app_async)
    next_render_simulation_async = delegate("driver", Driver.next_render_simulation_async)
    deliver_frames = delegate("driver", Driver.deliver_frames)

    # -- the end -----------------------------------------------------------------------------------------------------

    def tell_closing(self) -> None:
        """Calls the "closing" subscribers, once, while world and sinks are still unchanged.

        `close` does so first; code that reads results before (a report, a recording) calls it earlier. Transforms (TF)
        that a failed update had gathered for its end are published before.
        """
        if not self._told_closing:
            self._told_closing = True
            try:
                self.bus.release()
            finally:
                self.phases["closing"]()

    def close(self) -> None:
        """Calls the "closing" subscribers, stops, calls the "close" subscribers and closes the bus's sinks.

        Each step also runs if one before it failed. References between the parts are removed too, so that a closed App
        is freed with its last reference; its clocks, products and warnings can still be read.
        """
        if self.driver.closed:
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

    def __enter__(self) -> Self:
        entered.enter(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        entered.leave(self)
        try:
            self.close()
        except RunError:
            if error is None:  # the error that ended the run says more than its consequences
                raise
