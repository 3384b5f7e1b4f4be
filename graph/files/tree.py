"""Plain data with file positions: dicts and lists that hold the offsets of their parts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from graph.base import limits

Location = tuple[str | int, ...]


class KeyCount:
    """Counts the keys of a file's mappings as they are read."""

    def __init__(self, name: str) -> None:
        self._name, self._left = name, limits.most("file.keys")

    def add(self) -> None:
        """One more key. Raises OverLimit beyond the limit file.keys."""
        self._left -= 1
        if self._left < 0:
            raise limits.OverLimit(f"{self._name} has too many keys; {limits.allowed('file.keys')}")


class Map(dict[str, Any]):
    """A mapping with text keys in file order; `places` holds the offsets of each key and of its value."""

    __slots__ = ("at", "places")

    def __init__(self, at: int = 0) -> None:
        super().__init__()
        self.at = at
        self.places: dict[str, tuple[int, int]] = {}

    def add(self, key: str, key_at: int, value: Any, value_at: int) -> None:
        """Appends a new key."""
        self[key] = value
        self.places[key] = (key_at, value_at)


class Seq(list[Any]):
    """A list; `item_at` holds one offset for each item."""

    __slots__ = ("at", "item_at")

    def __init__(self, at: int = 0) -> None:
        super().__init__()
        self.at = at
        self.item_at: list[int] = []

    def add(self, value: Any, at: int) -> None:
        """Appends an item."""
        self.append(value)
        self.item_at.append(at)


def offset(root: Map, location: Sequence[str | int], *, key: bool = False) -> int:
    """The offset of the value at a location, or of its key with `key`.

    If a part is missing: the offset of its nearest parent.
    """
    node: Any = root
    at = root.at
    for part in location:
        if isinstance(node, Map) and part in node:
            at = node.places[str(part)][0 if key else 1]
            node = node[str(part)]
        elif isinstance(node, Seq) and isinstance(part, int) and part < len(node):
            at = node.item_at[part]
            node = node[part]
        else:
            break
    return at


def value_at(root: Any, location: Sequence[str | int]) -> Any:
    """The value at a location; None if a part of the path is missing."""
    for part in location:
        if isinstance(root, list) and isinstance(part, int) and part < len(root):
            root = root[part]
        elif isinstance(root, dict) and part in root:
            root = root[str(part)]
        else:
            return None
    return root


def without(node: Any, locations: Iterable[Location]) -> Any:
    """A copy of a tree without the values at some locations; a missing location removes its parent."""
    first: dict[str | int, list[Location]] = {}
    for location in locations:
        if location:
            first.setdefault(location[0], []).append(location[1:])

    def kept(key: str | int, value: Any) -> tuple[bool, Any]:
        tails = first.get(key)
        if tails is None:
            return True, value
        if any(not tail or not _has(value, tail[0]) for tail in tails):
            return False, None
        return True, without(value, tails)

    if isinstance(node, Map):
        mapping = Map(node.at)
        for key, value in node.items():
            keep, rest = kept(key, value)
            if keep:
                mapping.add(key, node.places[key][0], rest, node.places[key][1])
        return mapping
    if isinstance(node, Seq):
        sequence = Seq(node.at)
        for index, (value, at) in enumerate(zip(node, node.item_at, strict=True)):
            keep, rest = kept(index, value)
            if keep:
                sequence.add(rest, at)
        return sequence
    return node


def _has(node: Any, part: str | int) -> bool:
    if isinstance(node, Map):
        return part in node
    return isinstance(node, Seq) and isinstance(part, int) and part < len(node)
