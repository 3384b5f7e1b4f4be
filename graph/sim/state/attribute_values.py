"""Attribute values of prims by name that are not on the stage."""

from __future__ import annotations

from typing import Any, Protocol

from graph.sim.scene.prim_paths import is_path


class Live(Protocol):
    """An attribute that physics owns: reads its present value at a path (None: not there) and writes it."""

    def read(self, path: str) -> Any:
        """The present value."""

    def write(self, path: str, value: Any) -> None:
        """Applies a value that a user sets."""


class AttributeValues:
    """Values that were set, by path and name; all others are read from the stage."""

    def __init__(self, stage: Any) -> None:
        self._stage = stage
        self._set: dict[tuple[str, str], tuple[Any, int]] = {}
        self.live: dict[str, Live] = {}
        """Attributes, by name, whose values physics owns; if it returns None, the set value counts."""

    def get(self, path: str, attribute: str) -> Any:
        """The present value: from physics, else as set, else from the stage; None if there is no value."""
        if attribute in self.live and (value := self.live[attribute].read(path)) is not None:
            return value
        entry = self._set.get((path, attribute))
        if entry is not None:
            return entry[0]
        if self.stage_has(path, attribute):
            return self._stage.GetAttributeAtPath(f"{path}.{attribute}").Get()
        return None

    def set(self, path: str, attribute: str, value: Any) -> None:
        """Sets an attribute; the stage is not changed, and the prim need not be on it."""
        if attribute in self.live:
            self.live[attribute].write(path, value)
        previous = self._set.get((path, attribute))
        self._set[path, attribute] = (value, 0 if previous is None else previous[1] + 1)

    def has(self, path: str, attribute: str) -> bool:
        """Whether an attribute was set."""
        return (path, attribute) in self._set

    def has_prim(self, path: str) -> bool:
        """Whether the stage has a prim, or an attribute of it was set."""
        return bool(self.prim(path)) or any(key[0] == path for key in self._set)

    def stage_has(self, path: str, attribute: str) -> bool:
        """Whether the stage has an attribute of a prim."""
        prim = self.prim(path)
        return bool(prim and prim.HasAttribute(attribute))

    def prim(self, path: str) -> Any:
        """The stage's prim; None for an invalid path, an invalid prim (falsy) for a missing one."""

        valid = path.startswith("/") and path != "/" and is_path(path)
        return self._stage.GetPrimAtPath(path) if valid else None

    def change_stamp(self, path: str, attribute: str) -> int:
        """How often an attribute has been set since its first value; -1 if never."""
        entry = self._set.get((path, attribute))
        return -1 if entry is None else entry[1]

    def take(self, other: AttributeValues) -> None:
        """Takes over all attributes that were set."""
        self._set.update(other._set)
        self.live.update(other.live)

    def forget(self) -> None:
        """Drops values that were set on prims of the stage; others stay."""
        self._set = {key: entry for key, entry in self._set.items() if not self._stage.GetPrimAtPath(key[0])}
