"""Writes documents as YAML and JSON text that reads back as the same file.

The YAML is plain: block mappings down to nodes and prims, values in flow style on one line, quotes only where a text
would be read as something else, comments above the key they belong to.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from . import scalars
from .comments import place_of, place_of_connection

_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_./+-]*(?: (?:->|[A-Za-z0-9_./+-]+))*")
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r", "\0": "\\0"}
_BLOCKS = {(): True, ("scene",): True, ("scene", "prims"): True, ("graphs",): True}
_NODE_LISTS = ("variables", "nodes", "connections")


def json_document(document: Mapping[str, Any]) -> str:
    """The document as JSON text, with NaN and infinities as `NaN` and `Infinity`, which our loader reads."""
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def yaml_document(document: Mapping[str, Any], comments: Mapping[str, str] | None = None) -> str:
    """The document as YAML text.

    comments: text by place (see `comments`); comments whose place is not in the document are written at the end.
    """
    rest = dict(comments or {})
    lines = [*_comment(rest.pop("", ""), 0), *_block(document, (), rest)]
    for text in rest.values():
        lines += _comment(text, 0)
    return "\n".join(lines) + "\n"


def _block(mapping: Mapping[str, Any], at: tuple[str, ...], comments: dict[str, str]) -> Iterator[str]:
    """The lines of a mapping; removes the comments that it writes from `comments`."""
    indent = "  " * len(at)
    for key, value in mapping.items():
        here = (*at, key)
        if comments:
            yield from _comment(comments.pop(place_of(here), ""), len(at))
        if isinstance(value, Mapping) and value and _is_block(here):
            yield f"{indent}{scalar(key)}:"
            yield from _block(value, here, comments)
        elif isinstance(value, list) and value and here[0] == "graphs" and here[2:] == ("connections",):
            yield f"{indent}{scalar(key)}:"
            for item in value:
                if comments:
                    yield from _comment(comments.pop(place_of_connection(here[1], str(item)), ""), len(at) + 1)
                yield f"{indent}  - {flow(item)}"
        else:
            yield f"{indent}{scalar(key)}: {flow(value)}"


def _is_block(at: tuple[str, ...]) -> bool:
    """Whether the mapping at a location is written with a line for each key."""
    if at in _BLOCKS:
        return True
    return at[0] == "graphs" and (len(at) == 2 or (len(at) == 3 and at[2] in _NODE_LISTS))


def _comment(text: str, depth: int) -> Iterator[str]:
    for line in text.splitlines():
        shown = "".join(c if c.isprintable() or c == "\t" else " " for c in line)
        yield f"{'  ' * depth}# {shown}".rstrip()


def flow(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{scalar(key)}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(flow, value)) + "]"
    return scalar(value)


def scalar(value: Any) -> str:
    """A number, text, true, false or null."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        if math.isnan(value):
            return ".nan"
        return repr(float(value)) if math.isfinite(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, int):
        return str(int(value))
    text = str(value)
    if _PLAIN.fullmatch(text) and _reads_as_text(text):
        return text
    return '"' + "".join(_ESCAPES.get(c) or (c if c.isprintable() else _escape(ord(c))) for c in text) + '"'


def _reads_as_text(text: str) -> bool:
    try:
        return scalars.resolve(text) == text
    except ValueError:
        return False


def _escape(code: int) -> str:
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
