"""Examines the text of USD layers as bytes before USD's parser sees it: size, nesting, composition.

Also removes values of attributes that are paths, which the text format accepts whatever the attribute's type is.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

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


_PATH_VALUE = re.compile(
    rb"^[ \t]*(?:custom[ \t]+)?(?:(?:uniform|varying)[ \t]+)?(?!(?:rel|prepend|append|delete|add|reorder)\b)"
    rb"[A-Za-z]\w*(?:\[\])?[ \t]+[\w:]+[ \t]*=[ \t]*<",
    re.MULTILINE,
)

_OTHER_SPACE = (b"=<", b"=\t", b"=  ")
"""Spaces before a path that USD itself never writes."""


def leave_out_path_values(layers: Iterable[Any], warn: Callable[[str, str, str], None]) -> None:
    """Removes such values from the open layers, with a warning `path-as-value` each; the files stay unchanged.

    Values of graphs and nodes are left to the reader of graphs.
    """
    for layer in layers:
        if _may_have_any(Path(layer.realPath)):
            _clean(layer, warn)


def _may_have_any(file: Path) -> bool:
    if file.suffix.lower() not in (".usd", ".usda"):
        return False
    data = layer_bytes(file)
    if data.startswith(BINARY):
        return False
    only_connections = data.count(b"= <") == data.count(b".connect = <") and not any(map(data.count, _OTHER_SPACE))
    if only_connections:  # as in large graphs; counting is much faster than the regular expression
        return False
    return _PATH_VALUE.search(data) is not None


def _clean(layer: Any, warn: Callable[[str, str, str], None]) -> None:
    from graph.sim.usd import Sdf

    found = []

    def visit(path: Any) -> None:
        spec = layer.GetAttributeAtPath(path) if path.IsPropertyPath() else None
        if spec is not None and isinstance(spec.default, Sdf.Path):
            found.append(spec)

    layer.Traverse("/", visit)
    for spec in found:
        if not spec.owner.typeName.startswith("OmniGraph"):
            text = f"its value is the path <{spec.default}>, not of type {spec.typeName}; it is left out"
            warn("path-as-value", f"{layer.identifier}: {spec.path}", text)
            spec.ClearDefaultValue()
