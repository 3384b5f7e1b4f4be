"""Which warnings are one and are only counted again: a rule that the engine's list and the world's list share."""

from __future__ import annotations

from collections.abc import Collection

OWN_WORDS = ("node-warning", "node-error", "attribute-renamed", "attribute-removed")
"""Codes of what a node's author says, and of a node's attributes; the code alone does not tell two of them apart."""

MOST = 10
"""How many things one node may say before the rest is counted as one, as where its words hold the time."""

Key = tuple[str, str, str]


def key_of(code: str, where: str, message: str, seen: Collection[Key]) -> Key:
    """What a warning is counted under: code and place; for a node's own words what it says, too."""
    if code not in OWN_WORDS:
        return code, where, ""
    key = code, where, message
    if key in seen or sum(one[:2] == key[:2] for one in seen) < MOST:
        return key
    return code, where, ""
