"""Records the order of a file, which USD does not keep, and restores it when the file is read."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from .json_values import decoded

_T = TypeVar("_T")


def noted(names: Iterable[str]) -> str:
    """The record of an order, as JSON, since USD's text cannot hold every name."""
    return json.dumps(list(names))


def in_noted_order(items: Iterable[_T], name_of: Callable[[_T], str], ours: Mapping[str, Any], key: str) -> list[_T]:
    """The items in the recorded order under a key; items that are not recorded come last, in their own order."""
    listed = decoded(ours, key) if ours else None
    if not isinstance(listed, list):
        return list(items)
    rank = {str(name): position for position, name in enumerate(listed)}
    return sorted(items, key=lambda item: rank.get(name_of(item), len(rank)))
