"""Lets references and payloads that scripts add with `pxr` lead to assets by their addresses."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from graph.isaac.session import app_or_none
from graph.sim.usd import Usd

Find = Callable[[str, str], str]
"""Gives the file or layer of an asset by its address, and the path of the prim that wants it; "" if it is not here."""


def take_addresses(find: Find) -> None:
    """Lets `AddReference` and `AddPayload` of USD find remote assets by this function."""
    for owner, name in ((Usd.References, "AddReference"), (Usd.Payloads, "AddPayload")):
        usual = getattr(owner, name)
        if not hasattr(usual, "__wrapped__"):
            setattr(owner, name, _taking(usual, find))


def _taking(usual: Any, find: Find) -> Any:
    def here(address: str, arcs: Any) -> str:
        remote = "://" in address and app_or_none() is not None
        return (find(address, str(arcs.GetPrim().GetPath())) if remote else "") or address

    @wraps(usual)
    def call(self: Any, *given: Any, **named: Any) -> Any:
        if given and isinstance(given[0], str):
            given = (here(given[0], self), *given[1:])
        elif given and "://" in str(getattr(given[0], "assetPath", "")):
            arc = given[0]
            given = (type(arc)(here(arc.assetPath, self), arc.primPath, arc.layerOffset), *given[1:])
        elif "assetPath" in named:
            named["assetPath"] = here(str(named["assetPath"]), self)
        return usual(self, *given, **named)

    return call
