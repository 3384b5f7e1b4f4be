"""Kit's event streams and its event dispatcher."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import count
from typing import Any
from weakref import ref


class Event:
    """One event: its type, its sender and its payload."""

    def __init__(
        self, type: int = 0, sender: int = 0, payload: Mapping[str, Any] | None = None, name: str = ""
    ) -> None:
        self.type, self.sender, self.payload, self.event_name = type, sender, dict(payload or {}), name
        self.consumed = False

    def consume(self) -> None:
        """Keeps it from the subscribers that follow."""
        self.consumed = True

    def get(self, key: str, default: Any = None) -> Any:
        """A value of the payload."""
        return self.payload.get(key, default)

    def __getitem__(self, key: str) -> Any:
        return self.payload[key]

    def __contains__(self, key: str) -> bool:
        return key in self.payload


class Subscription:
    """Holds a subscriber: the subscription ends with this object, or by `unsubscribe` or `reset`."""

    def __init__(self, fn: Callable[[Any], Any], name: str, type: int | None = None, filter: Any = None) -> None:
        self.fn: Callable[[Any], Any] | None = fn
        self.name, self.type, self.filter = name, type, filter

    def unsubscribe(self) -> None:
        """Ends it."""
        self.fn = None

    reset = unsubscribe

    def __enter__(self) -> Subscription:
        return self

    def __exit__(self, *_: object) -> None:
        self.unsubscribe()


class _Subscribers:
    """Subscriptions in the order of their numbers; they are held by their owners."""

    def __init__(self) -> None:
        self._entries: list[tuple[int, int, Any]] = []
        self._serial = count()

    def add(self, subscription: Subscription, order: int) -> Subscription:
        self._entries.append((order, next(self._serial), ref(subscription)))
        self._entries.sort(key=lambda entry: entry[:2])
        return subscription

    def live(self) -> list[Subscription]:
        found = [(entry, entry[2]()) for entry in self._entries]
        if any(one is None or one.fn is None for _, one in found):
            self._entries = [entry for entry, one in found if one is not None and one.fn is not None]
        return [one for _, one in found if one is not None and one.fn is not None]


class EventStream:
    """A stream: pushed events wait for `pump`, dispatched ones are delivered at once."""

    def __init__(self) -> None:
        self._pop, self._push = _Subscribers(), _Subscribers()
        self._waiting: list[Event] = []

    def create_subscription_to_pop(self, fn: Any, order: int = 0, name: str | None = None) -> Subscription:
        """Calls `fn(event)` for each event that is delivered."""
        return self._pop.add(Subscription(fn, name or ""), order)

    def create_subscription_to_pop_by_type(
        self, event_type: Any, fn: Any, order: int = 0, name: str | None = None
    ) -> Subscription:
        """Calls `fn(event)` for each event of a type that is delivered."""
        return self._pop.add(Subscription(fn, name or "", int(event_type)), order)

    def create_subscription_to_push(self, fn: Any, order: int = 0, name: str | None = None) -> Subscription:
        """Calls `fn(event)` when an event is pushed."""
        return self._push.add(Subscription(fn, name or ""), order)

    def create_subscription_to_push_by_type(
        self, event_type: Any, fn: Any, order: int = 0, name: str | None = None
    ) -> Subscription:
        """Calls `fn(event)` when an event of a type is pushed."""
        return self._push.add(Subscription(fn, name or "", int(event_type)), order)

    def push(self, event_type: int = 0, sender: int = 0, payload: Mapping[str, Any] | None = None) -> None:
        """Adds an event that waits for `pump`."""
        event = Event(int(event_type), sender, payload)
        _deliver(self._push, event)
        self._waiting.append(event)

    def dispatch(self, event_type: int = 0, sender: int = 0, payload: Mapping[str, Any] | None = None) -> None:
        """Delivers an event at once."""
        event = Event(int(event_type), sender, payload)
        _deliver(self._push, event)
        _deliver(self._pop, event)

    def pump(self) -> None:
        """Delivers the events that wait."""
        waiting, self._waiting = self._waiting, []
        for event in waiting:
            _deliver(self._pop, event)


def _deliver(subscribers: _Subscribers, event: Event) -> None:
    for one in subscribers.live():
        if (one.type is None or one.type == event.type) and one.fn is not None and not event.consumed:
            one.fn(event)


class Dispatcher:
    """Events by name."""

    def __init__(self) -> None:
        self._names: dict[str, _Subscribers] = {}

    def observe_event(
        self,
        order: int = 0,
        event_name: str = "",
        on_event: Any = None,
        filter: Mapping[str, Any] | None = None,
        *,
        observer_name: str = "",
    ) -> Subscription:
        """Calls `on_event(event)` for each event of a name whose payload has the values of `filter`."""
        held = Subscription(on_event, observer_name, filter=filter)
        return self._names.setdefault(str(event_name), _Subscribers()).add(held, order)

    def dispatch_event(self, event_name: str, payload: Mapping[str, Any] | None = None) -> int:
        """Delivers an event; returns the number of observers."""
        subscribers = self._names.get(str(event_name))
        if subscribers is None:
            return 0
        event = Event(0, 0, payload, str(event_name))
        called = 0
        for one in subscribers.live():
            if one.fn is not None and all(event.payload.get(key) == value for key, value in (one.filter or {}).items()):
                one.fn(event)
                called += 1
        return called

    def has_observers(self, event_name: str, payload: Any = None) -> bool:
        """Whether anyone observes events of a name."""
        subscribers = self._names.get(str(event_name))
        return subscribers is not None and bool(subscribers.live())
