"""Prims by paths that users wrote: with an invalid path, USD would print about its own source code."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pxr import Usd


@lru_cache(maxsize=1024)
def is_prim_path(path: str) -> bool:
    """Whether a text could be the absolute path of a prim."""
    from graph.sim.usd import Sdf

    return path.startswith("/") and bool(Sdf.Path.IsValidPathString(path)) and Sdf.Path(path).IsAbsoluteRootOrPrimPath()


def prim_at(stage: Usd.Stage, path: str) -> Usd.Prim:
    """The prim with that path; an invalid (falsy) prim for a missing or malformed path."""
    from graph.sim.usd import Usd

    return stage.GetPrimAtPath(path) if is_prim_path(path) else Usd.Prim()
