"""Which warnings count as the same one. The warning lists of the engine and of the world share this rule."""

from __future__ import annotations

from collections.abc import Collection

OWN_WORDS = ("node-warning", "node-error", "attribute-renamed", "attribute-removed", "usd-composition")
"""Codes whose warnings carry the text of a node's author or of USD, or name an attribute: the code alone does not tell
them apart.
"""

MOST = 10
"""Most different texts of one node and code (a text may contain the time); further ones are counted together."""

Key = tuple[str, str, str]


def key_of(code: str, where: str, message: str, seen: Collection[Key]) -> Key:
    """The key under which a warning is counted: code and place, and the text too for the codes of `OWN_WORDS`."""
    if code not in OWN_WORDS:
        return code, where, ""
    key = code, where, message
    if key in seen or sum(one[:2] == key[:2] for one in seen) < MOST:
        return key
    return code, where, ""
