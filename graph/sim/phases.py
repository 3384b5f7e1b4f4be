"""Subscriber lists of the phases of an update and of the App's events."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

from graph.base import exact
from graph.base.callables import check_callable
from graph.base.errors import UserError

Callback = Callable[[], object]
Unsubscribe = Callable[[], None]

PHASES = ("timeline_state", "timeline", "physics", "simulation_graphs", "render", "post_render_graphs", "end")
"""The phases of one update, in the order they run."""

EVENTS = (
    "physics_pre_step",
    "physics_post_step",
    "play",
    "pause",
    "resume",
    "stopping",
    "stop",
    "sensors_edited",
    "stage_closing",
    "stage_opened",
    "closing",
    "close",
)
"""`sensors_edited`: sensor prims were written, removed or put back while playing; it comes in the next update.
`stopping`: a stop is about to set every count to 0.
`stage_closing`, `stage_opened`: another stage takes the place of the present one (`App.take_stage`)."""


class Subscribers:
    """Callbacks in the order they run: by `order`, then by registration.

    The phase's own work is at order 0: `before` runs ahead of it, `after` behind it. Both are tuples, so that a
    callback may subscribe or unsubscribe while they run; that takes effect the next time.
    """

    __slots__ = ("_entries", "_serial", "after", "before")

    def __init__(self) -> None:
        self._entries: list[tuple[int, int, Callback]] = []
        self._serial = count()
        self.before: tuple[Callback, ...] = ()
        self.after: tuple[Callback, ...] = ()

    def add(self, callback: Callback, order: int = 0) -> Unsubscribe:
        """Subscribes `callback`; returns a function that ends it (calling that twice is harmless)."""
        number = next(self._serial)
        self._entries.append((order, number, callback))
        self._freeze()

        def unsubscribe() -> None:  # holds the number, not the callback, whose owner often keeps this function
            left = [entry for entry in self._entries if entry[1] != number]
            if len(left) < len(self._entries):
                self._entries = left
                self._freeze()

        return unsubscribe

    def __call__(self) -> None:
        """Runs every callback."""
        for callback in self.before:
            callback()
        for callback in self.after:
            callback()

    def __bool__(self) -> bool:
        return bool(self._entries)

    def clear(self) -> None:
        """Ends all subscriptions."""
        self._entries.clear()
        self._freeze()

    def _freeze(self) -> None:
        entries = sorted(self._entries, key=lambda entry: entry[:2])
        self.before = tuple(callback for order, _, callback in entries if order < 0)
        self.after = tuple(callback for order, _, callback in entries if order >= 0)


class Phases:
    """The subscribers of each phase of an update and of each event of one App."""

    names = PHASES
    """The phases of one update, in the order they run."""

    def __init__(self) -> None:
        self.running = False
        """Whether an update runs."""
        self._subscribers = {name: Subscribers() for name in (*PHASES, *EVENTS)}

    def __getitem__(self, name: str) -> Subscribers:
        return self._subscribers[name]

    def on(self, phase: str, callback: Callback, order: int = 0) -> Unsubscribe:
        """Calls `callback()` in a phase of every update or at an event; returns a function that ends it.

        Lower order first, ties in the order of registration; the phase's own work is at order 0, ahead of the
        subscribers of order 0. `post_render_graphs` runs only in updates that delivered a frame. Raises UserError for
        an unknown phase, TypeError for an order that is not a whole number.
        """
        check_callable(callback, "app.on(phase, callback)")
        order = exact.count(order, "order")
        if phase not in self._subscribers:
            raise UserError(f"there is no phase or event {phase!r}; there are {', '.join(self._subscribers)}")
        return self._subscribers[phase].add(callback, order)

    def clear(self) -> None:
        """Ends all subscriptions."""
        for subscribers in self._subscribers.values():
            subscribers.clear()
