"""`app.simulation` in Isaac Sim's names: its SimulationManager over the simulation of one App."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from graph.sim.simulation import Milestone

from .callbacks import Registered
from .rendering import Rendering
from .simulation_events import IsaacEvents, SimulationEvent, SimulationEvents
from .simulation_setup import SimulationSetup

_EVENTS: dict[Milestone, tuple[SimulationEvent | IsaacEvents, ...]] = {
    "warm": (SimulationEvent.SIMULATION_SETUP, *list(IsaacEvents)[:3]),
    "started": (SimulationEvent.SIMULATION_STARTED,),
    "paused": (SimulationEvent.SIMULATION_PAUSED,),
    "resumed": (SimulationEvent.SIMULATION_RESUMED,),
    "stopped": (SimulationEvent.SIMULATION_STOPPED,),
}
_DEFAULTS = ("warm_start", "on_stop", "stage_open", "stage_close", "post_warm_start")


class ManagedSimulation(SimulationSetup):
    """The simulation with the SimulationManager's callbacks; those of physics steps come only while it is warm."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.events = SimulationEvents(self)
        self._defaults = dict.fromkeys(_DEFAULTS, True)

    def _reached(self, milestone: Milestone) -> None:
        super()._reached(milestone)
        if milestone == "restored" and isinstance(self._scheduler, Rendering):
            self._scheduler.keep_time_codes()
        for event in _EVENTS.get(milestone, ()):
            self.events.dispatch(event)

    def take_stage(self, default_rate: Fraction) -> None:
        """As `Simulation.take_stage`; deleted prims are noticed on the new stage."""
        self.events.take_stage()
        self.scene_path = ""
        super().take_stage(default_rate)

    def close(self) -> None:
        """Closes the stage: removes the callbacks."""
        self.events.close()

    @property
    def _simulation_manager_interface(self) -> ManagedSimulation:
        """The raw interface: its calls (`get_simulation_time_at_time`, ...) are among those of this object."""
        return self

    def get_physics_simulation_view(self) -> Any:
        """Positions, velocities and contacts of all bodies as arrays; None unless warm (before play, after stop)."""
        return self.tensors if self.built and self.warm else None

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
            self.warn("callback-name-ignored", "simulation", message)
        if options:
            raise TypeError(f"register_callback takes order=, not {', '.join(f'{name}=' for name in options)}")
        return self.events.register(callback, event, order)

    def deregister_callback(self, uid: int) -> bool:
        """Removes a callback; False, and a warning, for an unknown id."""
        found = self.events.remove(uid)
        if not found:
            self.warn("unknown-callback", "simulation", f"there is no callback with id {uid}")
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
        others = {"on_stop": enable_on_stop, "stage_open": enable_stage_open, "stage_close": enable_stage_close}
        lost = [name for name, value in others.items() if value is None and self._defaults[name]]
        if enable_warm_start is not None:
            self._defaults["warm_start"] = bool(enable_warm_start)
        self._defaults.update({name: bool(value) for name, value in others.items()})
        self._use_defaults()
        if lost:
            message = f"{', '.join(lost)} not named, so off from now on (as in Isaac Sim); name all that shall stay on"
            self.warn("default-callbacks-off", "simulation", message)

    def enable_all_default_callbacks(self, enable: bool = True) -> None:
        """Switches all automatic actions."""
        self._defaults = dict.fromkeys(self._defaults, bool(enable))
        self._use_defaults()

    def enable_warm_start_callback(self, enable: bool = True) -> None:
        """Switches the warm-up on play."""
        self._switch("warm_start", enable)

    def enable_on_stop_callback(self, enable: bool = True) -> None:
        """Switches the end of the warm-up on stop."""
        self._switch("on_stop", enable)

    def enable_post_warm_start_callback(self, enable: bool = True) -> None:
        """Stored only: nothing follows a warm-up here."""
        self._switch("post_warm_start", enable)

    def enable_stage_open_callback(self, enable: bool = True) -> None:
        """Stored only: an App opens its one stage when it is made."""
        self._switch("stage_open", enable)

    def _switch(self, name: str, enable: bool) -> None:
        self._defaults[name] = bool(enable)
        self._use_defaults()

    def is_default_callback_enabled(self, callback_name: str) -> bool:
        """Whether an automatic action is on; False for an unknown name."""
        return self._defaults.get(callback_name, False)

    def get_default_callback_status(self) -> dict[str, bool]:
        """All automatic actions by name."""
        return dict(self._defaults)

    def _use_defaults(self) -> None:
        self.warms_up, self.cools = self._defaults["warm_start"], self._defaults["on_stop"]

    def enable_usd_notice_handler(self, enable: bool) -> None:
        """Whether deleted prims are noticed (PRIM_DELETED)."""
        self.events.watch_stage(enable)
