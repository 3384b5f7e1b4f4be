"""Keeps messages on one readable line, however long the names and lists in them are."""

from __future__ import annotations

import re
from collections.abc import Sequence

SHORT = 400
"""Messages of at most this many characters are shown unchanged."""
LONGEST = 1500
"""Most characters of a message."""
WORD = 80
"""Most characters of a quoted name or of a single word in a message longer than `SHORT`."""
LISTED = 8
"""Most entries of a list in a message."""

_PARTS = re.compile(rf"""\"[^"]*\"|(?<!\w)'[^']*'(?!\w)|\S{{{WORD + 1},}}""")
_END = 300
"""Characters kept at the end of a shortened message, because the end says what to do."""


def brief(message: str) -> str:
    """The message with long names shortened in the middle; if it is still too long, without its own middle."""
    if len(message) <= SHORT:
        return message
    message = _PARTS.sub(lambda found: _shortened(found[0], WORD, WORD // 4, "..."), message)
    return _shortened(message, LONGEST, _END, " [...] ")


def listed(parts: Sequence[str], most: int = LISTED) -> str:
    """The first entries, and how many more there are."""
    more = f" and {len(parts) - most:,} more" if len(parts) > most else ""
    return ", ".join(parts[:most]) + more


def _shortened(text: str, longest: int, end: int, gap: str) -> str:
    if len(text) <= longest:
        return text
    return f"{text[: longest - end - len(gap)]}{gap}{text[-end:]}"


def printable(text: str) -> str:
    """Text on one line: line breaks become spaces, other control characters are shown as escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else " " if c in "\n\t" else f"\\u{ord(c):04x}" for c in text)
