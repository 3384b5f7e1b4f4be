"""Parses YAML 1.2 text to a tree with file positions.

ruamel.yaml supplies the events; their meaning is decided here: `scalars` reads scalars; keys are always text; repeated
keys, foreign tags and merge keys are problems; aliases share their value, up to a total size.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from graph.base.errors import Problem, UserError

from . import scalars
from .source import DEPTH_LIMIT, Source
from .text import is_unicode, quoted
from .tree import KeyCount, Map, Seq
from .yaml_slips import slip

ALIASED_LIMIT = 100_000
"""Most values that all aliases of a file together may stand for (protects against alias bombs)."""

_CORE = "tag:yaml.org,2002:"
_SCALAR_KINDS: dict[str, tuple[type, ...]] = {
    f"{_CORE}null": (type(None),),
    f"{_CORE}bool": (bool,),
    f"{_CORE}int": (int,),
    f"{_CORE}float": (int, float),
}
_NO_KEY = object()

Event = Any  # ruamel declares no attributes of its events


def parse(source: Source, problems: list[Problem]) -> tuple[Any, int]:
    """The tree of a YAML text and its offset.

    Broken syntax raises UserError; all other problems are added to `problems`.
    """
    return _Composer(source, problems).document()


def _events(source: Source) -> Iterator[Event]:
    try:
        yield from YAML(typ="safe", pure=True).parse(source.text)
    except MarkedYAMLError as error:
        raise _broken(source, error) from error
    except (YAMLError, ValueError, OverflowError) as error:  # the last two: escapes such as "\UFFFFFFFF"
        first = (str(error).splitlines() or ["unreadable text"])[0]
        raise UserError(source.problem(getattr(error, "position", 0) or 0, f"this is not YAML: {first}")) from error


class _Open:
    """An open container, the key that waits for its value, and the number of values inside."""

    __slots__ = ("anchor", "key", "key_at", "node", "size")

    def __init__(self, node: Map | Seq, anchor: str | None) -> None:
        self.node = node
        self.anchor = anchor
        self.key: Any = _NO_KEY
        self.key_at = 0
        self.size = 1


class _Composer:
    def __init__(self, source: Source, problems: list[Problem]) -> None:
        self.source = source
        self.problems = problems
        self.anchors: dict[str, tuple[Any, int] | None] = {}
        self.aliased = 0
        self.stack: list[_Open] = []
        self.root: tuple[Any, int] | None = None
        self.keys = KeyCount(source.name)

    def document(self) -> tuple[Any, int]:
        documents = 0
        for event in _events(self.source):
            kind = type(event)
            if kind is ScalarEvent:
                self._take(self._scalar(event), self._place(event), 1, event.anchor)
            elif kind is MappingStartEvent:
                self._open(Map(event.start_mark.index), event, "map")
            elif kind is SequenceStartEvent:
                self._open(Seq(event.start_mark.index), event, "seq")
            elif kind is MappingEndEvent or kind is SequenceEndEvent:
                self._close()
            elif kind is AliasEvent:
                self._alias(event)
            elif kind is DocumentStartEvent:
                documents += 1
                self._start(event, documents)
        if self.root is None:
            raise UserError(self.source.problem(0, 'the file is empty; a graph file starts with "tickgraph: 1"'))
        return self.root

    def _start(self, event: Event, documents: int) -> None:
        at = event.start_mark.index
        if documents > 1:
            raise UserError(self.source.problem(at, "a second document starts here; a graph file holds one"))
        if event.version is not None and tuple(event.version) != (1, 2):
            version = ".".join(map(str, event.version))
            raise UserError(self.source.problem(at, f"graph files are YAML 1.2, not {version}; remove the directive"))

    def _open(self, node: Map | Seq, event: Event, tag: str) -> None:
        if event.tag is not None and str(event.tag) not in ("!", _CORE + tag):
            self._foreign_tag(event)
        if len(self.stack) >= DEPTH_LIMIT:
            raise UserError(self.source.problem(node.at, f"nested deeper than {DEPTH_LIMIT}"))
        if self.stack and isinstance(self.stack[-1].node, Map) and self.stack[-1].key is _NO_KEY:
            message = "a key must be text, not a list or a mapping; quote it if it is meant as text"
            raise UserError(self.source.problem(node.at, message))
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        self.stack.append(_Open(node, event.anchor))

    def _close(self) -> None:
        done = self.stack.pop()
        self._take(done.node, done.node.at, done.size, done.anchor)

    def _take(self, value: Any, at: int, size: int, anchor: str | None) -> None:
        """Puts a finished value into its container; `size` counts the values in it."""
        if anchor is not None:
            self.anchors[anchor] = (value, size)
        if not self.stack:
            self.root = (value, at)
            return
        parent = self.stack[-1]
        parent.size += size
        node = parent.node
        if isinstance(node, Seq):
            node.add(value, at)
        elif parent.key is _NO_KEY:
            self.keys.add()
            parent.key, parent.key_at = value, at
        else:
            key, parent.key = parent.key, _NO_KEY
            if value is None and at == parent.key_at and re.fullmatch(r"\w+:[^\s:]\S*", key):
                self._problem(at, f"a space is missing after the first colon of {quoted(key)}")
            if key in node:
                first = self.source.mark(node.places[key][0])
                self._problem(parent.key_at, f"key {quoted(key)} is repeated; it is already in line {first.line}")
            else:
                node.add(key, parent.key_at, value, at)

    def _scalar(self, event: Event) -> Any:
        text: str = event.value
        plain = event.implicit[0]
        if plain and event.start_mark.line != event.end_mark.line:
            self._check_lines(event)
        if not is_unicode(text):
            self._problem(event.start_mark.index, f"{quoted(text)} holds half a surrogate pair; write the character")
        parent = self.stack[-1] if self.stack else None
        if parent is not None and parent.key is _NO_KEY and isinstance(parent.node, Map):
            if text == "<<" and plain:
                self._problem(event.start_mark.index, "YAML 1.2 has no merge keys (<<); write the keys out")
            return text
        tag = None if event.tag is None else str(event.tag)
        if tag is not None and tag not in ("!", f"{_CORE}str") and tag not in _SCALAR_KINDS:
            self._foreign_tag(event)
            return text
        if tag not in _SCALAR_KINDS and (tag is not None or not plain):
            return text
        try:
            value = scalars.resolve(text)
        except ValueError as error:
            self._problem(event.start_mark.index, str(error))
            return scalars.STAND_IN
        if tag in _SCALAR_KINDS:
            if not isinstance(value, _SCALAR_KINDS[tag]) or (isinstance(value, bool) and not tag.endswith("bool")):
                self._problem(event.start_mark.index, f"{quoted(text)} does not fit the tag {tag.removeprefix(_CORE)}")
            elif tag.endswith("float"):
                return float(value)  # type: ignore[arg-type]  # int or float, just tested
        return value

    def _check_lines(self, event: Event) -> None:
        """Reports a list item that is indented as if it went on with the text of the one above."""
        start = event.start_mark.index
        item = re.search(r"\n *(?=- )", self.source.text[start : event.end_mark.index])
        if item:
            message = (
                'this "- " is indented deeper than the item above, so that it belongs to its text; indent both alike'
            )
            self._problem(start + item.end(), message)

    def _place(self, event: Event) -> int:
        """The offset of a scalar; an empty value is placed at its key, because the next text may be lines below."""
        parent = self.stack[-1] if self.stack else None
        if event.start_mark.index == event.end_mark.index and parent is not None and parent.key is not _NO_KEY:
            return parent.key_at
        return int(event.start_mark.index)

    def _alias(self, event: Event) -> None:
        at = event.start_mark.index
        if event.anchor not in self.anchors:
            raise UserError(self.source.problem(at, f"alias *{event.anchor} has no anchor &{event.anchor} above it"))
        target = self.anchors[event.anchor]
        if target is None:
            raise UserError(self.source.problem(at, f"alias *{event.anchor} stands inside its own anchor"))
        value, size = target
        parent = self.stack[-1] if self.stack else None
        if parent is not None and parent.key is _NO_KEY and isinstance(parent.node, Map) and not isinstance(value, str):
            raise UserError(self.source.problem(at, "a key must be text; this alias stands for something else"))
        self.aliased += size
        if self.aliased > ALIASED_LIMIT:
            message = f"the aliases of this file stand for more than {ALIASED_LIMIT:,} values; write fewer of them"
            raise UserError(self.source.problem(at, message))
        self._take(value, at, size, None)

    def _foreign_tag(self, event: Event) -> None:
        message = f"tag {quoted(str(event.tag))} is not read; graph files are plain data. Remove the tag"
        self._problem(event.start_mark.index, message)

    def _problem(self, at: int, message: str) -> None:
        self.problems.append(self.source.problem(at, message))


def _broken(source: Source, error: MarkedYAMLError) -> UserError:
    if source.text.startswith("#usda"):
        return UserError(source.problem(0, "this is USD text; give it a name that ends in .usda"))
    return UserError(source.problem(*slip(source.text, error)))
