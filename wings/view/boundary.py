"""What a recording says, made safe for the page: numbers that JSON has, text on one line, scripts by their hashes only.

A recording may come from a stranger: its numbers may be infinite (a `sensor_msgs/Range` of +inf is "no return" by
REP-117), its names may hold control characters, and nothing of it may become code.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
from typing import Any

from graph.base.shorten import printable

MOST_INTEGER = 2**53
"""Beyond it a script's numbers are not exact."""


def plain(value: Any) -> Any:
    """The same data with finite numbers or None, and text without control characters."""
    if isinstance(value, str):
        return printable(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, int):
        return max(-MOST_INTEGER, min(value, MOST_INTEGER))
    if isinstance(value, dict):
        return {printable(str(key)): plain(one) for key, one in value.items()}
    return [plain(one) for one in value]


def embedded(data: Any) -> str:
    """JSON of the data that cannot end the script element that it stands in."""
    text = json.dumps(plain(data), separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def policy(*scripts: str) -> str:
    """The page's Content-Security-Policy: these scripts run and no other; nothing is loaded, sent or framed."""
    hashes = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(one.encode()).digest()).decode()}'" for one in scripts)
    return (
        f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
