"""Parses JSON text to a tree with file positions.

The grammar is the standard library's (RFC 8259 plus NaN and Infinity, which a node's input may hold). Unlike the
standard library, repeated keys are problems, every value keeps its offset, and nesting needs no recursion.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from json import decoder
from typing import Any

from graph.base.errors import Problem, UserError

from . import scalars
from .source import DEPTH_LIMIT, Source
from .text import is_unicode, quoted
from .tree import KeyCount, Map, Seq

# The standard library's own scanner of strings, which typeshed leaves out.
_scan_string: Callable[[str, int, bool], tuple[str, int]] = decoder.scanstring  # type: ignore[attr-defined]
_SPACE = re.compile(r"[ \t\n\r]*")
# Text without escapes, and the punctuation that may follow it: nearly every key and text, read many times faster.
_SIMPLE_KEY = re.compile(r'"([^"\\\x00-\x1f]*)"[ \t\n\r]*:[ \t\n\r]*').match
_SIMPLE_VALUE = re.compile(r'"([^"\\\x00-\x1f]*)"[ \t\n\r]*').match
_NUMBER = re.compile(r"-?(?:0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?")
_WORDS: dict[str, Any] = {
    "null": None,
    "true": True,
    "false": False,
    "NaN": math.nan,
    "Infinity": math.inf,
    "-Infinity": -math.inf,
}
_WORD = re.compile("|".join(_WORDS))


def parse(source: Source, problems: list[Problem]) -> tuple[Any, int]:
    """The tree of a JSON text and its offset; repeated keys are added to `problems`, broken syntax raises UserError."""
    return _Reader(source, problems).document()


class _Reader:
    def __init__(self, source: Source, problems: list[Problem]) -> None:
        self.source = source
        self.text = source.text
        self.problems = problems
        self.keys = KeyCount(source.name)

    def document(self) -> tuple[Any, int]:
        start = self._skip(0)
        root, at = self._value(start)
        at = self._skip(at)
        if isinstance(root, (Map, Seq)):
            at = self._fill(root, at)
        if at < len(self.text):
            raise self._broken(at, "more text after the end of the document")
        return root, start

    def _fill(self, root: Map | Seq, at: int) -> int:
        """Reads the members of a container that was just opened, and everything inside it."""
        text = self.text
        stack: list[Map | Seq] = []
        node: Map | Seq = root
        fresh = True
        while True:
            mapping = isinstance(node, Map)
            char = text[at : at + 1]
            if char == ("}" if mapping else "]"):
                at = self._skip(at + 1)
                if not stack:
                    return at
                node = stack.pop()
                fresh = False
                continue
            if not fresh:
                at = self._next_member(node, at)
            fresh = False
            key, value_at = self._key(at) if mapping else ("", at)
            simple = _SIMPLE_VALUE(text, value_at)
            if simple:
                value: Any = simple[1]
                after = simple.end()
            else:
                value, after = self._value(value_at)
                after = self._skip(after)
            if isinstance(node, Seq):
                node.add(value, value_at)
            else:
                self.keys.add()
                if key in node:
                    self._repeated(node, key, at)
                else:
                    node.add(key, at, value, value_at)
            at = after
            if isinstance(value, (Map, Seq)):
                stack.append(node)
                if len(stack) >= DEPTH_LIMIT:
                    raise self._broken(value_at, f"nested deeper than {DEPTH_LIMIT}")
                node = value
                fresh = True

    def _next_member(self, node: Map | Seq, at: int) -> int:
        closing = "}" if isinstance(node, Map) else "]"
        if self.text[at : at + 1] != ",":
            raise self._broken(at, f'expected "," or "{closing}"')
        comma, at = at, self._skip(at + 1)
        if self.text[at : at + 1] == closing:
            raise self._broken(comma, f'remove the comma before "{closing}"')
        return at

    def _key(self, at: int) -> tuple[str, int]:
        """A key, and the offset of the value after the colon."""
        if simple := _SIMPLE_KEY(self.text, at):
            return simple[1], simple.end()
        if self.text[at : at + 1] != '"':
            raise self._broken(at, "expected a key in double quotes")
        key, at = self._string(at)
        at = self._skip(at)
        if self.text[at : at + 1] != ":":
            raise self._broken(at, f'expected ":" after key {quoted(key)}')
        return key, self._skip(at + 1)

    def _value(self, at: int) -> tuple[Any, int]:
        """A scalar, or an empty container that the caller must fill."""
        char = self.text[at : at + 1]
        if char == '"':
            return self._string(at)
        if char == "{":
            return Map(at), at + 1
        if char == "[":
            return Seq(at), at + 1
        if found := _WORD.match(self.text, at):
            return _WORDS[found[0]], found.end()
        if found := _NUMBER.match(self.text, at):
            return self._number(at, found), found.end()
        raise self._broken(at, "expected a value" if char else "the text ends too early")

    def _number(self, at: int, found: re.Match[str]) -> int | float:
        try:
            return scalars.number(found[0], "int" if found[1] is None and found[2] is None else "float")
        except ValueError as error:
            self.problems.append(self.source.problem(at, str(error)))
            return scalars.STAND_IN

    def _string(self, at: int) -> tuple[str, int]:
        try:
            value, end = _scan_string(self.text, at + 1, True)
        except json.JSONDecodeError as error:
            reason = error.msg.removesuffix(" at").removesuffix(" starting").lower()
            raise self._broken(error.pos, reason) from error
        if not is_unicode(value):
            raise self._broken(at, f"{quoted(value)} holds half a surrogate pair; write the character")
        return value, end

    def _repeated(self, node: Map, key: str, key_at: int) -> None:
        first = self.source.mark(node.places[key][0])
        message = f"key {quoted(key)} is repeated; it is already in line {first.line}"
        self.problems.append(self.source.problem(key_at, message))

    def _skip(self, at: int) -> int:
        found = _SPACE.match(self.text, at)
        return found.end() if found else at

    def _broken(self, at: int, what: str) -> UserError:
        return UserError(self.source.problem(at, f"this is not JSON: {what}"))
