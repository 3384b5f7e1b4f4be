"""The text of a connection: `a.x -> b.y`, or `a.x -> [b.y, c.z]` for several targets in order."""

from __future__ import annotations

import re

from graph.base.records import dataclass

from .text import quoted

# An end is everything up to the last dot, the dot, and an attribute name that may contain namespaces.
_END = r"[^\s\[\],.>][^\s\[\],>]*\.[^\s\[\],.>]+"
_ONE = re.compile(rf"\s*({_END})\s*->\s*({_END})\s*")
PATTERN = rf"^\s*{_END}\s*->\s*({_END}|\[\s*{_END}(\s*,\s*{_END})*\s*,?\s*\])\s*$"
"""The pattern of a connection, for the JSON Schema."""

_END_ONLY = re.compile(_END)
_FORM = 'write "node.output -> node.input", or "node.output -> [node.input, other.input]"'


@dataclass(frozen=True, slots=True)
class Link:
    """One source and one target; `target_at` is the target's offset in the text."""

    source: str
    target: str
    target_at: int


def parse(text: str) -> list[Link]:
    """The links of a connection, targets in order. Raises ValueError with a message for the user."""
    if found := _ONE.fullmatch(text):
        return [Link(found[1], found[2], found.start(2))]
    arrows = text.count("->")
    if arrows != 1:
        reason = "has no arrow" if arrows == 0 else f"has {arrows} arrows"
        raise ValueError(f"connection {quoted(text)} {reason}; {_FORM}")
    left, _, right = text.partition("->")
    source = _end(left, text)
    start = len(left) + 2
    inner = right.strip()
    if not inner.startswith("["):
        return [Link(source, _end(right, text), start)]
    if not inner.endswith("]"):
        raise ValueError(f'connection {quoted(text)} opens "[" without closing it; {_FORM}')
    start += right.index("[") + 1
    links = []
    for item in _items(inner[1:-1], text):
        links.append(Link(source, _end(item, text), start + len(item) - len(item.lstrip())))
        start += len(item) + 1
    return links


def _items(inner: str, text: str) -> list[str]:
    items = inner.split(",")
    if not items[-1].strip():
        items.pop()
    if not items:
        raise ValueError(f"connection {quoted(text)} has no target; {_FORM}")
    return items


def _end(part: str, text: str) -> str:
    end = part.strip()
    if _END_ONLY.fullmatch(end):
        return end
    if not end:
        raise ValueError(f"connection {quoted(text)} has only one end; {_FORM}")
    if "." not in end:
        raise ValueError(f'connection end {quoted(end)} names no attribute; write "{end[:40]}.attribute"')
    raise ValueError(f"connection end {quoted(end)} is not of the form node.attribute; {_FORM}")
