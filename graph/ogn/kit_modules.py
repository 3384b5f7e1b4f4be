"""Kit's modules for the code of nodes: `import omni.graph.core as og`, `import omni.usd`; see `graph.isaac`.

`graph.isaac` joins the controller and the world, which know this package; so it is imported by name, at first use.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any


@contextmanager
def importable() -> Iterator[None]:
    """Makes Kit's modules importable within a `with` block."""
    with import_module("graph.isaac.finder").importable():
        yield


@contextmanager
def kit_modules(app: Any) -> Iterator[None]:
    """Makes Kit's modules importable within a `with` block, and act on this App."""
    with importable(), import_module("graph.isaac.session").app_of_node(app):
        yield


def advice(error: ImportError) -> str:
    """What to do about a missing module of Kit, as the tail of a message; "" for any other module."""
    return str(import_module("graph.isaac.finder").advice(error))
