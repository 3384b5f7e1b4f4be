"""The physics side of an App: its clock, the steps of an update, direct steps."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.base import exact
from graph.base.errors import RunError

from . import settings as keys
from .phases import Subscribers
from .state.tensors import Tensors
from .timing.clocks import Accumulator, PhysicsClock, checked_rate
from .timing.time_queries import TimeQueries

if TYPE_CHECKING:
    from .app import App

EXTERNAL_TIME = ("/ExternalSimulationTime", "omni:time")


class Simulation(TimeQueries):
    """Steps the world on the physics clock.

    Each substep: pre-step subscribers, the engine's step, post-step subscribers below order 0, bookkeeping (count,
    time, external time, system time), a capture of poses if a sensor needs this state, the other post-step subscribers.
    Subscribers below order 0 therefore see the old time, the others the new one.
    """

    def __init__(self, app: App, steps_per_second: Fraction) -> None:
        super().__init__(app, PhysicsClock(steps_per_second))
        self.physics: Any = None
        self.tensors = Tensors(app)
        """All bodies, joints and contacts as arrays."""
        self.built = False
        """Whether there is a world: from play, or `initialize_physics`, to stop."""
        self.pre_step = Subscribers()
        self.post_step = Subscribers()
        self._accumulator = Accumulator(steps_per_second)
        self._session = 0
        self._enabled = True
        app.settings.subscribe(keys.PLAY_SIMULATIONS, self._set_enabled)
        app.settings.subscribe(keys.MIN_FRAME_RATE, lambda value: self._configure())
        self._set_enabled(app.settings.get(keys.PLAY_SIMULATIONS))
        self._configure()

    @property
    def steps_per_second(self) -> Fraction:
        """The rate of the next step [Hz]."""
        return self.clock.rate

    @property
    def carry(self) -> Fraction:
        """Time waiting for its physics step [s]."""
        return self._accumulator.carry

    def get_num_physics_steps(self) -> int:
        """Physics steps since play."""
        return self.clock.count

    def is_simulating(self) -> bool:
        """Whether the world is built: True also while paused."""
        return self.built

    def is_paused(self) -> bool:
        """Whether the timeline is paused."""
        return self._app.timeline.is_paused()

    def set_rate(self, steps_per_second: Fraction) -> None:
        """Takes a new rate [Hz] from the next step on, also while playing: the history is then read at the new rate."""
        self.clock.set_rate(checked_rate(steps_per_second, "physics"))
        self._configure()
        if self.physics is not None:
            self.physics.set_dt(1 / steps_per_second)

    def step(
        self,
        *,
        steps: int = 1,
        callback: Callable[[int, int], object] | None = None,
        update_fabric: bool = False,
    ) -> None:
        """Runs `steps` physics steps at once: no timeline, no rendering; the carry is dropped.

        `callback(i, steps)` is called after step i = 1, 2, ...; False ends it. Fabric follows anyhow where it is on;
        ValueError for `update_fabric` where it is off. Raises RunError while there is no world to step.
        """
        steps = exact.count(steps, "steps")
        if not self.built:
            raise RunError("physics cannot step while the timeline is stopped; call app.play() first")
        if self._app.live is not None:
            self._app.live.check()
        if update_fabric and not self._app.fidelity.fabric:
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
        """The physics of one update in which the timeline moved by `elapsed` [s]."""
        if elapsed and self._enabled:
            steps = self._accumulator.take(elapsed)
            if steps:
                self.run_steps(steps, renders_next=True)

    def run_steps(self, steps: int, *, renders_next: bool = False) -> None:
        """Runs `steps` substeps. What was done is on the clocks also when the engine raises."""
        clock, rendering, session, before = self.clock, self._app.rendering, self._session, self.clock.count
        rendering.plan(clock.count + steps, renders_there=renders_next)
        observed = bool(self.pre_step or self.post_step)
        try:
            if observed:
                self._run_observed(steps)
            elif self.physics is None:
                clock.advance(steps)
            else:
                self._run_unobserved(clock.count + steps)
        finally:
            done = clock.count - before
            if self._session == session and done:
                self._publish_time()
                each = not observed if self.samples.per_substep else not renders_next
                self.samples.record(clock, self._system_time, rendering.sample_key, done if each else 1)

    def _run_unobserved(self, target: int) -> None:
        """Steps to count `target`, all at once but for where poses are captured."""
        physics, fabric, clock, rendering = self.physics, self._app.fabric, self.clock, self._app.rendering
        while clock.count < target:
            upcoming = rendering.next_capture
            stop = upcoming if clock.count < upcoming < target else target
            try:
                physics.step(1 if fabric.every_step else stop - clock.count)
            finally:
                if physics.taken:
                    fabric.stepped(physics.taken)
                    clock.advance(physics.taken)
            if clock.count == rendering.next_capture:
                rendering.capture()

    def _run_observed(self, steps: int) -> None:
        clock, rendering, session = self.clock, self._app.rendering, self._session
        for _ in range(steps):
            self.pre_step()
            if self._session != session:  # a subscriber stopped the simulation
                return
            if self.physics is not None:
                self.physics.step()
                self._app.fabric.stepped()
            for callback in self.post_step.before:
                callback()
            if self._session != session:
                return
            clock.advance()
            self._publish_time()
            if self.samples.per_substep:
                self.samples.record(clock, self._system_time, rendering.sample_key)
            if clock.count == rendering.next_capture:
                rendering.capture()
            for callback in self.post_step.after:
                callback()
            if self._session != session:
                return

    def begin(self, physics: Any) -> None:
        """The world is built: takes the engine (None when nothing moves)."""
        self.physics = physics
        self.built = True

    def warm_up(self) -> None:
        """Runs the warm-up steps, if any are set; the carry is dropped with them."""
        steps = int(self._app.settings.get(keys.WARM_UP_STEPS))
        if steps:
            self.run_steps(steps)
            self._accumulator.clear()

    def end(self) -> None:
        """Stop: frees the engine; time, count and carry are 0 again."""
        physics, self.physics = self.physics, None
        self.built = False
        self._session += 1
        self.restart_time()
        if physics is not None:
            physics.close()

    def restart_time(self) -> None:
        """Time, count and carry are 0 again, and no samples are left; the monotonic clock goes on."""
        self.clock.reset()
        self._accumulator.clear()
        self.samples.clear()
        self._app.fabric.set(*EXTERNAL_TIME, 0.0)

    def _publish_time(self) -> None:
        self._app.fabric.set(*EXTERNAL_TIME, self.clock.seconds)
        self._system_time = self._app.wall_clock.now()

    def _set_enabled(self, value: bool) -> None:
        self._enabled = value

    def _configure(self) -> None:
        self._accumulator.configure(self.clock.rate, self._app.settings.get(keys.MIN_FRAME_RATE))
