"""Puts a `fidelity:` block into a graph file; all of the file but that block stays as it is, comments included."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from graph.base.errors import UserError, reason_of
from graph.base.inputs import read
from graph.base.outputs import write
from graph.files.source import file_format

KEY = "fidelity"
AFTER = ("clock", "scene", "tickgraph")
"""A new block stands behind the first of these that the file has."""


def check_writable(file: Path) -> None:
    """Raises UserError for a file that `write_block` cannot change. Broken ones pass: opening them says where."""
    if file.suffix.lower() not in (".yaml", ".yml", ".json"):
        raise UserError(f"--write: {file} is not a YAML or JSON file; leave out --write and paste the block")
    with suppress(*_broken()):
        with_block(file, {})


def write_block(file: Path, values: Mapping[str, str]) -> None:
    """Sets knobs in the file. Raises UserError if it cannot be written."""
    try:
        text = with_block(file, values)
        write(file, text)
    except OSError as error:
        raise UserError(f"--write {file}: {error.strerror}; paste the block") from None
    except _broken() as error:
        raise UserError(f"--write {file}: it cannot be read in place ({reason_of(error)}); paste the block") from None


def _broken() -> tuple[type[Exception], ...]:
    """The error that a text raises that is neither YAML nor JSON."""
    from ruamel.yaml.error import YAMLError

    return (YAMLError, ValueError)


def with_block(file: Path, values: Mapping[str, str]) -> str:
    """The text of the file with these knobs set. Raises UserError for a file whose block cannot be set in its place."""
    text = read(file, f"file.{file_format(file.name) or 'yaml'}").decode("utf-8")
    return _in_json(text, values) if file.suffix.lower() == ".json" else _in_yaml(file, text, values)


def _in_json(text: str, values: Mapping[str, str]) -> str:
    mark = "\ufeff" * text.startswith("\ufeff")
    document = json.loads(text.removeprefix(mark))
    if not isinstance(document, dict):
        raise ValueError("it is not a mapping")
    document[KEY] = {**(document.get(KEY) or {}), **{name: _plain(value) for name, value in values.items()}}
    return mark + json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _in_yaml(file: Path, text: str, values: Mapping[str, str]) -> str:
    from ruamel.yaml import YAML
    from ruamel.yaml.comments import CommentedMap

    yaml = YAML()
    yaml.width, yaml.preserve_quotes = 4096, True
    document = yaml.load(text)
    if not isinstance(document, CommentedMap) or document.fa.flow_style():
        raise UserError(f"--write: the keys of {file} are not on lines of their own; paste the block")
    lines = text.splitlines(keepends=True)
    starts = sorted(document.lc.key(key)[0] for key in document)
    last = next((number for number, line in enumerate(lines) if line.rstrip() == "..."), len(lines))
    new = "".join(f"  {name}: {value}\n" for name, value in values.items())
    if KEY not in document:
        at = end = _behind(document, lines, [*starts, last])
        new = f"{KEY}:\n{new}"
        if at and not lines[at - 1].endswith("\n"):
            new = f"\n{new}"
    elif document[KEY] is None and lines[document.lc.key(KEY)[0]].partition("#")[0].strip() == f"{KEY}:":
        at = end = document.lc.key(KEY)[0] + 1
    else:
        at = document.lc.key(KEY)[0]
        end = next((line for line in [*starts, last] if line > at), len(lines))
        new = _renewed(yaml, document, values)
    if not values:
        return text
    ending = "\r\n" if "\r\n" in text else "\n"
    return "".join([*lines[:at], new.replace("\r\n", "\n").replace("\n", ending), *lines[end:]])


def _renewed(yaml: Any, document: Any, values: Mapping[str, str]) -> str:
    """The section with its comments; new knobs are in front, for comments at the end belong to what follows."""
    from ruamel.yaml.comments import CommentedMap

    section = document[KEY]
    if not isinstance(section, CommentedMap):
        section = document[KEY] = CommentedMap()
    for name, value in reversed([*values.items()]):
        if name in section:
            section[name] = _plain(value)
        else:
            section.insert(0, name, _plain(value))
    alone = CommentedMap({KEY: section})
    if KEY in document.ca.items:
        alone.ca.items[KEY] = document.ca.items[KEY]
    stream = io.StringIO()
    yaml.dump(alone, stream)
    return stream.getvalue()


def _behind(document: Any, lines: list[str], starts: list[int]) -> int:
    """The line at which a new block begins: behind a key, in front of the comments of the next one."""
    key = next((key for key in AFTER if key in document), None)
    line = document.lc.key(key)[0] if key is not None else -1
    at = next((start for start in starts if start > line), len(lines))
    while at > line + 1 and (not (before := lines[at - 1].strip()) or before.startswith("#")):
        at -= 1
    return at


def _plain(value: str) -> Any:
    """A knob's text as a number where it is one."""
    for kind in (int, float):
        try:
            return kind(value)
        except ValueError:
            continue
    return value
