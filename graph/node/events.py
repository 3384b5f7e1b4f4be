"""Events between the nodes of one world: custom events, message-bus events, events of the stage.

What a node sends is delivered after the update in which it was sent: receivers take it from the next update on, one
after another, in the order of sending. What comes from outside (a script, the App) can be taken at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

LONGEST_QUEUE = 10_000
"""How many events wait for one receiver; the oldest are lost beyond that, and the receiver is told how many."""


@dataclass(frozen=True, slots=True)
class Event:
    """An event: its name and payload, the update it was sent in, and whether a node sent it."""

    name: str
    payload: Mapping[str, Any]
    update: int
    by_node: bool

    def deliverable(self, update: int) -> bool:
        """Whether a receiver may have it in this update."""
        return not self.by_node or self.update < update


@dataclass(eq=False, slots=True)
class Inbox:
    """The events of one name that wait for one receiver."""

    name: str
    waiting: deque[Event] = field(default_factory=deque)
    lost: int = 0
    """How many were dropped because too many waited, since the receiver last looked."""

    def put(self, event: Event) -> None:
        """Adds an event; the oldest is lost if too many wait."""
        if len(self.waiting) == LONGEST_QUEUE:
            self.waiting.popleft()
            self.lost += 1
        self.waiting.append(event)

    def take_lost(self) -> int:
        """How many events were lost since this was last asked."""
        lost, self.lost = self.lost, 0
        return lost

    def take(self, update: int) -> Event | None:
        """The oldest event that may be had in this update; None if there is none."""
        if self.waiting and self.waiting[0].deliverable(update):
            return self.waiting.popleft()
        return None

    def take_all(self, update: int) -> list[Event]:
        """All events that may be had in this update, oldest first."""
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
        """Sends an event in the update of that index."""
        event = Event(name, dict(payload or {}), update, by_node)
        self._keep(event)
        for inbox in self._inboxes.get(name, ()):
            inbox.put(event)

    def open(self, name: str, update: int) -> Inbox:
        """A new inbox; events of this and of the last update are in it, so that nobody needs to come first."""
        inbox = Inbox(name)
        if name in self._recent:
            kept = self._recent[name]
            inbox.waiting.extend(event for event in kept.waiting if event.update >= update - 1)
            inbox.lost = kept.lost if inbox.waiting else 0
        self._inboxes.setdefault(name, []).append(inbox)
        return inbox

    def close(self, inbox: Inbox) -> None:
        """Delivers nothing to it any more."""
        inboxes = self._inboxes.get(inbox.name, [])
        if inbox in inboxes:
            inboxes.remove(inbox)
        if not inboxes:
            self._inboxes.pop(inbox.name, None)

    def clear(self) -> None:
        """Forgets what is on its way, as a stop does."""
        self._recent.clear()
        for inboxes in self._inboxes.values():
            for inbox in inboxes:
                inbox.waiting.clear()
                inbox.lost = 0

    def _keep(self, event: Event) -> None:
        """Holds the events of this and of the last update for receivers that come late."""
        if event.update != self._newest:
            self._newest = event.update
            for kept in [*self._recent.values()]:
                while kept.waiting and kept.waiting[0].update < event.update - 1:
                    kept.waiting.popleft()
                    kept.lost = 0
                if not kept.waiting:
                    del self._recent[kept.name]
        self._recent.setdefault(event.name, Inbox(event.name)).put(event)
