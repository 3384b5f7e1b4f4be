"""The simulation of one App: its world is built, stepped and freed, with the work around each step."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Literal

from graph.base import exact
from graph.base.errors import RunError
from graph.base.limits import allowed, most
from graph.base.suggesting import Suggesting

from . import settings as keys
from .messages.bus import MessageBus
from .options import frames_come_later
from .phases import Phases
from .renderer.scheduler import SensorScheduler
from .scene.scene_attributes import scene_prims
from .settings import Settings
from .state.tensors import Tensors
from .timing.clocks import Accumulator, PhysicsClock, checked_rate
from .timing.time_queries import TimeQueries
from .timing.timeline import Change, Timeline
from .world import EXTERNAL_TIME, World

if TYPE_CHECKING:
    from .live.animation import Animation
    from .physics.protocol import PhysicsEngine

_FEW_STEPS = 1000
"""Up to this many steps of an update, the limit is not looked up."""


Milestone = Literal["built", "warm", "started", "paused", "resumed", "stopped", "restored"]
"""The world is built, warm, plays; the timeline pauses, resumes, stops; the world is freed and the stage restored."""


class Simulation(TimeQueries, Suggesting):
    """The simulation of one App: builds, steps and frees its world on the physics clock, and gives the times.

    Each substep: pre-step subscribers, the engine's step, post-step subscribers below order 0, bookkeeping (count,
    time, external time, system time), a capture of poses if a sensor needs this state, the other post-step subscribers.
    So subscribers below order 0 see the old time, the others the new one.

    It is *warm* from the end of `initialize_physics`, which playing calls, to `invalidate_physics`, which stopping
    calls.
    """

    def __init__(
        self,
        world: World,
        clock: PhysicsClock,
        scheduler: SensorScheduler,
        timeline: Timeline,
        bus: MessageBus,
        settings: Settings,
        phases: Phases,
        now: Callable[[], Fraction],
        *,
        follows_stage_rate: bool,
    ) -> None:
        """now: the wall clock's time [s]. follows_stage_rate: play takes the rate of the active physics scene."""
        super().__init__(clock, scheduler, settings, now, world.warn)
        self.pre_step = phases["physics_pre_step"]
        self.post_step = phases["physics_post_step"]
        self.enabled = bool(settings.get(keys.PLAY_SIMULATIONS))
        """Whether updates step physics."""
        self.warm = False
        """Whether `initialize_physics` has been done since the last stop."""
        self.warms_up = True
        """Whether play and resume warm up and reach the milestones "started" and "resumed"."""
        self.cools = True
        """Whether stop ends the warm state."""
        self.tensors = Tensors(world)
        """All bodies, joints and contacts as arrays."""
        self._world, self._scheduler, self._timeline, self._bus = world, scheduler, timeline, bus
        self._settings, self._phases = settings, phases
        self._accumulator = Accumulator(clock.rate)
        self._session = 0
        self._animation: Animation | None = None
        self._follows_stage_rate = follows_stage_rate
        self._authored_rate = world.authored_rate
        world.let_take_rate(self._take_authored_rate)
        settings.subscribe(keys.PLAY_SIMULATIONS, self._set_enabled)
        settings.subscribe(keys.MIN_FRAME_RATE, lambda value: self._configure())
        world.set_rate(clock.rate)
        self._configure()
        self._set_up_scheduler()

    # -- life --------------------------------------------------------------------------------------------------------

    def build(self) -> None:
        """Builds the world and binds sensors to it; playing calls it."""
        from .live.animation import animate
        from .scene.diagnostics import quiet
        from .scene.stage_metadata import scene_name

        self._take_authored_rate()
        with quiet(self._world.warn, scene_name(self._world.stage)):
            self._world.build()
            self._set_up_scheduler()
            self._scheduler.capture_state = self._world.fabric.capture
            self._scheduler.begin_play()
            self._animation = animate(self._world, self._timeline, self, self._phases)
            self._reached("built")

    @property
    def animated(self) -> tuple[str, ...]:
        """The prims that follow time samples while this world plays."""
        return () if self._animation is None else self._animation.paths

    def free(self) -> None:
        """Frees what `build` has built and restores the stage; stopping calls it."""
        if self._animation is not None:
            self._animation.close()
            self._animation = None
        self._world.release()
        self.end()
        if self.cools:
            self.warm = False
        self._scheduler.capture_state = None
        self._scheduler.end_play()
        self._bus.restart()
        self._world.restore()
        self._reached("restored")

    def _take_authored_rate(self) -> None:
        """Takes a rate that was authored on the active physics scene since the last reading."""
        authored, before = self._world.authored_rate, self._authored_rate
        self._authored_rate = authored
        if not self._follows_stage_rate or authored is None or authored == before:
            return
        if not authored:
            self.refuse_rate_zero()
        elif float(authored) != float(self.clock.rate):  # not written by `set_dt`, whose exact rate is used
            self.set_rate(max(Fraction(1), Fraction(int(authored))) if self.truncates else authored)

    def follow(self, change: Change) -> None:
        """Applies a change of the timeline's state to the world: builds or frees it, calls subscribers."""
        if change == "stop":
            self._phases["stopping"]()
            self.free()
        elif change == "play" and not self.built:
            self.build()
        try:
            self._phases[change]()
            self._followed(change)
        except BaseException:
            if change == "play":
                self.free()
            raise

    def initialize_physics(self) -> None:
        """Builds the world if needed and runs the warm-up steps; does nothing when warm.

        Playing calls it. If it is called while stopped, the world exists until `invalidate_physics` or stop.
        """
        if self.warm:
            return
        if not self.built:
            self.build()
        self.warm_up()
        self.warm = True
        self._reached("warm")

    def invalidate_physics(self) -> None:
        """Ends the warm state: the next play warms up again. If the timeline is not playing the world is freed."""
        self.warm = False
        if self.built and self._timeline.is_stopped():
            self.free()

    def _followed(self, change: Change) -> None:
        """Reaches the milestone of a change of the timeline's state; a play also warms up, if `warms_up`."""
        if self._timeline.silent:
            return
        if change == "pause":
            self._reached("paused")
        elif change == "stop":
            self._reached("stopped")
        elif self.warms_up and self._settings.get(keys.PLAY_SIMULATIONS):
            if self.warm:
                self._reached("resumed")
            else:
                self.initialize_physics()
                self._reached("started")

    def _reached(self, milestone: Milestone) -> None:
        """Called at each milestone, after its own work and subscribers."""

    def take_stage(self, default_rate: Fraction) -> None:
        """Takes the rate [Hz] of another stage, which has taken the place of the former one; else `default_rate`."""
        self._authored_rate = self._world.authored_rate
        if self._follows_stage_rate:
            self.set_rate(self._authored_rate or default_rate)

    def close(self) -> None:
        """Called when the App closes, after the last stop."""

    def refuse_rate_zero(self, path: str | None = None) -> None:
        """Warns that 0 steps per second is stored but not run.

        In the product, a world that is not built yet runs at 1 Hz.
        """
        if self.truncates and not self.built:
            self.set_rate(Fraction(1))
        if not self.built:
            self._take_authored_rate()  # play would
        message = (
            f"a dt of 0 is stored, but physics does not run at rate 0; it goes on at {float(self.clock.rate):g} Hz"
        )
        self._world.warn("physics-rate-zero", path or str(next(scene_prims(self._world.stage)).GetPath()), message)

    def _set_up_scheduler(self) -> None:
        settings, scheduler = self._settings, self._scheduler
        scheduler.multi_tick = settings.get(keys.MULTI_TICK)
        scheduler.capture_at_ticks = self._world.fidelity.tlas == "sensor" and settings.get(keys.SENSOR_TICK_TLAS)
        scheduler.autotrigger_idle = settings.get(keys.AUTOTRIGGER_IDLE)
        scheduler.frames_later = frames_come_later(settings)

    # -- steps ---------------------------------------------------------------------------------------------------------

    @property
    def truncates(self) -> bool:
        """Whether a dt is stored as a whole number of steps per second, as in the profile `isaacsim-6.0.1`."""
        return bool(self._settings.get(keys.TRUNCATE_STEPS))

    @property
    def physics(self) -> PhysicsEngine | None:
        """The physics engine; None while stopped or when nothing is dynamic."""
        return self._world.physics

    @property
    def built(self) -> bool:
        """Whether there is a world: from play, or `initialize_physics`, to stop."""
        return self._world.built

    def is_paused(self) -> bool:
        """Whether the timeline is paused."""
        return self._timeline.is_paused()

    @property
    def steps_per_second(self) -> Fraction:
        """The rate of the next step [Hz]."""
        return self.clock.rate

    @property
    def carry(self) -> Fraction:
        """Time that waits for its physics step [s]."""
        return self._accumulator.carry

    def get_num_physics_steps(self) -> int:
        """Physics steps since play."""
        return self.clock.count

    def is_simulating(self) -> bool:
        """Whether the world is built: True also while paused."""
        return self._world.built

    def set_rate(self, steps_per_second: Fraction) -> None:
        """Sets a new rate [Hz] from the next step on.

        Simulation time is steps / rate: while playing it jumps, with a warning (`simulation-time-moved`).
        """
        count, before = self.clock.count, self.clock.rate
        self.clock.set_rate(checked_rate(steps_per_second, "physics"))
        if count and steps_per_second != before:
            self._world.warn(
                "simulation-time-moved",
                "simulation",
                f"physics goes from {float(before):g} to {float(steps_per_second):g} Hz while playing, and simulation "
                f"time, steps / rate, from {float(count / before):g} to {float(count / steps_per_second):g} s; sensors "
                "start again there; stop first to keep the time",
            )
        self._configure()
        self._world.set_rate(steps_per_second)

    def step(
        self,
        *,
        steps: int = 1,
        callback: Callable[[int, int], object] | None = None,
        update_fabric: bool = False,
    ) -> None:
        """Runs `steps` physics steps at once: no timeline, no rendering; the carry is dropped.

        A play that waits for the next update is applied first.
        `callback(i, steps)` is called after step i = 1, 2, ...; False ends it. Fabric always follows if it is on;
        `update_fabric` raises ValueError if it is off. Raises RunError without a built world.
        """
        steps = exact.count(steps, "steps", least=0)
        world = self._world
        if not world.built:
            self._timeline.commit()
        if not world.built:
            raise RunError("physics cannot step while the timeline is stopped; call app.play() first")
        if world.live is not None:
            world.live.check()
        if update_fabric and not world.fidelity.fabric:
            raise ValueError("update_fabric: Fabric is off; call app.simulation.enable_fabric(True) while stopped")
        self._accumulator.clear()
        if callback is None:
            if steps > 0:
                self.run_steps(steps)
            return
        session = self._session
        for done in range(1, steps + 1):
            self.run_steps(1)
            if callback(done, steps) is False or self._session != session:  # or it stopped the simulation
                return

    def run_update(self, elapsed: Fraction) -> None:
        """The physics of one update in which the timeline advanced by `elapsed` [s]."""
        if elapsed and self.enabled:
            steps = self._accumulator.take(elapsed)
            if steps > _FEW_STEPS and self._world.physics is not None and steps > most("clock.steps"):
                raise RunError(f"this update would make {steps:,} physics steps; {allowed('clock.steps')}")
            if steps:
                self.run_steps(steps, renders_next=True)

    def run_steps(self, steps: int, *, renders_next: bool = False) -> None:
        """Runs `steps` substeps. The clocks count finished steps also if the engine raises."""
        clock, session, before = self.clock, self._session, self.clock.count
        self._scheduler.plan(clock.count + steps, renders_there=renders_next)
        observed = bool(self.pre_step or self.post_step)
        try:
            if observed:
                self._run_observed(steps)
            elif self._world.physics is None:
                clock.advance(steps)
            else:
                self._run_unobserved(self._world.physics, clock.count + steps)
        finally:
            done = clock.count - before
            if self._session == session and done:
                each = not observed if self.samples.per_substep else not renders_next
                self._world.fabric.set(*EXTERNAL_TIME, clock.seconds)
                self.stepped(done if each else 1)

    def _run_unobserved(self, physics: PhysicsEngine, target: int) -> None:
        """Steps to count `target`, all at once except where poses are captured."""
        fabric, clock, captures = self._world.fabric, self.clock, self._scheduler
        while clock.count < target:
            upcoming = captures.next_capture
            stop = upcoming if clock.count < upcoming < target else target
            try:
                physics.step(1 if fabric.every_step else stop - clock.count)
            finally:
                if physics.taken:
                    fabric.stepped(physics.taken)
                    clock.advance(physics.taken)
            if clock.count == captures.next_capture:
                captures.capture()

    def _run_observed(self, steps: int) -> None:
        clock, world, captures, session = self.clock, self._world, self._scheduler, self._session
        fabric, stepped, samples = world.fabric, self.stepped, int(self.samples.per_substep)
        for _ in range(steps):
            self.pre_step()
            if self._session != session:  # a subscriber stopped the simulation
                return
            if world.physics is not None:
                world.physics.step()
                fabric.stepped()
            for callback in self.post_step.before:
                callback()
            if self._session != session:
                return
            clock.advance()
            fabric.set(*EXTERNAL_TIME, clock.seconds)
            stepped(samples)
            if clock.count == captures.next_capture:
                captures.capture()
            for callback in self.post_step.after:
                callback()
            if self._session != session:
                return

    def warm_up(self) -> None:
        """Runs the warm-up steps, if any are set; then drops the carry."""
        steps = int(self._settings.get(keys.WARM_UP_STEPS))
        if steps:
            self.run_steps(steps)
            self._accumulator.clear()

    def end(self) -> None:
        """Stop: ends running steps; time, count and carry are 0 again."""
        self._session += 1
        self.restart_time()

    def restart_time(self) -> None:
        """Sets time, count and carry to 0 and drops the samples; the monotonic clock continues."""
        self.clock.reset()
        self._accumulator.clear()
        self.samples.clear()
        self._world.fabric.set(*EXTERNAL_TIME, 0.0)

    def _set_enabled(self, value: bool) -> None:
        self.enabled = value

    def _configure(self) -> None:
        self._accumulator.configure(self.clock.rate, self._settings.get(keys.MIN_FRAME_RATE))
