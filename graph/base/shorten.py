"""Messages stay one line that a person can read, however long the names and lists in them are."""

from __future__ import annotations

import re
from collections.abc import Sequence

SHORT = 400
"""Characters of a message that is shown as it is."""
LONGEST = 1500
"""Characters of the longest message."""
WORD = 80
"""Characters that a quoted name or a single word keeps in a longer message."""
LISTED = 8
"""Entries that a line names."""

_PARTS = re.compile(rf"""\"[^"]*\"|(?<!\w)'[^']*'(?!\w)|\S{{{WORD + 1},}}""")
_END = 300
"""Characters kept of a message's end, which says what to do."""


def brief(message: str) -> str:
    """The message with its names shortened to their ends, and without its middle where that is not enough."""
    if len(message) <= SHORT:
        return message
    message = _PARTS.sub(lambda found: _shortened(found[0], WORD, WORD // 4, "..."), message)
    return _shortened(message, LONGEST, _END, " [...] ")


def listed(parts: Sequence[str], most: int = LISTED) -> str:
    """The first parts, and how many more there are."""
    more = f" and {len(parts) - most:,} more" if len(parts) > most else ""
    return ", ".join(parts[:most]) + more


def _shortened(text: str, longest: int, end: int, gap: str) -> str:
    if len(text) <= longest:
        return text
    return f"{text[: longest - end - len(gap)]}{gap}{text[-end:]}"
