"""Examines the text of USD layers as bytes before USD's parser sees it: size, nesting, composition."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from graph.base.inputs import opened, start_of
from graph.base.limits import most

MAX_NESTING = 256
"""Brackets that may be open at once in a text layer."""
_SHALLOW = 100
"""A file with fewer brackets cannot nest too deeply, whatever its limit."""

_OPAQUE = re.compile(
    rb'"""(?:[^\\]|\\.)*?"""|\'\'\'(?:[^\\]|\\.)*?\'\'\'|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)*\''
    rb"|@@@.*?@@@|@[^@\n]*@|#[^\n]*|/\*.*?\*/|//[^\n]*",
    re.DOTALL,
)
_RARE = (b"#", b"'", b"@", b"\\", b"//", b"/*", b'"""')
"""Starts of comments, paths and long strings, which few texts have.

In a text without them, a string is what stands between two quotes on a line.
"""
_SHORT_STRING = re.compile(rb'"[^"\n]*"')
_MEANINGLESS = bytes(set(range(256)) - set(b'"\n{}()[]'))
_DEFINING = (b"def ", b"over ", b"class ")
_COMPOSING = (b"subLayers", b"references", b"payload", b"inherits", b"specializes", b"clips")
"""How the text format writes arcs and value clips."""
BINARY = (b"PXR-USDC", b"PK\x03\x04")
SCENE_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")


def layer_bytes(path: str | Path) -> bytes:
    """The bytes of a text layer, up to one more than the limit; the first bytes of a binary one or a package."""
    with opened(path) as stream:
        data = stream.read(8)
        return data if data.startswith(BINARY) else data + stream.read(most("usd.text") + 1 - len(data))


def longest_text(path: Path) -> int:
    """Bytes of the file if it is text, or of the largest text layer in a package as the package states; else 0."""
    start = start_of(path, 8)
    if not start.startswith(BINARY):
        return path.stat().st_size
    if start.startswith(b"PXR-USDC"):
        return 0
    with zipfile.ZipFile(path) as package:
        return max((entry.file_size for entry in package.infolist() if _is_text(package, entry)), default=0)


def _is_text(package: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bool:
    if not entry.filename.lower().endswith(SCENE_SUFFIXES):
        return False
    with package.open(entry) as stream:
        return not stream.read(8).startswith(BINARY)


def _text_layers(path: Path) -> Iterator[bytes]:
    """The bytes of the file if it is text, or of every text layer in a package."""
    data = layer_bytes(path)
    if data.startswith(b"PXR-USDC"):
        return
    if not data.startswith(BINARY):
        yield data
        return
    with zipfile.ZipFile(path) as package:
        for entry in package.infolist():
            if _is_text(package, entry):
                yield package.read(entry)


def depth(path: Path) -> int:
    """The nesting of a text layer or package (see `nesting`); 0 for a binary layer."""
    return _measured(path)[0]


def written_prims(path: Path) -> int:
    """The approximate number of prims that a text layer or package defines, by its keywords; 0 for a binary layer."""
    return _measured(path)[1]


def _measured(path: Path) -> tuple[int, int]:
    about = path.stat()
    return _measure(path, about.st_size, about.st_mtime_ns)


@lru_cache(maxsize=64)
def _measure(path: Path, size: int, modified: int) -> tuple[int, int]:
    # Size and modification time are only used to detect another file.
    deepest, prims = 0, 0
    for data in _text_layers(path):
        deepest = max(deepest, nesting(data))
        prims += sum(map(data.count, _DEFINING))
    return deepest, prims


def nesting(data: bytes) -> int:
    """The largest number of open brackets of any kind; strings, comments and asset paths do not count."""
    import numpy as np

    if sum(map(data.count, (b"{", b"(", b"["))) <= _SHALLOW:
        return 0
    steps = np.zeros(256, np.int8)
    steps[list(b"{([")] = 1
    steps[list(b"})]")] = -1
    letters = np.frombuffer(_without_opaque(data), np.uint8)
    marks = steps[letters]
    return int(np.cumsum(marks[marks != 0], dtype=np.int64).max(initial=0))


def _without_opaque(data: bytes) -> bytes:
    """The text without strings, comments and asset paths; for a text with only short strings, only its brackets."""
    if data.startswith(b"#"):
        data = data.partition(b"\n")[2]
    if any(mark in data for mark in _RARE):
        return _OPAQUE.sub(b" ", data)
    return _SHORT_STRING.sub(b"", data.translate(None, _MEANINGLESS))


def may_compose(path: Path) -> bool:
    """Whether a layer may compose other layers: a text layer without any of the keywords cannot."""
    data = layer_bytes(path)
    return data.startswith(BINARY) or any(word in data for word in _COMPOSING)
