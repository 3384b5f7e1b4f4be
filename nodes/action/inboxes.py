"""The memory of nodes that wait for events: how it is filled and released."""

from __future__ import annotations

from collections import deque

from graph.base.records import dataclass, field
from graph.node import Database
from graph.node.events import LONGEST_QUEUE, Event, EventBus, Inbox


@dataclass(slots=True)
class Listening:
    """A waiting node's memory: its inbox, after its first compute."""

    bus: EventBus | None = None
    inbox: Inbox | None = None
    turn: deque[Event] = field(default_factory=deque)
    """Events that this evaluation delivers, one after another."""


def inbox_of(db: Database, name: str) -> Inbox:
    """The node's inbox for events of that name, opened at first use."""
    memory: Listening = db.memory
    if memory.inbox is None or memory.inbox.name != name:
        close_inbox(db)
        memory.bus = db.context.events
        memory.inbox = memory.bus.open(name, db.context.update)
    return memory.inbox


def next_event(db: Database, name: str) -> Event | None:
    """The event that this compute delivers, or None.

    The first compute of an evaluation takes all deliverable events; the node comes back for each with
    `fire_and_return`, so that every event has its own compute and walk.
    """
    memory: Listening = db.memory
    if not db.returned:
        inbox = inbox_of(db, name)
        memory.turn = deque(inbox.take_all(db.context.update))
        if lost := inbox.take_lost():
            event = name.partition(":")[2]
            db.warn(
                "events-lost",
                f'{lost} events "{event}" were lost: more than {LONGEST_QUEUE} waited; send fewer in one update',
            )
        if ignored(db):
            memory.turn.clear()
    return memory.turn.popleft() if memory.turn else None


def deliver(db: Database) -> None:
    """Fires execOut; comes back if another event waits."""
    if db.memory.turn:
        db.fire_and_return("execOut")
    else:
        db.fire("execOut")


def close_inbox(db: Database) -> None:
    """Closes the node's inbox."""
    memory: Listening = db.memory
    if memory.bus is not None and memory.inbox is not None:
        memory.bus.close(memory.inbox)
    memory.bus = memory.inbox = None


def ignored(db: Database) -> bool:
    """Whether events are ignored now: `onlyPlayback` is set and the timeline does not play."""
    return bool(db.inputs.onlyPlayback and not db.context.is_playing)
