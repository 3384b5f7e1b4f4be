"""Plain data in USD's dictionaries: natively if they can hold it unchanged, else as JSON text."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from graph.values.equality import same

from .values import plain

KEYS = "keys"
"""Key, in the layer's own data, of the original order of the file's keys."""


def other_keys(document: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a graph file other than its graphs, for `customLayerData.tickgraph`.

    A value that USD cannot hold unchanged, in its order, is stored as the text `key:json`; `KEYS` records the order of
    all keys.
    """
    kept: dict[str, Any] = {KEYS: texts(list(document))}
    for key, value in document.items():
        if key in ("tickgraph", "graphs"):
            continue
        native = _native(value)
        if native is not None and same(plain(native), value):
            kept[key] = native
        else:
            kept[f"{key}:json"] = json.dumps(value)
    return kept


def texts(values: Sequence[str]) -> Any:
    """A list of texts in USD's form."""
    from graph.sim.usd import Vt

    return Vt.StringArray(list(values))


def survives(value: Any) -> bool:
    """Whether every text in a value survives USD's text format; control characters and lone surrogates do not."""
    if isinstance(value, str):
        return all(c.isprintable() or c in "\n\t" for c in value)
    if isinstance(value, Mapping):
        return all(survives(key) and survives(item) for key, item in value.items())
    return not isinstance(value, list | tuple) or all(map(survives, value))


def _native(value: Any) -> Any:
    """The value as a USD dictionary holds it, or None."""
    if not survives(value):
        return None
    if isinstance(value, bool | str | float):
        return value
    if isinstance(value, int):
        return value if -(2**31) <= value < 2**31 else None
    if isinstance(value, Mapping):
        inner = {str(key): _native(value[key]) for key in sorted(value)}  # in USD's order
        fits = all(item is not None for item in inner.values()) and all(inner) and len(inner) > 0
        return inner if fits else None
    return None
