"""Prims by paths that users wrote: with an invalid path, USD would print about its own source code."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from graph.base.suggest import closest

from .assets import missing_above

if TYPE_CHECKING:
    from pxr import Usd


NAME_OVERRIDE = "isaac:nameOverride"
"""Attribute of a prim with its name in messages, where that differs from its name on the stage."""


@lru_cache(maxsize=1024)
def is_prim_path(path: str) -> bool:
    """Whether a text could be the absolute path of a prim."""
    from graph.sim.usd import Sdf

    return path.startswith("/") and is_path(path) and Sdf.Path(path).IsAbsoluteRootOrPrimPath()


def is_path(text: str) -> bool:
    """Whether a text is a path of USD, of a prim or a property, absolute or relative."""
    from graph.sim.usd import Sdf

    try:
        return bool(Sdf.Path.IsValidPathString(text))
    except UnicodeEncodeError:  # half a surrogate pair, which UTF-8 does not have
        return False


def prim_at(stage: Usd.Stage, path: str) -> Usd.Prim:
    """The prim with that path; an invalid (falsy) prim for a missing or malformed path."""
    from graph.sim.usd import Usd

    return stage.GetPrimAtPath(path) if is_prim_path(path) else Usd.Prim()


def near_prim(stage: Usd.Stage, path: str) -> str:
    """What to do about the path of a missing prim: the asset that should have it, else the most similar path."""
    if is_path(path) and (missing := missing_above(stage, path)):
        return f": {missing}"
    parent = stage.GetPseudoRoot()
    for name in path.strip("/").split("/"):
        children = {one.GetName(): one for one in parent.GetChildren()}
        child = children.get(name)  # USD warns of a malformed name
        if child is None:
            near = closest(name, children)
            if near is None:
                break
            above = str(parent.GetPath()).rstrip("/")
            wrong, right = (f"{above}/{one}" for one in (name, near))
            return f'; did you mean "{path.replace(wrong, right, 1)}"?'
        parent = child
    return "; correct the path"
