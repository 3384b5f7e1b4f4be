"""Callbacks that scripts register for new values of attributes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary

from graph.editing.graph_set import GraphSet

_CALLBACKS: WeakKeyDictionary[GraphSet, dict[str, Callable[[], None]]] = WeakKeyDictionary()


def watch(graphs: GraphSet, path: str, callback: Callable[[], Any] | None) -> None:
    """Sets the callback for the attribute with that path; None removes it."""
    known = _CALLBACKS.setdefault(graphs, {})
    if callback is None:
        known.pop(path, None)
    else:
        known[path] = callback


def tell_changed(graphs: GraphSet, path: str) -> None:
    """Calls the callback for an attribute that got a value."""
    if (known := _CALLBACKS.get(graphs)) and (callback := known.get(path)) is not None:
        callback()
