"""Users' callbacks, ordered by order and id, with bound methods held weakly; and the event that they get."""

from __future__ import annotations

import inspect
import weakref
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from graph.base.records import dataclass, field

Registered = Callable[..., object]
"""A user's callback; its arguments depend on the event."""


@dataclass(frozen=True)
class Event:
    """The argument of a callback: the event's name and payload, read as `event["key"]` or `event.get(...)`."""

    event_name: str
    payload: Mapping[str, Any] = field(default_factory=dict)

    def __getitem__(self, key: str) -> Any:
        return self.payload[key]

    def get(self, key: str, default: Any = None) -> Any:
        """The payload's value at `key`, else `default`."""
        return self.payload.get(key, default)


class Held:
    """A stored callback: bound methods weakly, so that they end with their object, all others strongly.

    `on_death(called)` is called when the object of a bound method was freed; `called`: whether the callback was ever
    used.
    """

    __slots__ = ("__weakref__", "_called", "_get")

    def __init__(self, callback: Registered, on_death: Callable[[bool], None]) -> None:
        self._called = False
        self._get: Callable[[], Registered | None]
        if inspect.ismethod(callback):
            weak = weakref.ref(self)

            def died(_: object) -> None:
                held = weak()
                if held is not None:
                    on_death(held._called)

            self._get = weakref.WeakMethod(callback, died)
        else:
            self._get = lambda: callback

    def __call__(self) -> Registered | None:
        """The callback, or None after its object was freed."""
        self._called = True
        return self._get()


class CallbackList:
    """The callbacks of one event: lower order first, ties in the order of registration."""

    __slots__ = ("_entries",)

    def __init__(self) -> None:
        self._entries: tuple[tuple[int, int, Held], ...] = ()

    def add(self, uid: int, callback: Held, order: int) -> None:
        """Adds a callback; `uid` grows from one registration to the next."""
        self._entries = tuple(sorted((*self._entries, (order, uid, callback)), key=lambda entry: entry[:2]))

    def remove(self, uid: int) -> bool:
        """Removes a callback; False if it is not registered here."""
        left = tuple(entry for entry in self._entries if entry[1] != uid)
        found = len(left) < len(self._entries)
        self._entries = left
        return found

    def clear(self) -> None:
        """Removes all of them."""
        self._entries = ()

    def __call__(self, *args: Any) -> None:
        """Calls the callbacks that are registered now; changes during the calls take effect the next time."""
        for _, _, held in self._entries:
            callback = held()
            if callback is not None:
                callback(*args)

    def __bool__(self) -> bool:
        return bool(self._entries)

    def __iter__(self) -> Iterator[int]:
        return iter([uid for _, uid, _ in self._entries])


def dropped_early(uid: int) -> str:
    """The warning about a bound method whose object was freed before the callback was ever called."""
    return f"callback {uid} was never called: bound methods are held weakly and its object is gone; keep a reference"
