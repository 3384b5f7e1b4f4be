"""Values that USD cannot hold as written, stored beside them as JSON text in customData.

The JSON text counts only while the attribute still has the value stored with it: an edit in another program wins."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from graph.files.source import DEPTH_LIMIT

from .raw_graph import KEY


def restored(value: Any, custom: Mapping[str, Any]) -> Any:
    """The value as written, if an attribute's customData has it for this stored value; else `value`."""
    ours = custom.get(KEY)
    kept = decoded(ours, "value") if isinstance(ours, dict) else None
    if not isinstance(kept, dict) or "written" not in kept or json.dumps(kept.get("stored")) != json.dumps(value):
        return value
    return kept["written"]


def is_default(value: Any, custom: Mapping[str, Any]) -> bool:
    """Whether an attribute has the default of its type, which was written for those who read the prim."""
    ours = custom.get(KEY)
    return isinstance(ours, dict) and ours.get("default") == json.dumps(value)


def decoded(ours: Mapping[str, Any], name: str) -> Any:
    """The content of one entry of our customData; None if it is missing or cannot be read."""
    text = ours.get(name)
    if not isinstance(text, str):
        return None
    try:
        return loaded(text)
    except ValueError:
        return None


def loaded(text: str) -> Any:
    """The content of our JSON text. Raises ValueError if it is not JSON, or nested deeper than a graph file may be."""
    try:
        value = json.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None
    level = [value]
    for _ in range(DEPTH_LIMIT):
        level = [inner for one in level if isinstance(one, dict | list) for inner in _inside(one)]
        if not level:
            return value
    raise ValueError("nested too deeply")


def _inside(value: dict[str, Any] | list[Any]) -> Iterable[Any]:
    return value.values() if isinstance(value, dict) else value


def kept(written: Any, stored: Any) -> str:
    """The text that restores `written` while the attribute has the value `stored`."""
    return json.dumps({"written": written, "stored": stored})


_T = TypeVar("_T")


def noted(names: Iterable[str]) -> str:
    """The record of an order, as JSON, since USD's text cannot hold every name."""
    return json.dumps(list(names))


def in_noted_order(items: Iterable[_T], name_of: Callable[[_T], str], ours: Mapping[str, Any], key: str) -> list[_T]:
    """The items in the recorded order under a key; items that are not recorded come last, in their own order."""
    listed = decoded(ours, key) if ours else None
    if not isinstance(listed, list):
        return list(items)
    rank = {str(name): position for position, name in enumerate(listed)}
    return sorted(items, key=lambda item: rank.get(name_of(item), len(rank)))
