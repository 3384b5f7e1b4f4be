"""Attributes of prims by name, beside the stage."""

from __future__ import annotations

from typing import Any, Protocol


class Live(Protocol):
    """An attribute that the physics has: what it is now at a path (None: it has none there), and what to do with it."""

    def read(self, path: str) -> Any:
        """The value of now."""

    def write(self, path: str, value: Any) -> None:
        """Take a value that somebody sets."""


class AttributeValues:
    """Values that somebody has set, by path and name; what nobody has set is read from the stage."""

    def __init__(self, stage: Any) -> None:
        self._stage = stage
        self._set: dict[tuple[str, str], tuple[Any, int]] = {}
        self.live: dict[str, Live] = {}
        """Attributes, by name, whose values the physics has and takes; None of one leaves them to what was set."""

    def get(self, path: str, attribute: str) -> Any:
        """The value of now: what physics has, what was set, what the stage says; None where there is none."""
        if attribute in self.live and (value := self.live[attribute].read(path)) is not None:
            return value
        entry = self._set.get((path, attribute))
        if entry is not None:
            return entry[0]
        if self.stage_has(path, attribute):
            return self._stage.GetAttributeAtPath(f"{path}.{attribute}").Get()
        return None

    def set(self, path: str, attribute: str, value: Any) -> None:
        """Set an attribute; the stage is not touched, and the prim need not be on it."""
        if attribute in self.live:
            self.live[attribute].write(path, value)
        previous = self._set.get((path, attribute))
        self._set[path, attribute] = (value, 0 if previous is None else previous[1] + 1)

    def has(self, path: str, attribute: str) -> bool:
        """Whether somebody has set an attribute."""
        return (path, attribute) in self._set

    def has_prim(self, path: str) -> bool:
        """Whether the stage has a prim, or somebody has set an attribute of it."""
        return bool(self.prim(path)) or any(key[0] == path for key in self._set)

    def stage_has(self, path: str, attribute: str) -> bool:
        """Whether the stage has an attribute of a prim."""
        prim = self.prim(path)
        return bool(prim and prim.HasAttribute(attribute))

    def prim(self, path: str) -> Any:
        """The stage's prim; None for what cannot be a prim's path, an invalid prim (false) where there is none."""
        from graph.sim.usd import Sdf

        valid = path.startswith("/") and path != "/" and Sdf.Path.IsValidPathString(path)
        return self._stage.GetPrimAtPath(path) if valid else None

    def change_stamp(self, path: str, attribute: str) -> int:
        """How often an attribute has been set since its first value; -1 if never."""
        entry = self._set.get((path, attribute))
        return -1 if entry is None else entry[1]

    def take(self, other: AttributeValues) -> None:
        """Take over all attributes that somebody has set."""
        self._set.update(other._set)
        self.live.update(other.live)

    def forget(self) -> None:
        """Forget what was set on prims of the stage; what stands on no prim stays."""
        self._set = {key: entry for key, entry in self._set.items() if not self._stage.GetPrimAtPath(key[0])}
