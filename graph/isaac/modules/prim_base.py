"""`Prim` of `isaacsim.core.experimental.prims`, and what is common to wrappers of prims."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from graph.isaac.results import Result, numbers, result, rows
from graph.sim.usd import Sdf

from .prim_utils import find_matching_prim_paths
from .stage import usd_stage


class Defaults:
    """The values to which wrapped prims are reset, by name: NaN in the rows of prims without one."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._held: dict[str, np.ndarray] = {}

    def set(self, name: str, values: Any, width: int, indices: Any = None) -> None:
        """Keeps a row for each of the chosen prims; None changes nothing."""
        if values is not None:
            chosen = numbers(indices, self._count)
            held = self._held.setdefault(name, np.full((self._count, width), np.nan))
            held[chosen] = rows(values, len(chosen), width, name)

    def get(self, name: str, indices: Any = None) -> Result | None:
        """(N, width) of the chosen prims; None if nothing was ever kept."""
        held = self._held.get(name)
        return None if held is None else result(held[numbers(indices, self._count)])

    def apply(self, name: str, put: Callable[..., None]) -> None:
        """Calls `put(rows, indices=...)` with what is kept."""
        held = self._held.get(name)
        if held is not None and (chosen := np.flatnonzero(np.isfinite(held).all(axis=1)).tolist()):
            put(held[chosen], indices=chosen)


class Prim:
    """One prim or several, by paths or by regular expressions for each part of a path."""

    def __init__(self, paths: Any, *, resolve_paths: bool = True) -> None:
        listed = [paths] if isinstance(paths, str) else [str(one) for one in paths]
        self.paths = found_or_new(listed) if resolve_paths else listed
        stage = usd_stage()
        self.prims = [stage.GetPrimAtPath(path) for path in self.paths]
        if missing := [path for path, prim in zip(self.paths, self.prims, strict=True) if not prim]:
            raise ValueError(f"there is no prim {missing[0]}")
        self._defaults = Defaults(len(self.paths))

    @staticmethod
    def resolve_paths(paths: Any, raise_on_mixed_paths: bool = True) -> tuple[list[str], list[str]]:
        existing: list[str] = []
        new: list[str] = []
        stage = usd_stage()
        for path in [paths] if isinstance(paths, str) else paths:
            if not path.startswith("/"):
                raise ValueError(f"{path} is not the path of a prim; it begins with /")
            found = [path] if Sdf.Path.IsValidPathString(path) and stage.GetPrimAtPath(path) else []
            if not found and any(letter in path for letter in ".*[](|)+?"):
                found = find_matching_prim_paths(path)
                if not found:
                    raise ValueError(f"no prim matches {path}, and a prim cannot be named so")
            (existing if found else new).extend(found or [path])
        if existing and new and raise_on_mixed_paths:
            raise ValueError(f"some prims exist ({existing[0]}), others do not ({new[0]})")
        return existing, new

    def __len__(self) -> int:
        return len(self.paths)

    @property
    def valid(self) -> bool:
        return all(prim.IsValid() for prim in self.prims)

    @staticmethod
    def ensure_api(prims: Any, api: Any, *args: Any, **kwargs: Any) -> list[Any]:
        return [api(prim, *args) if prim.HasAPI(api, *args) else api.Apply(prim, *args) for prim in prims]


def found_or_new(paths: Any) -> list[str]:
    """The paths of existing prims, or of those to make. Raises ValueError for a mix of both."""
    existing, new = Prim.resolve_paths(paths)
    return existing or new


def define(paths: Any, kind: str) -> list[str]:
    """Defines missing prims of a type. Raises AssertionError for an existing prim of another."""
    stage = usd_stage()
    found = found_or_new([paths] if isinstance(paths, str) else list(paths))
    for path in found:
        if not Sdf.Path.IsValidPathString(path):
            raise ValueError(f"no prim matches {path}, and a prim cannot be named so")
        prim = stage.GetPrimAtPath(path)
        if prim and prim.GetTypeName() != kind and prim.GetTypeName():
            raise AssertionError(f"{path} is a {prim.GetTypeName()}, not a {kind}")
        if not prim or not prim.GetTypeName():
            stage.DefinePrim(path, kind)
    return found


def prims_of(paths: Any) -> list[Any]:
    """The prims of one path or prim, or of a list of these."""
    listed = paths if isinstance(paths, (list, tuple)) else [paths]
    return [usd_stage().GetPrimAtPath(one) if isinstance(one, str) else one for one in listed]


def attribute(prim: Any, name: str, kind: str, value: Any) -> None:
    """Authors an attribute."""
    prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(kind), custom=False).Set(value)
