"""Parses the text of an MJCF file to a tree of elements with file positions.

A model may be untrusted: the file is read here first, with the standard library's parser and without declarations, and
MuJoCo gets the result. Like MuJoCo, and unlike XML, it accepts `--` and anything else in comments.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from xml.parsers import expat

from graph.base.errors import Mark, Problem, UserError
from graph.base.inputs import start_of
from graph.base.records import dataclass, field

MAX_TEXT = 64 * 2**20
"""Bytes of one XML file."""
MAX_DEPTH = 256
"""Most elements that may be open at once."""

_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_HEAD = re.compile(rb"\A(?:\xef\xbb\xbf)?\s*(?:<\?xml[^>]*\?>)?")
_NOT_NEWLINE = re.compile(rb"[^\n]")


@dataclass(slots=True)
class Element:
    """An element: its tag, attributes in order, children, and place in its file."""

    tag: str
    attributes: dict[str, str]
    mark: Mark
    children: list[Element] = field(default_factory=list)

    def get(self, name: str) -> str | None:
        """An attribute's value, if it exists and is not empty."""
        return self.attributes.get(name) or None

    def walk(self) -> Iterator[Element]:
        """The element and all below it, in the order of the file."""
        yield self
        for child in self.children:
            yield from child.walk()


def parse(file: Path, name: str) -> Element:
    """The root element of a file, called `name` in messages. Raises UserError, with the place, if it is not XML."""
    try:
        data = start_of(file, MAX_TEXT + 1)
    except OSError as error:
        raise UserError(f"{name} cannot be read: {error.strerror or error}") from error
    if len(data) > MAX_TEXT:
        raise UserError(f"{name} is larger than {MAX_TEXT >> 20} MiB; as a model that is too much text")
    for hidden in (_COMMENT, _HEAD):
        data = hidden.sub(lambda found: _NOT_NEWLINE.sub(b" ", found.group()), data)
    return _Builder(name).build(data)


class _Builder:
    def __init__(self, name: str) -> None:
        self.name = name
        self.root: Element | None = None
        self.open: list[Element] = []

    def build(self, data: bytes) -> Element:
        try:
            data.decode()
            encoding = "UTF-8"
        except UnicodeDecodeError:
            encoding = "ISO-8859-1"
        self.parser = parser = expat.ParserCreate(encoding)
        parser.ordered_attributes = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = lambda tag: self.open.pop()
        parser.StartDoctypeDeclHandler = self._doctype
        try:
            parser.Parse(data, True)
        except expat.ExpatError as error:
            place = Mark(self.name, error.lineno, error.offset + 1)
            raise UserError(Problem(f"this is not XML: {expat.ErrorString(error.code)}", place)) from error
        assert self.root is not None
        return self.root

    def _mark(self) -> Mark:
        return Mark(self.name, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)

    def _start(self, tag: str, attributes: list[str]) -> None:
        element = Element(tag, dict(zip(attributes[::2], attributes[1::2], strict=True)), self._mark())
        if len(self.open) >= MAX_DEPTH:
            raise UserError(Problem(f"elements nest deeper than {MAX_DEPTH} levels", element.mark))
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def _doctype(self, *declaration: object) -> None:
        raise UserError(Problem("a model has no DOCTYPE and declares no entities; remove it", self._mark()))
