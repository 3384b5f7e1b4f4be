"""How messages show user text, values and suggestions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from graph.base.suggest import did_you_mean

_SHOWN = 60


def is_unicode(text: str) -> bool:
    """Whether the text can be written as UTF-8; an escape such as `\ud800` makes half a character."""
    return text.isascii() or not any("\ud800" <= character <= "\udfff" for character in text)


def shown(text: str) -> str:
    """Text from a file on one line, shortened, without control characters that a terminal would obey."""
    short = text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
    return "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in short)


def quoted(text: str) -> str:
    """As `shown`, in double quotes."""
    return f'"{shown(text)}"'


def described(value: Any) -> str:
    """A value in words: `a list`, `number 5`, `text "abc"`, `nothing`."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        shown = repr(value) if isinstance(value, float) or abs(value) < 10**20 else "with too many digits"
        return f"number {shown}"
    if isinstance(value, str):
        return f"text {quoted(value)}"
    return "a list" if isinstance(value, list) else "a mapping"


def suggestion(wrong: str, known: Iterable[str], *, listed: str = "known are") -> str:
    """The end of a sentence: the closest known name, or all of them."""
    names = [*known]
    if near := did_you_mean(wrong, names):
        return near
    return f"; {listed} {', '.join(names)}" if names else "."
