"""What USD cannot hold as it was written, kept beside it as JSON text in customData.

A value counts only while the attribute still holds what was stored with it: an edit made in another program wins.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from .node_prims import KEY


def restored(value: Any, custom: Mapping[str, Any], name: str = "value") -> Any:
    """The value as it was written, if `custom` keeps one for this stored `value`; else `value` itself."""
    ours = custom.get(KEY, custom) if name == "value" else custom
    text = ours.get(name) if isinstance(ours, dict) else None
    if not isinstance(text, str):
        return value
    try:
        kept = json.loads(text)
    except ValueError:
        return value
    if name != "value":
        return kept if isinstance(kept, dict) else value
    if not isinstance(kept, dict) or "written" not in kept or kept.get("stored") != value:
        return value
    return kept["written"]


def kept(written: Any, stored: Any) -> dict[str, str]:
    """The customData (below our key) that restores `written` while the attribute holds `stored`."""
    return {"value": json.dumps({"written": written, "stored": stored})}
