"""Line and column of a value in a JSON text, looked up only for error messages."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

_SPACE = re.compile(r"[ \t\n\r,:]*")
_DECODER = json.JSONDecoder()


def line_and_column(text: str, location: Sequence[str | int]) -> tuple[int, int]:
    """Line and column, from 1, of the value at a location (keys and indices) of a valid JSON text.

    If a part is missing, those of the innermost existing value; of repeated keys the last counts.
    """
    at = _skip(text, 0)
    for part in location:
        found = _member(text, at, part)
        if found is None:
            break
        at = found
    return text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)


def _member(text: str, at: int, part: str | int) -> int | None:
    """The offset of the member `part` in the container at `at`."""
    opening, at = text[at : at + 1], _skip(text, at + 1)
    if opening not in "{[" or (opening == "{") != isinstance(part, str):
        return None
    found, number = None, 0
    while text[at : at + 1] not in ("}", "]", ""):
        key: str | int = number
        if opening == "{":
            key, at = _DECODER.raw_decode(text, at)
            at = _skip(text, at)
        if key == part:
            found = at
            if opening == "[":
                break
        _, at = _DECODER.raw_decode(text, at)
        at, number = _skip(text, at), number + 1
    return found


def _skip(text: str, at: int) -> int:
    match = _SPACE.match(text, at)
    return match.end() if match else at
