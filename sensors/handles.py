"""Opaque buffer handles: what `dataPtr` and every `*Ptr` attribute of a node carries instead of an address."""

from __future__ import annotations

import itertools
import threading
from collections import OrderedDict
from typing import Any

CAPACITY = 4096
"""How many objects stay reachable by handle; the oldest is forgotten first."""

_objects: OrderedDict[int, Any] = OrderedDict()
_numbers = itertools.count(1)
_lock = threading.Lock()


def handle(value: Any) -> int:
    """A number (never 0) that `resolve` turns back into this object, until `CAPACITY` more were handed out."""
    with _lock:
        number = next(_numbers)
        _objects[number] = value
        while len(_objects) > CAPACITY:
            _objects.popitem(last=False)
    return number


def resolve(number: int) -> Any:
    """The object behind a handle; None for 0, unknown and forgotten handles."""
    return _objects.get(number)


def forget(number: int) -> None:
    """Drops a handle before its time; unknown ones are fine."""
    _objects.pop(number, None)
