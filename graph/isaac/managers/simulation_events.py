"""The events of a simulation and the callbacks that users register for them."""

from __future__ import annotations

import weakref
from enum import StrEnum
from fractions import Fraction
from itertools import count
from typing import TYPE_CHECKING, Any

from graph.base import exact
from graph.base.records import dataclass

from .callbacks import CallbackList, Event, Held, Registered, dropped_early

if TYPE_CHECKING:
    from graph.sim.live.deletions import Deletions
    from graph.sim.phases import Subscribers, Unsubscribe

    from .simulation_setup import SimulationSetup

FIRST_ID = 2
"""Ids 0 and 1 belong to the manager's own callbacks in Isaac Sim."""


class SimulationEvent(StrEnum):
    """What callbacks can be registered for."""

    PHYSICS_PRE_STEP = "isaacsim.simulation.physics_pre_step"
    PHYSICS_POST_STEP = "isaacsim.simulation.physics_post_step"
    SIMULATION_SETUP = "isaacsim.simulation.simulation_setup"
    SIMULATION_STARTED = "isaacsim.simulation.started"
    SIMULATION_PAUSED = "isaacsim.simulation.paused"
    SIMULATION_RESUMED = "isaacsim.simulation.resumed"
    SIMULATION_STOPPED = "isaacsim.simulation.stopped"
    PRIM_DELETED = "isaacsim.simulation.prim_deleted"


class IsaacEvents(StrEnum):
    """Older names: of the end of the warm-up, in their order right after SIMULATION_SETUP, and of present events.

    Nothing raises POST_RESET: it belongs to resets of the former core API.
    """

    PHYSICS_WARMUP = "isaac.physics_warmup"
    SIMULATION_VIEW_CREATED = "isaac.simulation_view_created"
    PHYSICS_READY = "isaac.physics_ready"
    POST_RESET = "isaac.post_reset"
    PRE_PHYSICS_STEP = "isaac.pre_physics_step"
    POST_PHYSICS_STEP = "isaac.post_physics_step"
    TIMELINE_STOP = "isaac.timeline_stop"
    PRIM_DELETION = "isaac.prim_deletion"


_INSTEAD = {
    IsaacEvents.PHYSICS_WARMUP: SimulationEvent.SIMULATION_SETUP,
    IsaacEvents.SIMULATION_VIEW_CREATED: SimulationEvent.SIMULATION_SETUP,
    IsaacEvents.PHYSICS_READY: SimulationEvent.SIMULATION_STARTED,
    IsaacEvents.POST_RESET: SimulationEvent.SIMULATION_STARTED,
    IsaacEvents.PRE_PHYSICS_STEP: SimulationEvent.PHYSICS_PRE_STEP,
    IsaacEvents.POST_PHYSICS_STEP: SimulationEvent.PHYSICS_POST_STEP,
    IsaacEvents.TIMELINE_STOP: SimulationEvent.SIMULATION_STOPPED,
    IsaacEvents.PRIM_DELETION: SimulationEvent.PRIM_DELETED,
}
_RENAMED = tuple(_INSTEAD)[4:]
"""The events that are a present one under another name."""
_EVENTS: dict[str, SimulationEvent | IsaacEvents] = {each.value: each for each in (*SimulationEvent, *IsaacEvents)}
_STEPS = {SimulationEvent.PHYSICS_PRE_STEP, SimulationEvent.PHYSICS_POST_STEP}


@dataclass(frozen=True, slots=True)
class StepContext:
    """What a physics-step callback gets besides dt: the scene stepped, steps counted so far and the exact time [s].

    A post-step callback of order 0 or more reads the new count and time, all others the old ones.
    """

    scene_path: str
    step: int
    time: Fraction


class SimulationEvents:
    """The callbacks of one App's simulation."""

    def __init__(self, simulation: SimulationSetup) -> None:
        self._simulation = weakref.proxy(simulation)  # which holds these
        self._ids = count(FIRST_ID)
        self._lists = {event: CallbackList() for event in _EVENTS.values() if event not in _STEPS}
        self._steps: dict[int, Unsubscribe] = {}
        self._deletions: Deletions | None = None
        self._watching = True

    def register(self, callback: Registered, event: str, order: int) -> int:
        """Adds a callback; returns its id. Raises ValueError for an unknown event, or if the arguments are swapped."""
        if isinstance(callback, str) or callable(event):
            raise ValueError(
                "the SimulationManager takes register_callback(callback, event): the callback first "
                "(the RenderingManager takes event, callback=function)"
            )
        if not callable(callback):
            raise ValueError(f"callback {callback!r} cannot be called; give a function")
        known = _EVENTS.get(str(getattr(event, "value", event)))
        if known is None:
            events = ", ".join(each.name for each in _EVENTS.values())
            raise ValueError(f"there is no simulation event {event!r}; there are {events}")
        order = exact.count(order, "order")
        if isinstance(known, IsaacEvents):
            never = "; nothing raises it here" if known is IsaacEvents.POST_RESET else ""
            instead = f"this event is deprecated{never}; use SimulationEvent.{_INSTEAD[known].name}"
            self._simulation.warn("event-deprecated", known.name, instead)
            known = _INSTEAD[known] if known in _RENAMED else known
        uid = next(self._ids)

        def died(called: bool) -> None:
            if self.remove(uid) and not called:
                self._simulation.warn("callback-dropped", f"simulation callback {uid}", dropped_early(uid))

        held = Held(callback, died)
        if known in _STEPS:
            self._steps[uid] = self._subscribe_steps(known, held, order)
        else:
            self._lists[known].add(uid, held, order)
        if known is SimulationEvent.PRIM_DELETED:
            self._watch()
        return uid

    def remove(self, uid: int) -> bool:
        """Removes a callback; False for an unknown id."""
        unsubscribe = self._steps.pop(uid, None)
        if unsubscribe is not None:
            unsubscribe()
            return True
        if any(callbacks.remove(uid) for callbacks in self._lists.values()):
            self._watch()
            return True
        return False

    def remove_all(self) -> None:
        """Removes all callbacks except those of PRIM_DELETED, as Isaac Sim does."""
        for unsubscribe in self._steps.values():
            unsubscribe()
        self._steps.clear()
        for event, callbacks in self._lists.items():
            if event is not SimulationEvent.PRIM_DELETED:
                callbacks.clear()

    def close(self) -> None:
        """Closes the stage: removes every callback; ids start again."""
        self.remove_all()
        self._lists[SimulationEvent.PRIM_DELETED].clear()
        self._watch()
        self._ids = count(FIRST_ID)

    def take_stage(self) -> None:
        """Watches another stage for deleted prims."""
        watching = self._watching
        self.watch_stage(False)
        self.watch_stage(watching)

    def dispatch(self, event: SimulationEvent | IsaacEvents) -> None:
        """Calls the callbacks of an event without payload."""
        callbacks = self._lists[event]
        if callbacks:
            callbacks(Event(event))

    def watch_stage(self, watching: bool) -> None:
        """Sets whether deleted prims are noticed."""
        self._watching = watching
        self._watch()

    def _subscribe_steps(self, event: SimulationEvent | IsaacEvents, held: Held, order: int) -> Unsubscribe:
        simulation = self._simulation
        clock = simulation.clock
        pre_step = event is SimulationEvent.PHYSICS_PRE_STEP

        def run() -> None:
            if simulation.warm:
                callback = held()
                if callback is not None:
                    callback(float(1 / clock.rate), StepContext(simulation.scene_path, clock.count, clock.time))

        subscribers: Subscribers = simulation.pre_step if pre_step else simulation.post_step
        return subscribers.add(run, order)

    def _watch(self) -> None:
        """Listens to the stage exactly while a callback for deleted prims is registered."""
        callbacks: Any = self._lists[SimulationEvent.PRIM_DELETED]
        if bool(callbacks) == (self._deletions is not None) and self._watching:
            return
        if self._deletions is not None:
            self._deletions.close()
            self._deletions = None
        if callbacks and self._watching:
            from graph.sim.live.deletions import Deletions

            self._deletions = Deletions(self._simulation.stage, callbacks)
