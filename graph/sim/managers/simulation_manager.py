"""`app.simulation`: the calls of Isaac Sim's SimulationManager over the steps of one App."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.base.suggesting import Suggesting
from graph.sim import settings as keys
from graph.sim.forwarding import forward
from graph.sim.messages.bus import MessageBus
from graph.sim.options import frames_come_later
from graph.sim.phases import Phases
from graph.sim.settings import Settings
from graph.sim.simulation import Simulation
from graph.sim.state.tensors import Tensors
from graph.sim.timing.clocks import PhysicsClock
from graph.sim.timing.time_queries import TimeQueries
from graph.sim.timing.timeline import Change, Timeline
from graph.sim.world import World

from .callbacks import Registered
from .simulation_events import IsaacEvents, SimulationEvent, SimulationEvents
from .simulation_setup import SimulationSetup

if TYPE_CHECKING:
    from graph.sim.live.animation import Animation
    from graph.sim.physics.protocol import PhysicsEngine

    from .rendering import Rendering

_CHANGES: dict[Change, SimulationEvent] = {
    "pause": SimulationEvent.SIMULATION_PAUSED,
    "stop": SimulationEvent.SIMULATION_STOPPED,
}
_DEFAULTS = ("warm_start", "on_stop", "stage_open", "stage_close", "post_warm_start")


class ManagedSimulation(Suggesting):
    """The simulation of one App: builds, steps and frees its world, gives the time, calls callbacks.

    It is *warm* from the end of `initialize_physics`, which playing calls, to `invalidate_physics`, which stopping
    calls. Only a warm simulation calls physics-step callbacks. Its parts: `steps` runs physics, `times` gives present
    and past times, `setup` holds the choices, `events` the callbacks.
    """

    def __init__(
        self,
        world: World,
        clock: PhysicsClock,
        rendering: Rendering,
        timeline: Timeline,
        bus: MessageBus,
        settings: Settings,
        phases: Phases,
        now: Callable[[], Fraction],
        *,
        follows_stage_rate: bool,
    ) -> None:
        """now: the wall clock's time [s]. follows_stage_rate: play takes the rate of the active physics scene."""
        self._world, self._rendering, self._timeline, self._bus = world, rendering, timeline, bus
        self._scheduler = rendering.scheduler
        self._settings, self._phases = settings, phases
        self.times = TimeQueries(clock, rendering.scheduler, settings, now, world.warn)
        self.steps = Simulation(world, self.times, rendering.scheduler, settings, phases)
        self.setup = SimulationSetup(world, self.steps, timeline, settings)
        self.events = SimulationEvents(world, self.steps, self.setup)
        self.clock = clock
        self.samples = self.times.samples
        self.pre_step, self.post_step = self.steps.pre_step, self.steps.post_step
        self.tensors = Tensors(world)
        """All bodies, joints and contacts as arrays."""
        self._follows_stage_rate = follows_stage_rate
        self._authored_rate = world.authored_rate
        world.let_take_rate(self._take_authored_rate)
        self._animation: Animation | None = None
        self._defaults = dict.fromkeys(_DEFAULTS, True)
        self._set_up_scheduler()

    # -- what the parts do -------------------------------------------------------------------------------------------

    @property
    def physics(self) -> PhysicsEngine | None:
        """The physics engine; None while stopped or when nothing is dynamic."""
        return self._world.physics

    @property
    def built(self) -> bool:
        """Whether there is a world: from play, or `initialize_physics`, to stop."""
        return self._world.built

    @property
    def steps_per_second(self) -> Fraction:
        """The rate of the next step [Hz]."""
        return self.clock.rate

    @property
    def carry(self) -> Fraction:
        """Time that waits for its physics step [s]."""
        return self.steps.carry

    @property
    def time(self) -> Fraction:
        """The exact simulation time [s]: steps since play / steps per second."""
        return self.clock.time

    @property
    def monotonic_time(self) -> Fraction:
        """The exact time stepped since the App was made [s]; survives stop and changes of rate."""
        return self.clock.monotonic

    @property
    def system_time(self) -> float:
        """Wall-clock time [UNIX s] at the last physics step, before the first one at the App's construction."""
        return self.times.system_time

    @property
    def scene_path(self) -> str:
        """The path of the simulated scene, looked up when the world is built."""
        return self.setup.scene_path

    @property
    def truncates(self) -> bool:
        """Whether a dt is stored as a whole number of steps per second, as in the profile `isaacsim-6.0.1`."""
        return self.setup.truncates

    run_steps = forward("steps", Simulation.run_steps)
    set_rate = forward("steps", Simulation.set_rate)
    is_simulating = forward("steps", Simulation.is_simulating)
    get_num_physics_steps = forward("steps", Simulation.get_num_physics_steps)

    get_simulation_time = forward("times", TimeQueries.get_simulation_time)
    get_simulation_time_monotonic = forward("times", TimeQueries.get_simulation_time_monotonic)
    get_system_time = forward("times", TimeQueries.get_system_time)
    get_current_time = forward("times", TimeQueries.get_current_time)
    get_simulation_time_at_time = forward("times", TimeQueries.get_simulation_time_at_time)
    get_simulation_time_monotonic_at_time = forward("times", TimeQueries.get_simulation_time_monotonic_at_time)
    get_system_time_at_time = forward("times", TimeQueries.get_system_time_at_time)
    frame_key = forward("times", TimeQueries.frame_key)
    of_frame = forward("times", TimeQueries.of_frame)
    get_all_samples = forward("times", TimeQueries.get_all_samples)
    get_sample_count = forward("times", TimeQueries.get_sample_count)
    get_sample_range = forward("times", TimeQueries.get_sample_range)
    get_buffer_capacity = forward("times", TimeQueries.get_buffer_capacity)
    log_statistics = forward("times", TimeQueries.log_statistics)

    setup_simulation = forward("setup", SimulationSetup.setup_simulation)
    set_physics_dt = forward("setup", SimulationSetup.set_physics_dt)
    get_physics_dt = forward("setup", SimulationSetup.get_physics_dt)
    get_physics_scenes = forward("setup", SimulationSetup.get_physics_scenes)
    set_device = forward("setup", SimulationSetup.set_device)
    get_device = forward("setup", SimulationSetup.get_device)
    get_default_engine = forward("setup", SimulationSetup.get_default_engine)
    get_active_physics_engine = forward("setup", SimulationSetup.get_active_physics_engine)
    get_available_physics_engines = forward("setup", SimulationSetup.get_available_physics_engines)
    switch_physics_engine = forward("setup", SimulationSetup.switch_physics_engine)
    enable_fabric = forward("setup", SimulationSetup.enable_fabric)
    is_fabric_enabled = forward("setup", SimulationSetup.is_fabric_enabled)
    enable_fabric_usd_notice_handler = forward("setup", SimulationSetup.enable_fabric_usd_notice_handler)
    is_fabric_usd_notice_handler_enabled = forward("setup", SimulationSetup.is_fabric_usd_notice_handler_enabled)
    assets_loading = forward("setup", SimulationSetup.assets_loading)

    # -- life --------------------------------------------------------------------------------------------------------

    @property
    def warm(self) -> bool:
        """Whether `initialize_physics` has been done since the last stop."""
        return self.events.warm

    def is_paused(self) -> bool:
        """Whether the timeline is paused."""
        return self._timeline.is_paused()

    def build(self) -> None:
        """Builds the world and binds sensors to it; playing calls it."""
        from graph.sim.live.animation import animate
        from graph.sim.scene.diagnostics import quiet
        from graph.sim.scene.stage import scene_name

        self._take_authored_rate()
        with quiet(self._world.warn, scene_name(self._world.stage)):
            self._world.build()
            self._set_up_scheduler()
            self._scheduler.capture_state = self._world.fabric.capture
            self._scheduler.begin_play()
            self._animation = animate(self._world, self._timeline, self.steps, self._phases)
            self.setup.begin()

    def free(self) -> None:
        """Frees what `build` has built and restores the stage; stopping calls it."""
        if self._animation is not None:
            self._animation.close()
            self._animation = None
        self._world.release()
        self.steps.end()
        if self._defaults["on_stop"]:
            self.events.warm = False
        self._scheduler.capture_state = None
        self._scheduler.end_play()
        self._bus.restart()
        self._world.restore()
        self.setup.keep_scene_changes()
        self._rendering.keep_time_codes()

    def _take_authored_rate(self) -> None:
        """Takes a rate that was authored on the active physics scene since the last reading."""
        authored, before = self._world.authored_rate, self._authored_rate
        self._authored_rate = authored
        if not self._follows_stage_rate or authored is None or authored == before:
            return
        if not authored:
            self.setup.refuse_rate_zero()
        elif float(authored) != float(self.clock.rate):  # not written by `set_dt`, whose exact rate is used
            self.steps.set_rate(max(Fraction(1), Fraction(int(authored))) if self.truncates else authored)

    def take_stage(self, default_rate: Fraction) -> None:
        """Takes the rate [Hz] of another stage, which has taken the place of the former one; else `default_rate`."""
        self.events.take_stage()
        self._authored_rate = self._world.authored_rate
        self.setup.scene_path = ""
        if self._follows_stage_rate:
            self.steps.set_rate(self._authored_rate or default_rate)

    def follow(self, change: Change) -> None:
        """Applies a change of the timeline's state to the world: builds or frees it, calls subscribers."""
        if change == "stop":
            self.free()
        elif change == "play" and not self.built:
            self.build()
        try:
            self._phases[change]()
            self._announce(change)
        except BaseException:
            if change == "play":
                self.free()
            raise

    def restart_time(self) -> None:
        """Sets time, count and carry to 0 and drops the samples; the monotonic clock continues."""
        self.steps.restart_time()

    def initialize_physics(self) -> None:
        """Builds the world if needed, runs the warm-up steps, sends SIMULATION_SETUP; does nothing when warm.

        Playing calls it. If it is called while stopped, the world exists until `invalidate_physics` or stop.
        """
        if self.events.warm:
            return
        if not self.built:
            self.build()
        self.steps.warm_up()
        self.events.warm = True
        events: list[SimulationEvent | IsaacEvents] = [SimulationEvent.SIMULATION_SETUP, *list(IsaacEvents)[:3]]
        for event in events:
            self.events.dispatch(event)

    def step(
        self,
        *,
        steps: int = 1,
        callback: Callable[[int, int], object] | None = None,
        update_fabric: bool = False,
    ) -> None:
        """As `Simulation.step`; a play that waits for the next update is applied first."""
        if not self.built:
            self._timeline.commit()
        self.steps.step(steps=steps, callback=callback, update_fabric=update_fabric)

    def invalidate_physics(self) -> None:
        """Ends the warm state: the next play warms up again. If the timeline is not playing the world is freed."""
        self.events.warm = False
        if self.built and self._timeline.is_stopped():
            self.free()

    def _announce(self, change: Change) -> None:
        """Sends the events of a change of the timeline's state; a play also warms up, unless that is switched off."""
        if self._timeline.silent:
            return
        if change in _CHANGES:
            self.events.dispatch(_CHANGES[change])
        elif self._defaults["warm_start"] and self._settings.get(keys.PLAY_SIMULATIONS):
            if self.events.warm:
                self.events.dispatch(SimulationEvent.SIMULATION_RESUMED)
            else:
                self.initialize_physics()
                self.events.dispatch(SimulationEvent.SIMULATION_STARTED)

    def close(self) -> None:
        """Closes the stage: removes the callbacks."""
        self.events.close()

    @property
    def _simulation_manager_interface(self) -> ManagedSimulation:
        """The raw interface: its calls (`get_simulation_time_at_time`, ...) are among those of this object."""
        return self

    def get_physics_simulation_view(self) -> Any:
        """Positions, velocities and contacts of all bodies as arrays; None unless warm (before play, after stop)."""
        return self.tensors if self.built and self.events.warm else None

    def register_callback(self, callback: Registered, event: str, *, order: int = 0, **options: Any) -> int:
        """Calls `callback` at each `SimulationEvent`; returns its id.

        PHYSICS_PRE_STEP and PHYSICS_POST_STEP call it with (dt [s], `StepContext`) around each substep, not during
        warm-up; PRIM_DELETED with (path); all others with (event). Lower order first, ties in the order of
        registration; post-step callbacks below order 0 see the clocks before the step. The older `IsaacEvents`, each
        with a warning, come between SIMULATION_SETUP and SIMULATION_STARTED. A bound method is held weakly: it ends
        with its object. `name=` is ignored with a warning. Raises ValueError for an unknown event, or if the arguments
        are swapped.
        """
        if "name" in options:
            options.pop("name")
            message = "register_callback takes no name any more; leave it out"
            self._world.warn("callback-name-ignored", "simulation", message)
        if options:
            raise TypeError(f"register_callback takes order=, not {', '.join(f'{name}=' for name in options)}")
        return self.events.register(callback, event, order)

    def deregister_callback(self, uid: int) -> bool:
        """Removes a callback; False, and a warning, for an unknown id."""
        found = self.events.remove(uid)
        if not found:
            self._world.warn("unknown-callback", "simulation", f"there is no callback with id {uid}")
        return found

    def deregister_all_callbacks(self) -> None:
        """Removes all callbacks except those of PRIM_DELETED (as Isaac Sim does), which are removed by id."""
        self.events.remove_all()

    def enable_default_callbacks(
        self,
        *,
        enable_warm_start: bool | None = None,
        enable_on_stop: bool | None = None,
        enable_stage_open: bool | None = None,
        enable_stage_close: bool | None = None,
    ) -> None:
        """Switches automatic actions: warm-up on play, its end on stop, removal of callbacks when the stage closes.

        As in Isaac Sim, every action that is not named is switched off, except warm_start, which stays; the warning
        `default-callbacks-off` names what was switched off. stage_open is only stored: an App opens its one stage when
        it is made.
        """
        if enable_warm_start is not None:
            self._defaults["warm_start"] = bool(enable_warm_start)
        others = {"on_stop": enable_on_stop, "stage_open": enable_stage_open, "stage_close": enable_stage_close}
        lost = [name for name, value in others.items() if value is None and self._defaults[name]]
        self._defaults.update({name: bool(value) for name, value in others.items()})
        if lost:
            message = f"{', '.join(lost)} not named, so off from now on (as in Isaac Sim); name all that shall stay on"
            self._world.warn("default-callbacks-off", "simulation", message)

    def enable_all_default_callbacks(self, enable: bool = True) -> None:
        """Switches all automatic actions."""
        self._defaults = dict.fromkeys(self._defaults, bool(enable))

    def is_default_callback_enabled(self, callback_name: str) -> bool:
        """Whether an automatic action is on; False for an unknown name."""
        return self._defaults.get(callback_name, False)

    def get_default_callback_status(self) -> dict[str, bool]:
        """All automatic actions by name."""
        return dict(self._defaults)

    def enable_usd_notice_handler(self, enable: bool) -> None:
        """Whether deleted prims are noticed (PRIM_DELETED)."""
        self.events.watch_stage(enable)

    def _set_up_scheduler(self) -> None:
        settings, scheduler = self._settings, self._scheduler
        scheduler.multi_tick = settings.get(keys.MULTI_TICK)
        scheduler.capture_at_ticks = self._world.fidelity.tlas == "sensor" and settings.get(keys.SENSOR_TICK_TLAS)
        scheduler.autotrigger_idle = settings.get(keys.AUTOTRIGGER_IDLE)
        scheduler.frames_later = frames_come_later(settings)
