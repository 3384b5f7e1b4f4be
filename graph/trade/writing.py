"""Puts a `fidelity:` block into a graph file; all of the file but that block stays as it is, comments included."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from graph.base.errors import UserError

KEY = "fidelity"
AFTER = ("clock", "scene", "tickgraph")
"""A new block stands behind the first of these that the file has."""


def check_writable(file: Path) -> None:
    """Raises UserError for a file that `write_block` cannot change."""
    if file.suffix.lower() not in (".yaml", ".yml", ".json"):
        raise UserError(f"--write: {file} is not a YAML or JSON file; leave out --write and paste the block")
    with_block(file, {})


def write_block(file: Path, values: Mapping[str, str]) -> None:
    """Sets knobs in the file. Raises UserError if it cannot be written."""
    text = with_block(file, values)
    try:
        file.write_text(text, encoding="utf-8", newline="")
    except OSError as error:
        raise UserError(f"--write {file}: {error.strerror}; paste the block") from None


def with_block(file: Path, values: Mapping[str, str]) -> str:
    """The text of the file with these knobs set. Raises UserError for a file whose block cannot be set in its place."""
    text = file.read_bytes().decode("utf-8")
    if file.suffix.lower() == ".json":
        document = json.loads(text)
        document[KEY] = {**document.get(KEY, {}), **{name: _plain(value) for name, value in values.items()}}
        return json.dumps(document, indent=2, ensure_ascii=False) + "\n"
    from ruamel.yaml import YAML
    from ruamel.yaml.comments import CommentedMap

    yaml = YAML()
    yaml.width, yaml.preserve_quotes = 4096, True
    document = yaml.load(text)
    if not isinstance(document, CommentedMap) or document.fa.flow_style():
        raise UserError(f"--write: the keys of {file} are not on lines of their own; paste the block")
    lines = text.splitlines(keepends=True)
    starts = sorted(document.lc.key(key)[0] for key in document)
    if KEY not in document:
        if not values:
            return text
        at = _behind(document, lines, starts)
        new = "".join([f"{KEY}:\n", *(f"  {name}: {value}\n" for name, value in values.items())])
        before = "".join(lines[:at])
        return (before if before.endswith("\n") or not before else f"{before}\n") + new + "".join(lines[at:])
    section = document[KEY]
    if not isinstance(section, CommentedMap):
        section = document[KEY] = CommentedMap()
    for place, (name, value) in enumerate(values.items()):
        if name in section:
            section[name] = _plain(value)
        else:
            section.insert(place, name, _plain(value))  # in front: comments at the end belong to what follows
    alone = CommentedMap({KEY: section})
    if KEY in document.ca.items:
        alone.ca.items[KEY] = document.ca.items[KEY]
    stream = io.StringIO()
    yaml.dump(alone, stream)
    first = document.lc.key(KEY)[0]
    end = next((line for line in starts if line > first), len(lines))
    return "".join([*lines[:first], stream.getvalue(), *lines[end:]])


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
