"""The App: one world, its clocks, and the update that moves them through the phases."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, ClassVar

from graph.errors import RunError, UserError

from . import settings as keys
from .bus import MessageBus
from .clocks import checked_rate
from .drivers import Drivers
from .editing import EditStage, WhenPlaying, checked_choice, remove_prims
from .fidelity import Fidelity
from .options import clock_rates, experience_settings, frames_come_later, refuse_unavailable
from .parity import apply_profile
from .phases import EVENTS, PHASES, Callback, Subscribers, Unsubscribe
from .rendering import Rendering
from .reset import Reset, reset
from .run_loop import RunLoop
from .settings import Settings, suggestion
from .simulation import EXTERNAL_TIME
from .simulation_manager import ManagedSimulation
from .speed import Speed, follow_timeline
from .timeline import Change, Timeline
from .wall_clock import VirtualClock, WallClock
from .warnings import WarningList

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from types import TracebackType


class App(Drivers):
    """One world and its clocks. Several may live in one process; the most recently entered one is the default.

    `stage` is a path, a `Usd.Stage` or None for an empty stage; `mjcf`, instead of it, an MJCF file or a loaded
    `MjcfScene`. `physics_hz` beats the stage's physics scene or the MJCF time step, which beat 60; `loop_hz` defaults
    to 60. `fidelity` maps knobs (`lidar.motion`) to values. Raises UserError for options that cannot be run.
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
        when_playing: str = "refuse",
    ) -> None:
        from .stage import meters_per_unit, open_stage, physics_scene_rate, register_schemas

        self.fidelity = fidelity if isinstance(fidelity, Fidelity) else Fidelity.from_mapping(fidelity or {})
        refuse_unavailable(experience, parity, self.fidelity)
        self.experience, self.parity, self.seed = experience, parity, seed
        self.settings = Settings(settings)
        apply_profile(self.settings, parity)
        self.warnings = WarningList()
        for path in self.settings.misspelt():
            self.warn("setting-unknown", path, f'no part of this run reads it; did you mean "{suggestion(path)}"?')
        self.mjcf = self._open_mjcf(mjcf, stage)
        """The MJCF model (`graph.sim.mjcf.MjcfScene`) that the stage mirrors, if it does."""
        if self.mjcf is not None:
            stage = self.mjcf.stage
        if stage is None or isinstance(stage, (str, Path)):
            stage = open_stage(stage, warn=self.warn)
        else:
            register_schemas()
        self.stage = stage
        self.meters_per_unit: float = meters_per_unit(stage)
        authored = physics_scene_rate(stage) if self.mjcf is None else self.mjcf.physics_rate
        physics_rate, loop_rate = clock_rates(
            physics_hz,
            loop_hz,
            experience,
            authored,
            self.fidelity.physics_hz,
            whole=self.settings.get(keys.TRUNCATE_STEPS),
            warn=self.warn,
        )
        experience_settings(self.settings, experience, loop_rate if loop_hz is not None else None, stage)

        self.wall_clock: WallClock = wall_clock if wall_clock is not None else VirtualClock()
        self.run_loop = RunLoop(self.settings, self.wall_clock, 1 / loop_rate)
        self.bus = MessageBus()
        self.when_playing: WhenPlaying = checked_choice(when_playing)
        self.fabric: Any = None
        self._renew_fabric()
        self.timeline = Timeline(self.settings, self._on_change)
        self.simulation = ManagedSimulation(self, physics_rate)
        if authored == 0 and physics_hz is None and self.fidelity.physics_hz is None:
            self.simulation.refuse_rate_zero()
        self.rendering = Rendering(self)
        self._make_drivers()
        self._read_rendering_settings()
        self._speed = Speed(self.wall_clock.now)
        self.graphs: dict[str, Any] = {}
        """The graphs bound to this App, by path; filled by whoever binds them."""
        self.folders: tuple[Path, ...] = ()
        """What nodes may read files from: the graph file's folder and those the user allows; the first is for names."""
        self.update_index = 0
        """Index of the running update, else the number of updates done."""
        self.exit_requested = False
        """Whether something (a node ExitApplication) asked the run to end; nothing is updated after that update."""
        self._subscribers = {name: Subscribers() for name in (*PHASES, *EVENTS)}
        self.output_folder: Path | None = None
        """Where the run writes; None where it writes nothing."""
        self._subscribers["physics_pre_step"] = self.simulation.pre_step
        self._subscribers["physics_post_step"] = self.simulation.post_step
        if self.mjcf is not None:
            from .mjcf.controls import serve

            serve(self.mjcf, self)
        self.on("resume", self.simulation.resample, -1)
        follow_timeline(self, self._speed)
        phases = self._subscribers
        self._timeline_state, self._timeline_phase = phases["timeline_state"], phases["timeline"]
        self._physics_phase, self._graphs_phase = phases["physics"], phases["simulation_graphs"]
        self._render_phase, self._frames_phase = phases["render"], phases["post_render_graphs"]
        self._end_phase = phases["end"]
        self._physics_s = self._render_s = self._graph_s = 0.0
        self._updating = False
        self._closed = False
        self._stage_state: Any = None
        self.live: Any = None
        """Keeps the playing world and its stage together (`graph.sim.live_stage.LiveStage`); None while stopped."""
        self.animation: Any = None
        """Plays transforms with time samples (`graph.sim.animation.Animation`); None while stopped or without any."""
        self._geometry: Any = None

    def _open_mjcf(self, mjcf: Any, stage: Any) -> Any:
        if isinstance(mjcf, (str, Path)):
            if stage is not None:
                raise UserError("App: give a stage or an MJCF file, not both")
            from .mjcf.scene import open_mjcf

            return open_mjcf(mjcf, warn=self.warn)
        return mjcf

    @classmethod
    def from_file(cls, path: str | Path, **options: Any) -> App:
        """The App of a graph file, its graphs bound to it. Options as in `graph.assembly.open_session`."""
        app: App = import_module("graph.assembly").open_app(cls, path, **options)
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

    @property
    def physics(self) -> Any:
        """The physics engine; None while stopped or when nothing is dynamic."""
        return self.simulation.physics

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
        return self._speed.ratio(self.simulation.monotonic_time)

    @property
    def timing(self) -> dict[str, float]:
        """Real time spent so far [s] in physics, render, graph and io."""
        return {
            "physics": self._physics_s,
            "render": self._render_s,
            "graph": self._graph_s,
            "io": self.bus.io_seconds,
        }

    def geometry(self) -> Any:
        """What rays can hit (`graph.sim.geometry.collect_geometry`), collected once per play."""
        if self._geometry is None:
            from .geometry import collect_geometry
            from .scan import scan_stage

            scan = scan_stage(self.stage, self.fabric.promoted)
            fine = self.fidelity.mesh_subdivision == "refined"
            self._geometry = collect_geometry(self.stage, self.fidelity.mesh_tolerance, self.warn, scan, refine=fine)
        return self._geometry

    def forget_geometry(self) -> None:
        """Has what rays can hit collected anew when it is needed next."""
        self._geometry = None

    @property
    def updating(self) -> bool:
        """Whether an update runs."""
        return self._updating

    def edit(self, when_playing: str | None = None) -> AbstractContextManager[Any]:
        """`with app.edit(when_playing="recompile") as stage:` changes the world while it plays too; see `EditStage`."""
        return EditStage(self, self.when_playing if when_playing is None else checked_choice(when_playing))

    def add_prims(self, prims: Mapping[str, Mapping[str, Any]], when_playing: str | None = None) -> None:
        """Authors prims, path to keys as under `scene.prims` in a graph file, inside an `edit`."""
        from .prims import author_prims

        with self.edit(when_playing) as stage:
            author_prims(stage, prims, warn=self.warn)

    def remove_prims(self, *paths: str, when_playing: str | None = None) -> None:
        """Removes prims, inside an `edit`. Raises UserError for one that is not there."""
        with self.edit(when_playing) as stage:
            remove_prims(stage, paths)

    def reset(self, scope: str | Reset = "all") -> None:
        """Begins anew while playing: the clocks, the bodies, without what was added, or all of it; see `Reset`."""
        reset(self, scope)

    def on(self, phase: str, callback: Callback, order: int = 0) -> Unsubscribe:
        """Calls `callback()` in a phase of every update or at an event; returns what ends that.

        Lower order first, ties in the order of registration; the phase's own work stands at order 0, ahead of the
        subscribers of order 0. `post_render_graphs` runs only in updates that delivered a frame.
        """
        if phase not in self._subscribers:
            raise UserError(f"there is no phase or event {phase!r}; there are {', '.join(self._subscribers)}")
        return self._subscribers[phase].add(callback, order)

    def warn(self, code: str, where: str, message: str) -> None:
        """Notes a warning: said once per code and place, counted."""
        self.warnings.add(code, where, message)

    def check_drivable(self) -> None:
        """Raises RunError where no update can run: inside one, or after `close`."""
        if self._updating:
            raise RunError("update() was called from inside an update; a subscriber must not drive the App")
        if self._closed:
            raise RunError("the App is closed; make a new one")

    def update(self, steps: int = 1) -> None:
        """Runs `steps` app updates, each through all phases; fewer once the run is asked to end."""
        self.check_drivable()
        self._updating = True
        try:
            for _ in range(steps):
                self._update()
                self.rendering.end_update()
                self.update_index += 1
                if self.exit_requested:
                    break
        finally:
            self.rendering.end_update()
            self._updating = False

    def _update(self) -> None:
        rendering, bus = self.rendering, self.bus
        bus.begin_update()
        dt = self.run_loop.begin()
        if rendering.frames_later:
            rendering.deliver_pending()
            self._hand_over()

        for callback in self._timeline_state.before:
            callback()
        self.timeline.commit()
        for callback in self._timeline_state.after:
            callback()
        rendering.begin_update(dt)
        if self.live is not None:
            self.live.check()

        for callback in self._timeline_phase.before:
            callback()
        elapsed = self.timeline.advance(dt)
        for callback in self._timeline_phase.after:
            callback()

        started = perf_counter()
        for callback in self._physics_phase.before:
            callback()
        try:
            self.simulation.run_update(elapsed)
        finally:
            done = perf_counter()
            self._physics_s += done - started
        for callback in self._physics_phase.after:
            callback()

        io = bus.io_seconds
        self._graphs_phase()
        started = perf_counter()
        self._graph_s += started - done - (bus.io_seconds - io)

        for callback in self._render_phase.before:
            callback()
        rendering.render_due(playing=self.timeline.is_playing())
        for callback in self._render_phase.after:
            callback()
        done = perf_counter()
        self._render_s += done - started

        if rendering.new_frames and not rendering.frames_later:
            self._hand_over()

        self._end_phase()
        self.run_loop.end()

    def deliver_frames(self) -> None:
        """Delivers now what was rendered and would only arrive with the next update (profile `isaacsim-6.0.1`)."""
        if self.rendering.pending_frames:
            self.rendering.deliver_pending()
            self._hand_over()

    def _hand_over(self) -> None:
        rendering, bus = self.rendering, self.bus
        if not rendering.new_frames:
            return
        began, io = perf_counter(), bus.io_seconds
        for callback in self._frames_phase.before:
            callback()
        rendering.hand_over()
        for callback in self._frames_phase.after:
            callback()
        self._graph_s += perf_counter() - began - (bus.io_seconds - io)

    def set_loop_step(self, step: Fraction) -> None:
        """Makes an update last `step` [s] on every clock that follows the loop.

        The rate limit and the target frame rate follow always, or only while rate limiting is on (see
        `graph.sim.parity`).
        """
        frequency = checked_rate(1 / step, "loop")
        plain = frequency.numerator if frequency.denominator == 1 else frequency
        self.run_loop.manual_step = step
        self.run_loop.manual_mode = True
        self.settings.set(keys.MANUAL_MODE, True)
        if self.settings.get(keys.SET_DT_RATE_LIMIT) or self.settings.get(keys.RATE_LIMIT_ENABLED):
            self.settings.set(keys.RATE_LIMIT_FREQUENCY, plain)
            self.timeline.set_target_framerate(frequency)
        self.stage.SetTimeCodesPerSecond(float(frequency))
        self.timeline.set_time_codes_per_second(frequency)
        period = step.limit_denominator(10**9)
        self.settings.set("/app/settings/fabricDefaultSimPeriodNumerator", period.numerator)
        self.settings.set("/app/settings/fabricDefaultSimPeriodDenominator", period.denominator)

    def _on_change(self, change: Change) -> None:
        if change == "stop":
            self.free_world()
        elif change == "play" and not self.simulation.built:
            self.build_world()
        try:
            self._subscribers[change]()
            self.simulation.announce(change)
        except BaseException:
            if change == "play":
                self.free_world()
            raise

    def _renew_fabric(self) -> None:
        from .fabric import Fabric
        from .stage_transforms import StageTransforms

        old = self.fabric
        kind: Any = Fabric if self.fidelity.fabric else StageTransforms
        self.fabric = kind(self.stage, self.warn)
        if old is None:
            self.fabric.set(*EXTERNAL_TIME, 0.0)
        else:
            self.fabric.take_values(old)
            old.close()

    def build_world(self) -> None:
        """Builds physics from the stage and binds Fabric and sensors to it; playing does so by itself."""
        from .animation import animate
        from .live_stage import LiveStage
        from .physics import build_physics
        from .stage import StageState

        self._geometry = None
        if self.fabric.enabled != self.fidelity.fabric:
            self._renew_fabric()
        self._stage_state = StageState(self.stage)
        physics = None
        try:
            dt = 1 / self.simulation.steps_per_second
            physics = build_physics(self.stage, dt, self.fidelity, warn=self.warn, mjcf=self.mjcf)
            self.fabric.bind(physics)
        except BaseException:
            if physics is not None:
                physics.close()
            self._stage_state.restore()
            raise
        self._read_rendering_settings()
        self.rendering.capture_state = self.fabric.capture
        self.rendering.begin_play()
        self.simulation.physics = physics
        self.live = LiveStage(self)
        self.animation = animate(self)
        self.simulation.begin(physics)

    def _read_rendering_settings(self) -> None:
        settings, rendering = self.settings, self.rendering
        rendering.multi_tick = settings.get(keys.MULTI_TICK)
        rendering.capture_at_ticks = self.fidelity.tlas == "sensor" and settings.get(keys.SENSOR_TICK_TLAS)
        rendering.autotrigger_idle = settings.get(keys.AUTOTRIGGER_IDLE)
        rendering.frames_later = frames_come_later(settings)

    def free_world(self) -> None:
        """Frees what `build_world` has built and puts the stage back; stopping does so by itself."""
        if self.live is not None:
            self.live.close()
            self.live = None
        if self.animation is not None:
            self.animation.close()
            self.animation = None
        self.fabric.unbind()
        self.simulation.end()
        self.rendering.capture_state = None
        self.rendering.end_play()
        self.bus.restart()
        self._geometry = None
        self._stage_state.restore()
        self.simulation.keep_scene_changes()

    def close(self) -> None:
        """Stops, tells the "close" subscribers and closes the bus's sinks; each also when one before it fails."""
        if self._closed:
            return
        self._closed = True
        failure: BaseException | None = None
        for action in (self.stop, *self._close_actions(), self.simulation.close, self.bus.close, self.fabric.close):
            try:
                action()
            except BaseException as error:
                failure = failure or error
        for subscribers in self._subscribers.values():
            subscribers.clear()
        if failure is not None:
            raise failure

    def _close_actions(self) -> tuple[Callable[[], object], ...]:
        closing = self._subscribers["close"]
        return (*closing.before, *closing.after)

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
        self.close()
