"""`carb.events` and `carb.eventdispatcher`."""

from __future__ import annotations

import zlib

from graph.isaac.events import Dispatcher as IEventDispatcher
from graph.isaac.events import Event
from graph.isaac.events import Event as IEvent
from graph.isaac.events import EventStream as IEventStream
from graph.isaac.events import Subscription as ISubscription
from graph.isaac.events import Subscription as ObserverGuard
from graph.isaac.session import kit

__all__ = [
    "Event",
    "IEvent",
    "IEventDispatcher",
    "IEventStream",
    "ISubscription",
    "ObserverGuard",
    "get_eventdispatcher",
    "type_from_string",
]


def get_eventdispatcher() -> IEventDispatcher:
    return kit().dispatcher


def type_from_string(name: str) -> int:
    return zlib.crc32(name.encode())
