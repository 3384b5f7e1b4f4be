"""Events between the nodes of one world: custom events, message-bus events, events of the stage.

An event that a node sends is delivered from the next update on, one after another in the order of sending. An event
from outside (a script, the App) can be received in the same update.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from graph.base.records import dataclass, field

LONGEST_QUEUE = 10_000
"""Most events that wait for one receiver. Beyond it the oldest are dropped; the receiver can ask how many."""


@dataclass(frozen=True, slots=True)
class Event:
    """An event: its name and payload, the update in which it was sent, and whether a node sent it."""

    name: str
    payload: Mapping[str, Any]
    update: int
    by_node: bool

    def deliverable(self, update: int) -> bool:
        """Whether a receiver may take it in this update."""
        return not self.by_node or self.update < update


@dataclass(eq=False, slots=True)
class Inbox:
    """The events of one name that wait for one receiver."""

    name: str
    waiting: deque[Event] = field(default_factory=deque)
    lost: int = 0
    """How many were dropped since `take_lost` was last called."""

    def put(self, event: Event) -> None:
        """Adds an event; drops the oldest if too many wait."""
        if len(self.waiting) == LONGEST_QUEUE:
            self.waiting.popleft()
            self.lost += 1
        self.waiting.append(event)

    def take_lost(self) -> int:
        """How many events were dropped since the last call."""
        lost, self.lost = self.lost, 0
        return lost

    def take(self, update: int) -> Event | None:
        """The oldest event that is deliverable in this update, or None."""
        if self.waiting and self.waiting[0].deliverable(update):
            return self.waiting.popleft()
        return None

    def take_all(self, update: int) -> list[Event]:
        """All events that are deliverable in this update, oldest first."""
        taken = []
        while (event := self.take(update)) is not None:
            taken.append(event)
        return taken


class EventBus:
    """Carries events from senders to the inboxes of their names."""

    def __init__(self) -> None:
        self._inboxes: dict[str, list[Inbox]] = {}
        self._recent: dict[str, Inbox] = {}
        self._newest = 0

    def send(
        self, name: str, payload: Mapping[str, Any] | None = None, *, update: int = 0, by_node: bool = False
    ) -> None:
        """Sends an event; `update`: the index of the present update."""
        event = Event(name, dict(payload or {}), update, by_node)
        self._keep(event)
        for inbox in self._inboxes.get(name, ()):
            inbox.put(event)

    def open(self, name: str, update: int) -> Inbox:
        """A new inbox.

        It already holds the events of this and of the last update, so the order of creation does not matter.
        """
        inbox = Inbox(name)
        if name in self._recent:
            kept = self._recent[name]
            inbox.waiting.extend(event for event in kept.waiting if event.update >= update - 1)
            inbox.lost = kept.lost if inbox.waiting else 0
        self._inboxes.setdefault(name, []).append(inbox)
        return inbox

    def close(self, inbox: Inbox) -> None:
        """Stops delivering to an inbox."""
        inboxes = self._inboxes.get(inbox.name, [])
        if inbox in inboxes:
            inboxes.remove(inbox)
        if not inboxes:
            self._inboxes.pop(inbox.name, None)

    def clear(self) -> None:
        """Drops all undelivered events, as a stop does."""
        self._recent.clear()
        for inboxes in self._inboxes.values():
            for inbox in inboxes:
                inbox.waiting.clear()
                inbox.lost = 0

    def _keep(self, event: Event) -> None:
        """Keeps the events of this and of the last update for inboxes that are opened later."""
        if event.update != self._newest:
            self._newest = event.update
            for kept in [*self._recent.values()]:
                while kept.waiting and kept.waiting[0].update < event.update - 1:
                    kept.waiting.popleft()
                    kept.lost = 0
                if not kept.waiting:
                    del self._recent[kept.name]
        self._recent.setdefault(event.name, Inbox(event.name)).put(event)
