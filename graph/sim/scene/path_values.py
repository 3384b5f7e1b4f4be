"""Attributes whose value in a text layer is a path: USD reads it whatever the attribute's type is."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from .layer_text import BINARY, layer_bytes

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
