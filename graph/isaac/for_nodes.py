"""Isaac Sim's modules for the code of nodes, declared in pyproject.toml."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from graph.ogn.kit_modules import KitModules

from .finder import advice, importable
from .session import app_of_node


@contextmanager
def acting_on(app: Any) -> Iterator[None]:
    """Makes them importable within a `with` block, and act on this App."""
    with importable(), app_of_node(app):
        yield


MODULES = KitModules(importable, acting_on, advice)
