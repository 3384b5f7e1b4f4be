"""What USD cannot hold as it was written, kept beside it as JSON text in customData.

A value counts only while the attribute still holds what was stored with it: an edit made in another program wins.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from graph.files.source import DEPTH_LIMIT

from .node_prims import KEY


def restored(value: Any, custom: Mapping[str, Any]) -> Any:
    """The value as it was written, if an attribute's customData keeps one for this stored value; else `value`."""
    ours = custom.get(KEY)
    kept = decoded(ours, "value") if isinstance(ours, dict) else None
    if not isinstance(kept, dict) or "written" not in kept or json.dumps(kept.get("stored")) != json.dumps(value):
        return value
    return kept["written"]


def decoded(ours: Mapping[str, Any], name: str) -> Any:
    """What one entry of our customData says; None where there is no such entry, or none that can be read."""
    text = ours.get(name)
    if not isinstance(text, str):
        return None
    try:
        return loaded(text)
    except ValueError:
        return None


def loaded(text: str) -> Any:
    """What a JSON text of ours says. Raises ValueError for what is not JSON, or nested deeper than a graph file may."""
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
    """The text that restores `written` while the attribute holds `stored`."""
    return json.dumps({"written": written, "stored": stored})
