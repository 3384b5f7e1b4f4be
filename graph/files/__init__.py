"""Graph files: YAML or JSON text to a validated `FileSpec`, every problem with its file, line and column.

The stages, one module each: bytes to text (`source`), text to a plain tree that knows its places (`yaml_text`,
`json_text`, `tree`), tree to validated models (`model`, `messages`), models to the specification (`build`).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .loading import Examined, examine, load, loads, parse_value
    from .schema import json_schema

__all__ = ["Examined", "examine", "json_schema", "load", "loads", "parse_value"]

_HOMES = {
    "Examined": "loading",
    "examine": "loading",
    "json_schema": "schema",
    "load": "loading",
    "loads": "loading",
    "parse_value": "loading",
}


def __getattr__(name: str) -> Any:
    # Lazy, so that `graph.files.scalars` (which the command line needs at once) does not load pydantic.
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value
