"""Stand-ins for `omni.graph.core`, which OmniGraph's Python imports as `og`, and for `omni.usd`, which gives the stage.

They have what a node's own code needs.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from enum import IntEnum
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

NAME = "omni.graph.core"
USD_NAME = "omni.usd"
KIT = ("carb", "isaacsim", "omni")
"""Top-level packages that exist only in Kit."""


class ExecutionAttributeState(IntEnum):
    """What may be assigned to an execution output; only enabled outputs are followed."""

    DISABLED = 0
    ENABLED = 1
    ENABLED_AND_PUSH = 2


class _StandIn(ModuleType):
    """Offers the names of `graph.isaac.og`, which is imported at first use."""

    ExecutionAttributeState = ExecutionAttributeState

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_"):
            og = import_module("graph.isaac.og")
            if name in og.__all__:
                return getattr(og, name)
            names = ", ".join(("ExecutionAttributeState", *og.__all__))
            raise AttributeError(f"TickGraph has no {NAME}.{name}; of that module it has {names}")
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


OG = _StandIn(NAME, __doc__)
"""The stand-in for `omni.graph.core`; scripts find it as `og`."""


_APPS: ContextVar[Any] = ContextVar("app", default=None)
"""The App whose node runs."""


class _UsdContext:
    """What `omni.usd.get_context()` gives: the stage of the App whose node asks."""

    def get_stage(self) -> Any:
        """The `Usd.Stage`; None outside an App."""
        app = _APPS.get()
        return None if app is None else app.stage


class _UsdStandIn(ModuleType):
    def __getattr__(self, name: str) -> Any:
        if name == "get_context":
            return lambda name="": _UsdContext()
        if not name.startswith("_"):
            raise AttributeError(f"TickGraph has no {USD_NAME}.{name}; of that module it has get_context")
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


USD = _UsdStandIn(USD_NAME, __doc__)
"""The stand-in for `omni.usd`."""
_MODULES = {NAME: OG, USD_NAME: USD}


@contextmanager
def stage_of(app: Any) -> Iterator[None]:
    """Makes `omni.usd` give the stage of this App within a `with` block."""
    before = _APPS.set(app)
    try:
        yield
    finally:
        _APPS.reset(before)


@contextmanager
def importable() -> Iterator[None]:
    """Makes `import omni.graph.core as og` and `import omni.usd` work within a `with` block only.

    So no other code takes this for Kit. If the real module is installed, the import gives the real one.
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
    """Stand-ins by name for the modules and their parent packages, except for those that are installed."""
    made: dict[str, ModuleType] = {}
    for name in ("omni", "omni.graph", NAME, USD_NAME):
        parent, _, last = name.rpartition(".")
        try:
            module = import_module(name)
        except ImportError:
            module = made[name] = _MODULES.get(name) or ModuleType(name)
            if name not in _MODULES:
                module.__path__ = []
        if parent in made:
            setattr(made[parent], last, module)
    return made


def advice(error: ImportError) -> str:
    """What to do about a missing module of Kit, as the tail of a message; "" for any other module."""
    if (error.name or "").partition(".")[0] not in KIT:
        return ""
    if any(f"{name}.".startswith(f"{error.name}.") for name in _MODULES):
        return "; import it at the top of the module, not while it computes"
    return f"; of Kit's modules TickGraph has only {' and '.join(_MODULES)}: do without it, or catch the error"
