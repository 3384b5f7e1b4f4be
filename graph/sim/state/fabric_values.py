"""Attributes of prims by name, beside the stage."""

from __future__ import annotations

from typing import Any, Protocol

from graph.sim.scene.stage import Warn, ignore_warning


class Live(Protocol):
    """An attribute that the physics has: what it is now at a path (None: it has none there), and what to do with it."""

    def read(self, path: str) -> Any:
        """The value of now."""

    def write(self, path: str, value: Any) -> None:
        """Take a value that somebody sets."""


class FabricValues:
    """Values that somebody has set, by path and name; what nobody has set is read from the stage."""

    def __init__(self, stage: Any, warn: Warn = ignore_warning) -> None:
        self.stage = stage
        self.warn = warn
        self._values: dict[tuple[str, str], tuple[Any, int]] = {}
        self.live: dict[str, Live] = {}
        """Attributes, by name, whose values the physics has and takes; None of one leaves them to Fabric."""

    def get(self, path: str, attribute: str, default: Any = None) -> Any:
        """An attribute's value in Fabric; where nobody has set one, the stage's; else `default`."""
        value = self.get_raw(path, attribute)
        if attribute.startswith("xformOp") and (path, attribute) not in self._values:
            cause = self.outdated_on_stage(path)
            if cause is not None:
                self.warn("fabric-stale-transform", f"{path}.{attribute}", cause)
        return default if value is None else value

    def get_raw(self, path: str, attribute: str) -> Any:
        """As `get`, without a word where the value is out of date; None where there is none."""
        if attribute in self.live and (value := self.live[attribute].read(path)) is not None:
            return value
        entry = self._values.get((path, attribute))
        if entry is not None:
            return entry[0]
        return self.stage.GetAttributeAtPath(f"{path}.{attribute}").Get() if self.stage_has(path, attribute) else None

    def stage_has(self, path: str, attribute: str) -> bool:
        """Whether the stage has an attribute of a prim."""
        prim = self._prim(path)
        return bool(prim and prim.HasAttribute(attribute))

    def has_prim(self, path: str) -> bool:
        """Whether the stage has a prim, or Fabric a value of it."""
        return bool(self._prim(path)) or any(key[0] == path for key in self._values)

    def has_place(self, path: str) -> bool:
        """Whether the stage has a prim, so that it stands somewhere."""
        return bool(self._prim(path))

    def resets(self, path: str) -> bool:
        """Whether a prim's transform does not count from its parent."""
        from graph.sim.usd import UsdGeom

        xformable = UsdGeom.Xformable(self._prim(path))
        return bool(xformable and xformable.GetResetXformStack())

    def _prim(self, path: str) -> Any:
        from graph.sim.usd import Sdf

        valid = path.startswith("/") and path != "/" and Sdf.Path.IsValidPathString(path)
        return self.stage.GetPrimAtPath(path) if valid else None

    def set(self, path: str, attribute: str, value: Any) -> None:
        """Set an attribute in Fabric; the stage is not touched, and the prim need not be on it."""
        if attribute in self.live:
            self.live[attribute].write(path, value)
        previous = self._values.get((path, attribute))
        self._values[path, attribute] = (value, 0 if previous is None else previous[1] + 1)

    def take_values(self, other: FabricValues) -> None:
        """Take over all attributes that somebody has set."""
        self._values.update(other._values)
        self.live.update(other.live)

    def change_stamp(self, path: str, attribute: str) -> int:
        """How often an attribute has been set since its first value; -1 if never."""
        entry = self._values.get((path, attribute))
        return -1 if entry is None else entry[1]

    def outdated_on_stage(self, path: str) -> str | None:
        """Why the transform that the stage holds of a prim is not where it is now; None if it is."""
        return None

    def _forget_values(self) -> None:
        """Forget what was set on prims of the stage; what stands on no prim stays."""
        self._values = {key: entry for key, entry in self._values.items() if not self.stage.GetPrimAtPath(key[0])}
