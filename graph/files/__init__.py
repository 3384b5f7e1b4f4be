"""Reads graph files: YAML or JSON text to a validated `FileSpec`; every problem has its file, line and column.

The stages, one module each: bytes to text (`source`), text to a plain tree with file positions (`yaml_text`,
`json_text`, `tree`), tree to validated models (`model`, `messages`), models to the specification (`build`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names

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

__getattr__, __dir__ = lazy_names(__name__, _HOMES)
