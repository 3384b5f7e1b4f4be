"""The App: one world, its clocks, and the update that moves them through the phases."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, ClassVar

from graph.base import exact
from graph.base.errors import RunError, UserError

from . import settings as keys
from .fidelity import Fidelity
from .managers.drivers import Drivers
from .managers.simulation_manager import ManagedSimulation
from .messages.bus import MessageBus
from .options import clock_rates, experience_settings, refuse_unavailable
from .phases import EVENTS, PHASES, Callback, Subscribers, Unsubscribe
from .renderer.rendering import Rendering
from .scene.editing import checked_choice
from .settings import Settings, suggestion
from .timing.parity import apply_profile
from .timing.run_loop import RunLoop
from .timing.speed import Speed, follow_timeline
from .timing.timeline import Change, Timeline
from .timing.wall_clock import VirtualClock, WallClock
from .warnings import WarningList
from .world import World

if TYPE_CHECKING:
    from types import TracebackType


class App(Drivers, World):
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
        when_playing: str | None = None,
    ) -> None:
        from .scene.stage import meters_per_unit, open_stage, physics_scene_rate, register_schemas, time_range

        self.fidelity = fidelity if isinstance(fidelity, Fidelity) else Fidelity.from_mapping(fidelity or {})
        refuse_unavailable(experience, parity, self.fidelity)
        self.experience, self.parity, self.seed = experience, parity, exact.count(seed, "seed")
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
            if not hasattr(stage, "GetRootLayer"):
                raise UserError(f"stage {stage!r}: give the path of a USD file, a Usd.Stage, or None for an empty one")
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
        self._make_world(checked_choice(when_playing or str(self.settings.get(keys.WHEN_PLAYING))))
        self.timeline = Timeline(self.settings, self._on_change)
        if played := time_range(stage, self.warn):
            self.timeline.set_range(*played)
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
        self._told_closing = False
        self._closed = False

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

    @property
    def updating(self) -> bool:
        """Whether an update runs."""
        return self._updating

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
        steps = exact.count(steps, "steps")
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

    def tell_closing(self) -> None:
        """Tells the "closing" subscribers, once, that the App is about to close: world and sinks are as they were.

        `close` does so first; who reads results before that (a report, a recording) calls it ahead of reading them.
        """
        if not self._told_closing:
            self._told_closing = True
            self._subscribers["closing"]()

    def close(self) -> None:
        """Tells the "closing" subscribers, stops, tells the "close" subscribers and closes the bus's sinks.

        Each also when one before it fails.
        """
        if self._closed:
            return
        self._closed = True
        failure: BaseException | None = None
        for action in (
            self.tell_closing,
            self.stop,
            *self._close_actions(),
            self.simulation.close,
            self.bus.close,
            self.fabric.close,
        ):
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
        try:
            self.close()
        except RunError:
            if error is None:  # what ended the run says more than what its end led to
                raise
