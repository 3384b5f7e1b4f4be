"""The order that a file had and USD does not keep: noted beside what it orders, followed when it is read back."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from .json_values import decoded

_T = TypeVar("_T")


def noted(names: Iterable[str]) -> str:
    """The note of an order; JSON, since USD's text does not bring every name back."""
    return json.dumps(list(names))


def in_noted_order(items: Iterable[_T], name_of: Callable[[_T], str], ours: Mapping[str, Any], key: str) -> list[_T]:
    """The items in the order that our data notes under a key; those without a note come last, in their own order."""
    listed = decoded(ours, key) if ours else None
    if not isinstance(listed, list):
        return list(items)
    rank = {str(name): position for position, name in enumerate(listed)}
    return sorted(items, key=lambda item: rank.get(name_of(item), len(rank)))
