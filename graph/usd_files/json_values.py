"""What USD cannot hold as it was written, kept beside it as JSON text in customData.

A value counts only while the attribute still holds what was stored with it: an edit made in another program wins.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

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
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


def kept(written: Any, stored: Any) -> str:
    """The text that restores `written` while the attribute holds `stored`."""
    return json.dumps({"written": written, "stored": stored})
