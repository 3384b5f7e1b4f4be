"""The text of a graph file, and line and column of an offset in it."""

from __future__ import annotations

import re
from bisect import bisect_right
from functools import cached_property
from pathlib import Path

from graph.base import limits
from graph.base.errors import Mark, Problem, UserError
from graph.base.inputs import start_of
from graph.base.suggest import did_you_mean

DEPTH_LIMIT = 100
"""Most mappings and lists inside one another."""

_USD_SUFFIXES = {".usd", ".usda", ".usdc", ".usdz"}
_SUFFIXES = {".yaml": "yaml", ".yml": "yaml", ".json": "json"}
_LINE_BREAK = re.compile("\r\n|\n|\r")
_NOT_TEXT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f]")
_OTHER_ENCODINGS = (
    (b"\xff\xfe\x00\x00", "UTF-32"),
    (b"\x00\x00\xfe\xff", "UTF-32"),
    (b"\xff\xfe", "UTF-16"),
    (b"\xfe\xff", "UTF-16"),
)


class Source:
    """A text with a name. Offsets count characters from 0; marks count lines and columns from 1."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.text = text

    @cached_property
    def _line_starts(self) -> list[int]:
        return [0, *(found.end() for found in _LINE_BREAK.finditer(self.text))]

    def mark(self, offset: int) -> Mark:
        """The mark of an offset."""
        starts = self._line_starts
        line = bisect_right(starts, offset)
        return Mark(self.name, line, offset - starts[line - 1] + 1)

    def problem(self, offset: int, message: str) -> Problem:
        """A problem at an offset."""
        return Problem(message, self.mark(offset))


def file_format(name: str) -> str | None:
    """The format that a file's extension means: "yaml" or "json"; None for any other extension."""
    return _SUFFIXES.get(Path(name).suffix.lower())


def is_usd(name: str) -> bool:
    """Whether a file's extension is that of USD."""
    return Path(name).suffix.lower() in _USD_SUFFIXES


def read(path: Path, name: str) -> Source:
    """Reads a graph file from disk. Raises UserError if it is not readable text or too large."""
    kind = file_format(path.name)
    try:
        if path.is_dir():
            raise UserError(f"{name} is a folder; name a graph file (.yaml, .json or .usda) in it")
        if not path.exists():
            if path.is_symlink():
                raise UserError(f"{name} is a link to a file that is not there; correct the link")
            raise UserError(f"{name}: no such file{_near(path)}")
        if kind is None:
            raise UserError(f"{name}: {_no_graph_file(path)}")
        if not path.is_file():
            raise UserError(f"{name} is not a regular file; a graph file is text on disk")
        data = start_of(path, limits.most(f"file.{kind}") + 1)
    except OSError as error:
        raise UserError(f"{name} cannot be read: {error.strerror or error}") from error
    return decode(data, name, kind)


def decode(data: bytes | str, name: str, kind: str) -> Source:
    """Bytes (UTF-8, with or without byte order mark) or text as a Source; raises UserError with the reason."""
    advice = "" if kind == "json" else ", or write it as JSON, which may be larger"
    limits.check(f"file.{kind}", len(data), f"{name} is too much {kind.upper()}{advice}")
    text = data if isinstance(data, str) else _decode_bytes(data, name)
    source = Source(name, text.removeprefix("\ufeff"))
    if not source.text.strip():
        raise UserError(source.problem(0, 'the file is empty; a graph file starts with "tickgraph: 1"'))
    if found := _NOT_TEXT.search(source.text):
        message = f"character U+{ord(found[0]):04X} is not allowed here; is this a text file?"
        raise UserError(source.problem(found.start(), message))
    return source


def _decode_bytes(data: bytes, name: str) -> str:
    for mark, encoding in _OTHER_ENCODINGS:
        if data.startswith(mark):
            raise UserError(Source(name, "").problem(0, f"this is {encoding} text; save it as UTF-8"))
    if b"\0" in data[:4096]:
        raise UserError(Source(name, "").problem(0, "this is a binary file; a graph file is YAML or JSON text"))
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        before = Source(name, data[: error.start].decode("utf-8"))
        message = f"byte 0x{data[error.start]:02X} is not UTF-8; save the file as UTF-8"
        raise UserError(before.problem(len(before.text), message)) from error


def _no_graph_file(path: Path) -> str:
    suffix = path.suffix.lower()
    for ending, key, said in ((".xml", "mjcf", "an MJCF model"), (".urdf", "urdf", "a URDF")):
        if suffix == ending:
            return f"this is not a graph file; name {said} in a graph file: scene: {{{key}: ...}}"
    if suffix == ".py":
        return "this is a script, which runs only if you ask for it: graph exec"
    return "a graph file ends in .yaml, .yml, .json, .usda, .usd or .usdc"


def _near(path: Path) -> str:
    """A "did you mean" with the closest existing name in the same folder, or how to write a shipped example, or ""."""
    try:
        if path.parent == Path("graphs") and not path.parent.exists():
            return f"; a shipped example is written by: graph new {path.stem} graphs"
        return did_you_mean(path.name, sorted(entry.name for entry in path.parent.iterdir()))
    except OSError:
        return ""
