"""Physics steps: those of an update, direct ones, and the work around each of them."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Protocol

from graph.base import exact
from graph.base.errors import RunError
from graph.base.limits import allowed, most

from . import settings as keys
from .phases import Phases
from .settings import Settings
from .timing.clocks import Accumulator, checked_rate
from .timing.time_queries import TimeQueries
from .world import EXTERNAL_TIME, World

if TYPE_CHECKING:
    from .physics.protocol import PhysicsEngine

_FEW_STEPS = 1000
"""Up to this many steps of an update, the limit is not looked up."""


class StateCaptures(Protocol):
    """The interface of a consumer of poses between two steps (`renderer.scheduler.SensorScheduler`)."""

    next_capture: int
    """The step count after which `capture` must be called."""

    def plan(self, target: int, *, renders_there: bool) -> None:
        """Before steps run up to count `target`: decides after which of them the poses are needed."""

    def capture(self) -> None:
        """Stores the present poses."""


class Simulation:
    """Steps a world on the physics clock.

    Each substep: pre-step subscribers, the engine's step, post-step subscribers below order 0, bookkeeping (count,
    time, external time, system time), a capture of poses if a sensor needs this state, the other post-step subscribers.
    So subscribers below order 0 see the old time, the others the new one.
    """

    def __init__(
        self, world: World, times: TimeQueries, captures: StateCaptures, settings: Settings, phases: Phases
    ) -> None:
        self.clock = times.clock
        self.pre_step = phases["physics_pre_step"]
        self.post_step = phases["physics_post_step"]
        self.enabled = bool(settings.get(keys.PLAY_SIMULATIONS))
        """Whether updates step physics."""
        self._world, self._times, self._captures, self._settings = world, times, captures, settings
        self._accumulator = Accumulator(self.clock.rate)
        self._session = 0
        settings.subscribe(keys.PLAY_SIMULATIONS, self._set_enabled)
        settings.subscribe(keys.MIN_FRAME_RATE, self._set_min_frame_rate)
        world.set_rate(self.clock.rate)
        self._configure()

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

        `callback(i, steps)` is called after step i = 1, 2, ...; False ends it. Fabric always follows if it is on;
        `update_fabric` raises ValueError if it is off. Raises RunError without a built world.
        """
        steps = exact.count(steps, "steps", least=0)
        world = self._world
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
        clock, times, session, before = self.clock, self._times, self._session, self.clock.count
        self._captures.plan(clock.count + steps, renders_there=renders_next)
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
                each = not observed if times.samples.per_substep else not renders_next
                self._world.fabric.set(*EXTERNAL_TIME, clock.seconds)
                times.stepped(done if each else 1)

    def _run_unobserved(self, physics: PhysicsEngine, target: int) -> None:
        """Steps to count `target`, all at once except where poses are captured."""
        fabric, clock, captures = self._world.fabric, self.clock, self._captures
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
        clock, world, captures, session = self.clock, self._world, self._captures, self._session
        fabric, stepped, samples = world.fabric, self._times.stepped, int(self._times.samples.per_substep)
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
        self._times.samples.clear()
        self._world.fabric.set(*EXTERNAL_TIME, 0.0)

    def _set_enabled(self, value: bool) -> None:
        self.enabled = value

    def _set_min_frame_rate(self, value: int) -> None:
        self._configure()

    def _configure(self) -> None:
        self._accumulator.configure(self.clock.rate, self._settings.get(keys.MIN_FRAME_RATE))
