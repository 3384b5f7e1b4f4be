"""A stand-in for `omni.graph.core`, which OmniGraph's Python imports as `og`, with what a node's own code needs."""

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
"""Top-level packages that exist only in Kit."""


class ExecutionAttributeState(IntEnum):
    """What may be assigned to an execution output; only enabled outputs are followed."""

    DISABLED = 0
    ENABLED = 1
    ENABLED_AND_PUSH = 2


class _StandIn(ModuleType):
    """Offers the names of `graph.controller`, which is imported at first use."""

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
    """Makes `import omni.graph.core as og` work within a `with` block only, so that no other code takes this for Kit.

    If the real module is installed, the import gives the real one.
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
    """Stand-ins by name for the module and its parent packages, except for those that are installed."""
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
    """What to do about a missing module of Kit, as the tail of a message; "" for any other module."""
    if (error.name or "").partition(".")[0] not in KIT:
        return ""
    if f"{NAME}.".startswith(f"{error.name}."):
        return f"; import {NAME} at the top of the module, not while it computes"
    return f"; of Kit's modules TickGraph has only {NAME}: do without it, or catch the error"
