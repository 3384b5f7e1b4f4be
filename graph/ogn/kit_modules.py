"""Kit's modules for the code of nodes: `import omni.graph.core as og`, `import omni.usd`. A plug-in has them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache
from typing import Any

from graph.base.plugins import KIT, required
from graph.base.records import dataclass


@dataclass(frozen=True, slots=True)
class KitModules:
    """`with importable():` makes them importable, `with acting_on(app):` makes them act on this App as well.

    advice: what to do about a missing module of Kit, as the tail of a message; "" for any other module.
    """

    importable: Callable[[], AbstractContextManager[None]]
    acting_on: Callable[[Any], AbstractContextManager[None]]
    advice: Callable[[ImportError], str]


@cache
def kit() -> KitModules:
    """The modules that are declared."""
    return required(KIT, "modules", KitModules, "code for the modules of Kit")
