"""Line and column of prims and properties in the text of a USD layer.

USD drops line numbers when it parses. Our mark keeps the file and the path, and looks up line and column in the text
when they are needed: a file without mistakes is never scanned.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from functools import cached_property

from graph.base.errors import Mark
from graph.sim.scene.layer_text import BINARY, layer_bytes

_TOKEN = re.compile(
    r'''(?P<skip>"""(?:[^\\]|\\.)*?"""|\'\'\'(?:[^\\]|\\.)*?\'\'\'|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)*\''''
    r"""|@@@.*?@@@|@[^@\n]*@|\#[^\n]*|/\*.*?\*/|<[^>\n]*>)"""
    r"""|(?P<prim>\b(?:def|over|class)\b\s+(?:[\w:]+\s+)?"(?P<name>[^"\n]*)")"""
    r"""|(?P<open>[{(\[])|(?P<close>[})\]])"""
    r"""|^[ \t]*(?:(?:custom|uniform|varying|config|prepend|append|delete|add|reorder)[ \t]+)*"""
    r"""(?!(?:def|over|class)\b)[^\W\d]\w*(?:\[\])?[ \t]+(?P<property>[^\W\d][\w:]*)"""
    r"""(?P<connect>\.connect)?(?=[ \t.=(\r\n;]|$)""",
    re.DOTALL | re.MULTILINE,
)


class Text:
    """The places of one layer file; its text is read when the first place is needed."""

    def __init__(self, path: str, name: str) -> None:
        self.path = path
        self.name = name
        """The file name for messages."""

    def line_and_column(self, path: str) -> tuple[int, int]:
        """The place of `path` (of a prim, of a property, or with `.connect` behind it of the property's connection).

        For a missing path, the place of the nearest parent; (0, 0) in a file without text.
        """
        places = self._places
        while path not in places:
            if path.endswith(".connect"):
                path = path.removesuffix(".connect")
            elif "." in path:
                path = path.rpartition(".")[0]
            else:
                path = path.rpartition("/")[0]
                if not path:
                    return (1, 1) if places else (0, 0)
        offset = places[path]
        line = bisect_right(self._lines, offset)
        return line, offset - self._lines[line - 1] + 1

    @cached_property
    def _text(self) -> str:
        try:
            data = layer_bytes(self.path)
        except OSError:
            return ""
        return "" if data.startswith(BINARY) else data.decode("utf-8", "replace")

    @cached_property
    def _lines(self) -> list[int]:
        return [0, *(found.end() for found in re.finditer("\r\n|\n|\r", self._text))]

    @cached_property
    def _places(self) -> dict[str, int]:
        return dict(reversed([*_places(self._text)]))  # the first of two statements counts


def _places(text: str) -> Iterator[tuple[str, int]]:
    stack: list[tuple[str, str]] = [("{", "")]
    pending = ""
    for token in _TOKEN.finditer(text):
        bracket, path = stack[-1]
        if token["skip"] is not None:
            continue
        if token["open"]:
            # Braces below a prim are its children, properties and variants; those in metadata are dictionaries.
            kind = token["open"] if bracket == "{" else "("
            stack.append((kind, (pending or path) if kind == "{" else path))
            if kind == "{":
                pending = ""
        elif token["close"]:
            if len(stack) > 1:
                stack.pop()
        elif token["prim"]:
            if bracket == "{":
                pending = f"{path}/{token['name']}"
                yield pending, token.start("prim")
        elif token["property"] and bracket == "{" and path:
            yield f"{path}.{token['property']}{token['connect'] or ''}", token.start("property")


class PlacedMark(Mark):
    """A mark that looks up its line and column when they are needed."""

    __slots__ = ("_found", "_path", "_text")
    _text: Text
    _path: str
    _found: Mark | None

    __setattr__ = (
        object.__setattr__
    )  # not frozen like other marks, because there are hundreds of thousands and each looks itself up

    def __init__(self, text: Text, path: str) -> None:
        self._text = text
        self._path = path
        self._found = None

    @property
    def file(self) -> str:
        """The file's name, followed by the path if the file has no lines."""
        return self._place().file

    @property
    def line(self) -> int:
        """The line, from 1; 0 if the file has no lines."""
        return self._place().line

    @property
    def column(self) -> int:
        """The column, from 1; 0 if the file has no lines."""
        return self._place().column

    def _place(self) -> Mark:
        if self._found is None:
            line, column = self._text.line_and_column(self._path)
            name = self._text.name if line else f"{self._text.name}<{self._path.removesuffix('.connect')}>"
            self._found = Mark(name, line, column)
        return self._found

    def _key(self) -> tuple[str, int, int]:
        return self.file, self.line, self.column

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mark) and self._key() == (other.file, other.line, other.column)

    def __hash__(self) -> int:
        return hash(self._key())

    def __lt__(self, other: Mark) -> bool:
        return self._key() < (other.file, other.line, other.column)

    def __gt__(self, other: Mark) -> bool:
        return self._key() > (other.file, other.line, other.column)

    def __le__(self, other: Mark) -> bool:
        return self._key() <= (other.file, other.line, other.column)

    def __ge__(self, other: Mark) -> bool:
        return self._key() >= (other.file, other.line, other.column)

    def __repr__(self) -> str:
        return f"<mark {self}>"
