"""The module `omni.graph.core`, which OmniGraph's Python imports as `og`: as much of it as a node's own code needs."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

NAME = "omni.graph.core"
KIT = ("carb", "isaacsim", "omni")
"""Top packages that only Kit has."""


class ExecutionAttributeState(IntEnum):
    """What may be assigned to an execution output; only the enabled ones are followed."""

    DISABLED = 0
    ENABLED = 1
    ENABLED_AND_PUSH = 2


class _StandIn(ModuleType):
    """Has what `graph.controller` has, under the same names; that is imported when it is used."""

    ExecutionAttributeState = ExecutionAttributeState

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_"):
            controller = import_module("graph.controller")
            if name in controller.__all__:
                return getattr(controller, name)
            names = ", ".join(("ExecutionAttributeState", *controller.__all__))
            raise AttributeError(f"TickGraph has no {NAME}.{name}; of that module it has {names}")
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


OG = _StandIn(NAME, __doc__)
"""The stand-in for `omni.graph.core`; scripts find it as `og`."""


@contextmanager
def importable() -> Iterator[None]:
    """Lets the code within say `import omni.graph.core as og`; not longer, so that nobody takes this process for Kit.

    Where the real module is installed, that is what it gets.
    """
    absent = _absent()
    try:
        sys.modules.update(absent)
        yield
    finally:
        for name, module in absent.items():
            if sys.modules.get(name) is module:
                del sys.modules[name]


@cache
def _absent() -> dict[str, ModuleType]:
    """Stand-ins for the module and the packages around it, by name: none for those that are installed."""
    made: dict[str, ModuleType] = {}
    parent: ModuleType | None = None
    for name in ("omni", "omni.graph", NAME):
        try:
            module = import_module(name)
        except ImportError:
            module = made[name] = OG if name == NAME else ModuleType(name)
            if name != NAME:
                module.__path__ = []
            if parent is not None:
                setattr(parent, name.rpartition(".")[2], module)
        parent = module
    return made


def advice(error: ImportError) -> str:
    """What to do about a module of Kit's that is not there, as the tail of a message; "" for any other module."""
    if (error.name or "").partition(".")[0] not in KIT:
        return ""
    if f"{NAME}.".startswith(f"{error.name}."):
        return f"; import {NAME} at the top of the module, not while it computes"
    return f"; of Kit's modules TickGraph has only {NAME}: do without it, or catch the error"
