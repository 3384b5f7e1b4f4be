"""Opaque buffer handles: the value of `dataPtr` and of every `*Ptr` attribute of a node, instead of an address."""

from __future__ import annotations

import itertools
import threading
from collections import OrderedDict
from typing import Any

CAPACITY = 4096
"""Most objects that are reachable by handle; the oldest is dropped first."""

_objects: OrderedDict[int, Any] = OrderedDict()
_numbers = itertools.count(1)
_lock = threading.Lock()


def handle(value: Any) -> int:
    """A number (never 0) that `resolve` turns back into this object, until `CAPACITY` further handles were made."""
    with _lock:
        number = next(_numbers)
        _objects[number] = value
        while len(_objects) > CAPACITY:
            _objects.popitem(last=False)
    return number


def resolve(number: int) -> Any:
    """The object of a handle; None for 0, unknown and dropped handles."""
    return _objects.get(number)


def forget(number: int) -> None:
    """Drops a handle early; unknown ones are ignored."""
    _objects.pop(number, None)
