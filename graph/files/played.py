"""Messages to play into a run, as text: a YAML or JSON list, or JSON lines (.jsonl), one entry for each message.

    - {at: 0.5, topic: /cmd_vel, type: geometry_msgs/msg/Twist, message: {linear: {x: 0.2}}}
    - {at: 2, topic: /cmd_vel, message: {}}

`at`: seconds of simulation time (1/3 is exact); `type`: required at the first message of a topic; `message`: fields by
name; missing fields are zero or empty.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.exact import duration
from graph.base.inputs import start_of
from graph.base.limits import most

from . import json_text
from .source import Source, decode, file_format
from .text import described, quoted, suggestion
from .tree import Map, Seq, offset

_KEYS = ("at", "topic", "type", "message")
_LINES = ".jsonl"
_FORM = "write {at: 0.5, topic: /cmd_vel, type: geometry_msgs/msg/Twist, message: {...}}"


@dataclass(frozen=True, slots=True)
class Played:
    """One message as written: time [s], topic, type, fields, place."""

    time: Fraction
    topic: str
    type_name: str
    fields: Mapping[str, Any]
    mark: Mark


def is_played_text(path: str | Path) -> bool:
    """Whether a file name is that of a text file of messages."""
    name = str(path)
    return file_format(name) is not None or name.lower().endswith(_LINES)


def load_played(path: str | Path) -> list[Played]:
    """Reads a file of messages, in file order. Raises UserError with every problem found."""
    name = str(path)
    try:
        data = start_of(path, most("file.json") + 1)
    except OSError as error:
        raise UserError(f"{name}: {error.strerror}; name a file of messages that can be read") from None
    problems: list[Problem] = []
    source = decode(data, name, file_format(name) or "json")
    found = _read_all(source, _entries(source, name, problems), problems)
    if problems:
        raise UserError(problems)
    return found


def read_played(source: Source, entries: Iterable[tuple[Any, int]], problems: list[Problem]) -> list[Played]:
    """Messages that are part of another file, each with its offset there; adds their mistakes to `problems`."""
    return _read_all(source, ((entry, at, 0) for entry, at in entries), problems)


def _read_all(source: Source, entries: Iterable[tuple[Any, int, int]], problems: list[Problem]) -> list[Played]:
    types: dict[str, str] = {}
    read = [_read(entry, at, source, place, types, problems) for entry, at, place in entries]
    return [one for one in read if one is not None]


def _entries(source: Source, name: str, problems: list[Problem]) -> Iterator[tuple[Any, int, int]]:
    """Yields (entry, its offset in its own text, what to add to the offsets inside it)."""
    if name.lower().endswith(_LINES):
        yield from _lines(source, problems)
        return
    if file_format(name) == "json":
        root, at = json_text.parse(source, problems)
    else:
        from . import yaml_text

        root, at = yaml_text.parse(source, problems)
    if not isinstance(root, Seq):
        problems.append(source.problem(at, f"messages are a list, found {described(root)}; {_FORM} for each"))
        return
    for entry, entry_at in zip(root, root.item_at, strict=True):
        yield entry, entry_at, 0


def _lines(source: Source, problems: list[Problem]) -> Iterator[tuple[Any, int, int]]:
    start = 0
    for line in source.text.splitlines(keepends=True):
        if line.strip():
            inner: list[Problem] = []
            try:
                entry, at = json_text.parse(Source(source.name, line), inner)
            except UserError as error:
                inner += error.problems
            else:
                yield entry, at, start
            first = source.mark(start).line
            problems += (Problem(one.message, _moved(one.mark, first)) for one in inner)
        start += len(line)


def _moved(mark: Mark | None, line: int) -> Mark | None:
    return None if mark is None else Mark(mark.file, line, mark.column)


def _read(
    entry: Any, at: int, source: Source, place: int, types: dict[str, str], problems: list[Problem]
) -> Played | None:
    """One entry; None if it is wrong, after adding its problems."""
    before = len(problems)

    def wrong(key: str, message: str, *, name: bool = False) -> None:
        where = offset(entry, (key,), key=name) if isinstance(entry, Map) else at
        problems.append(source.problem(where + place, message))

    if not isinstance(entry, Map):
        wrong("", f"a message is a mapping, found {described(entry)}; {_FORM}")
        return None
    for key in entry:
        if key not in _KEYS:
            wrong(key, f"unknown key {quoted(key)}{suggestion(key, _KEYS)}", name=True)
    time, topic = entry.get("at"), entry.get("topic")
    seconds = Fraction(0)
    try:
        if time is None or isinstance(time, bool):
            raise ValueError(f"{time!r} is not a time")
        seconds = duration(time)
        if seconds < 0:
            raise ValueError("a time before the start")
    except (ValueError, TypeError, OverflowError, ZeroDivisionError) as error:
        wrong("at", f"at: {error}; give seconds from the start of the simulation, 0 or more")
    if not isinstance(topic, str) or not topic.strip("/ "):
        wrong("topic", "topic is missing; name the topic, such as /cmd_vel")
        return None
    type_name = entry.get("type", types.get(topic, ""))
    if not isinstance(type_name, str) or not type_name:
        wrong("type", f"type is missing; the first message on {topic} says its type, such as geometry_msgs/msg/Twist")
    elif types.setdefault(topic, type_name) != type_name:
        wrong("type", f"{topic} has messages of type {types[topic]} above; one topic has one type")
    fields = entry.get("message", {})
    if not isinstance(fields, Mapping):
        wrong("message", f"message is a mapping of fields, found {described(fields)}")
    if len(problems) > before:
        return None
    return Played(seconds, topic, type_name, fields, source.mark(at + place))
