"""`app.simulation`: the calls of Isaac Sim's SimulationManager over the steps of one App."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from graph.sim import settings as keys

from .callbacks import Registered
from .simulation_events import SimulationEvent, SimulationEvents
from .simulation_setup import SimulationSetup

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.timing.timeline import Change

_CHANGES: dict[Change, SimulationEvent] = {
    "pause": SimulationEvent.SIMULATION_PAUSED,
    "stop": SimulationEvent.SIMULATION_STOPPED,
}
_DEFAULTS = ("warm_start", "on_stop", "stage_open", "stage_close", "post_warm_start")


class ManagedSimulation(SimulationSetup):
    """Lifecycle and callbacks of one App's simulation.

    It is *warm* from the end of `initialize_physics`, which playing calls, to `invalidate_physics`, which stopping
    calls. Only a warm simulation tells physics-step callbacks of its steps.
    """

    def __init__(self, app: App, rate: Fraction) -> None:
        super().__init__(app, rate)
        self.events = SimulationEvents(app)
        self._defaults = dict.fromkeys(_DEFAULTS, True)

    @property
    def warm(self) -> bool:
        """Whether `initialize_physics` has been done since the last stop."""
        return self.events.warm

    def initialize_physics(self) -> None:
        """Builds the world if it is not there yet, runs the warm-up steps, sends SIMULATION_SETUP; nothing when warm.

        Playing does this by itself. Called while stopped, the world stands until `invalidate_physics` or stop.
        """
        if self.events.warm:
            return
        if not self.built:
            self._app.build_world()
        self.warm_up()
        self.events.warm = True
        self.events.dispatch(SimulationEvent.SIMULATION_SETUP)

    def invalidate_physics(self) -> None:
        """Ends being warm: the next play warms up again. Where the timeline stands still the world is freed."""
        self.events.warm = False
        if self.built and self._app.timeline.is_stopped():
            self._app.free_world()

    def announce(self, change: Change) -> None:
        """Tells of a change of the timeline's state; a play also warms up, unless that is switched off."""
        if self._app.timeline.silent:
            return
        if change in _CHANGES:
            self.events.dispatch(_CHANGES[change])
        elif self._defaults["warm_start"] and self._app.settings.get(keys.PLAY_SIMULATIONS):
            if self.events.warm:
                self.events.dispatch(SimulationEvent.SIMULATION_RESUMED)
            else:
                self.initialize_physics()
                self.events.dispatch(SimulationEvent.SIMULATION_STARTED)

    def end(self) -> None:
        """The world is freed; the simulation is warm no longer, unless the default callback on_stop is off."""
        super().end()
        if self._defaults["on_stop"]:
            self.events.warm = False

    def close(self) -> None:
        """The stage closes: callbacks end."""
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
        warm-up; PRIM_DELETED with (path); all others with (event). Lower order first, ties as registered; post-step
        callbacks below order 0 see the clocks before the step. A bound method is held weakly: it ends with its object.
        `name=` is ignored with a warning. Raises ValueError for what is no event, and where both changed places.
        """
        if "name" in options:
            options.pop("name")
            message = "register_callback takes no name any more; leave it out"
            self._app.warn("callback-name-ignored", "simulation", message)
        if options:
            raise TypeError(f"register_callback takes order=, not {', '.join(f'{name}=' for name in options)}")
        return self.events.register(callback, event, order)

    def deregister_callback(self, uid: int) -> bool:
        """Ends a callback; False, and a warning, for an id that there is not."""
        found = self.events.remove(uid)
        if not found:
            self._app.warn("unknown-callback", "simulation", f"there is no callback with id {uid}")
        return found

    def deregister_all_callbacks(self) -> None:
        """Ends all callbacks but those of PRIM_DELETED (as Isaac Sim does): those end by their ids."""
        self.events.remove_all()

    def enable_default_callbacks(
        self,
        *,
        enable_warm_start: bool | None = None,
        enable_on_stop: bool | None = None,
        enable_stage_open: bool | None = None,
        enable_stage_close: bool | None = None,
    ) -> None:
        """Switches what happens by itself: the warm-up on play, its end on stop, callbacks dropped as the stage closes.

        As in Isaac Sim what is not named is switched off, but for warm_start, which then stays; warning
        `default-callbacks-off` names what that took. stage_open is only kept: an App opens its one stage as it is made.
        """
        if enable_warm_start is not None:
            self._defaults["warm_start"] = bool(enable_warm_start)
        others = {"on_stop": enable_on_stop, "stage_open": enable_stage_open, "stage_close": enable_stage_close}
        lost = [name for name, value in others.items() if value is None and self._defaults[name]]
        self._defaults.update({name: bool(value) for name, value in others.items()})
        if lost:
            message = f"{', '.join(lost)} not named, so off from now on (as in Isaac Sim); name all that shall stay on"
            self._app.warn("default-callbacks-off", "simulation", message)

    def enable_all_default_callbacks(self, enable: bool = True) -> None:
        """Switches all of them."""
        self._defaults = dict.fromkeys(self._defaults, bool(enable))

    def is_default_callback_enabled(self, callback_name: str) -> bool:
        """Whether one is on; False for an unknown name."""
        return self._defaults.get(callback_name, False)

    def get_default_callback_status(self) -> dict[str, bool]:
        """All of them by name."""
        return dict(self._defaults)

    def enable_usd_notice_handler(self, enable: bool) -> None:
        """Whether deleted prims are noticed (PRIM_DELETED)."""
        self.events.watch_stage(enable)
