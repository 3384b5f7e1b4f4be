"""Plain data in USD's dictionaries: natively where they hold it as it is, as JSON text where they do not."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from graph.values.equality import same

from .values import plain

KEYS = "keys"
"""Key, in the layer's own data, of the order that the file's keys had."""


def other_keys(document: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a graph file beside its graphs, for `customLayerData.tickgraph`.

    A key that USD cannot hold as it is, in its order, becomes `key:json`, a text; `KEYS` notes the order of all.
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
    """A list of texts as USD keeps it."""
    from graph.sim.usd import Vt

    return Vt.StringArray(list(values))


def survives(value: Any) -> bool:
    """Whether USD's text format brings every text in a value back: control characters and lone surrogates do not."""
    if isinstance(value, str):
        return all(c.isprintable() or c in "\n\t" for c in value)
    if isinstance(value, Mapping):
        return all(survives(key) and survives(item) for key, item in value.items())
    return not isinstance(value, list | tuple) or all(map(survives, value))


def _native(value: Any) -> Any:
    """The value as a dictionary of USD holds it; None where it cannot."""
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
