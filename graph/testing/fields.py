"""The values of test files: lists of updates, ranges, tolerances; how they are read, and their JSON Schema."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from graph.base.forms import Check, Refused
from graph.files.text import described, quoted

from .updates import UpdateList, read_range

MOST_UPDATES = 1_000_000
"""Most updates that one case may run or name."""


def whole(value: Any) -> Any:
    """A whole number; true and 1.0 are refused."""
    if type(value) is not int:
        raise Refused("must be a whole number")
    return value


def _update_list(value: Any) -> UpdateList:
    if not isinstance(value, list):
        raise Refused(f"must be a list of updates such as [0, 3, 6..9], found {described(value)}")
    updates = UpdateList(tuple(map(_range, value)))
    if len(updates) > MOST_UPDATES:
        raise Refused(f"names more than {MOST_UPDATES:,} updates; write fewer")
    return updates


def _range(item: Any) -> range:
    found = read_range(item, MOST_UPDATES)
    if found is None:
        raise Refused(f"{_shown(item)} is not an update; write its index, 0 or more, or a range such as 0..11")
    return found


def _shown(item: Any) -> str:
    return quoted(item) if isinstance(item, str) else described(item)


def _by_update(value: Any) -> Any:
    if not isinstance(value, dict):
        raise Refused(f"must be a mapping from updates to values by attribute, found {described(value)}")
    for key, changes in value.items():
        _range(key)
        if not isinstance(changes, dict):
            raise Refused(f"update {key}: must be a mapping from attributes to values, found {described(changes)}")
    return value


def _values(value: Any) -> Any:
    if isinstance(value, dict):
        for key in value:
            _range(key)
    elif not isinstance(value, list):
        raise Refused(
            f"must be a list with the value after each update, or a mapping from updates to values, "
            f"found {described(value)}"
        )
    return value


def _count_or_updates(value: Any) -> Any:
    if type(value) is int and value >= 0:
        return value
    if isinstance(value, list):
        return _update_list(value)
    raise Refused(f"must be a count or a list of updates such as [0, 3, 6..9], found {described(value)}")


def _playing(value: Any) -> Any:
    return value if isinstance(value, bool) else _update_list(value)


def _play(value: Any) -> Any:
    """The list of files and messages; a single one needs no list. A message is read with its place later."""
    entries = value if isinstance(value, list) else [value]
    for entry in entries:
        if not isinstance(entry, (str, dict)) or not entry:
            raise Refused(f"must be a file of messages, a message, or a list of such, found {described(value)}")
    return entries


def _tolerance(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _one_tolerance(one) for key, one in value.items()}
    return _one_tolerance(value)


def _one_tolerance(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value >= 0:
        raise Refused(f"must be a number of 0 or more, or a mapping from attributes to such, found {described(value)}")
    return float(value)


def _texts(value: Any) -> tuple[str, ...]:
    texts = value if isinstance(value, list) else [value]
    if not texts or not all(isinstance(text, str) and text for text in texts):
        raise Refused(f"must be a piece of the error's text, or a list of such, found {described(value)}")
    return tuple(texts)


def text_as(key: str) -> Callable[[Any], Any]:
    """Wraps a text, or a list, into a mapping with it under `key`."""
    return lambda value: {key: value} if isinstance(value, (str, list)) else value


def empty_if_null(value: Any) -> Any:
    """An entry without a value counts as an empty one."""
    return {} if value is None else value


def name_or_graph(value: Any, graph: Callable[[Any], Any]) -> Any:
    """A file name stays text, a mapping becomes a graph."""
    if isinstance(value, str):
        if not value:
            raise Refused("is empty; give it a value")
        return value
    return graph(value)


_UPDATE: dict[str, Any] = {
    "anyOf": [{"type": "integer", "minimum": 0}, {"type": "string", "pattern": r"^[0-9]+\.\.[0-9]+$"}]
}
_UPDATES: dict[str, Any] = {"type": "array", "items": _UPDATE}
_UPDATE_KEYS: dict[str, Any] = {"propertyNames": {"pattern": r"^[0-9]+(\.\.[0-9]+)?$"}}
PATH_KEYS: dict[str, Any] = {"propertyNames": {"pattern": "^/"}}
_NUMBER: dict[str, Any] = {"type": "number", "minimum": 0}
_COUNT = {"type": "integer", "minimum": 0}
_TEXT = {"type": "string", "minLength": 1}
_MESSAGE: dict[str, Any] = {
    "type": "object",
    "properties": {
        "at": {"description": "Seconds from play."},
        "topic": _TEXT,
        "type": {"description": "Message type, at the first message of a topic.", **_TEXT},
        "message": {"description": "Fields by name; missing ones are zero or empty.", "type": "object"},
    },
    "required": ["at", "topic"],
    "additionalProperties": False,
}

Updates = Annotated[Any, Check(_update_list, _UPDATES)]
CountOrUpdates = Annotated[Any, Check(_count_or_updates, {"anyOf": [_COUNT, _UPDATES]})]
Changes = Annotated[
    Any,
    Check(_by_update, {"type": "object", "additionalProperties": {"type": "object"}, **_UPDATE_KEYS}),
]
Playing = Annotated[Any, Check(_playing, {"anyOf": [{"type": "boolean"}, _UPDATES]})]
Play = Annotated[
    list[Any],
    Check(_play, {"anyOf": [_TEXT, _MESSAGE, {"type": "array", "items": {"anyOf": [_TEXT, _MESSAGE]}}]}),
]
Values = Annotated[Any, Check(_values, {"anyOf": [{"type": "array"}, {"type": "object", **_UPDATE_KEYS}]})]
Tolerance = Annotated[
    Any,
    Check(_tolerance, {"anyOf": [_NUMBER, {"type": "object", "additionalProperties": _NUMBER}]}),
]
Texts = Annotated[
    tuple[str, ...],
    Check(_texts, {"anyOf": [_TEXT, {"type": "array", "items": _TEXT, "minItems": 1}]}),
]
