"""The memory of nodes that wait for events, and how it is filled and let go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graph.events import EventBus, Inbox


@dataclass(slots=True)
class Listening:
    """What a waiting node keeps: its inbox once it has computed."""

    bus: EventBus | None = None
    inbox: Inbox | None = None


def inbox_of(db: Any, name: str) -> Inbox:
    """The node's inbox for events of that name, opened when it is first asked for."""
    memory: Listening = db.memory
    if memory.inbox is None or memory.inbox.name != name:
        close_inbox(db)
        memory.bus = db.context.events
        memory.inbox = memory.bus.open(name, db.context.update)
    return memory.inbox


def close_inbox(db: Any) -> None:
    """Ends the node's waiting."""
    memory: Listening = db.memory
    if memory.bus is not None and memory.inbox is not None:
        memory.bus.close(memory.inbox)
    memory.bus = memory.inbox = None


def ignored(db: Any) -> bool:
    """Whether events do not count now: `onlyPlayback` is set and the timeline does not play."""
    return bool(db.inputs.onlyPlayback and not db.context.is_playing)
