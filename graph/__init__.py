"""TickGraph: node graphs over a simulated world, with the clocks and sensors of a robot simulator.

    from graph import Attribute, node_type, load_graph

Names are imported when first used, so that `import graph` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .context import Context
    from .controller import Controller, OmniGraphError, OmniGraphValueError
    from .db import Database, NodeError
    from .declaration import UNSET, Attribute, NodeType, declare, node_type
    from .errors import Mark, Problem, RunError, UserError
    from .evaluate import ComputeError, Graph, Node
    from .loading import LoadedFile, load_graph
    from .plan import compile_graphs

_HOMES = {
    "UNSET": "declaration",
    "Attribute": "declaration",
    "ComputeError": "evaluate",
    "Context": "context",
    "Controller": "controller",
    "Database": "db",
    "Graph": "evaluate",
    "LoadedFile": "loading",
    "Mark": "errors",
    "Node": "evaluate",
    "NodeError": "db",
    "NodeType": "declaration",
    "OmniGraphError": "controller",
    "OmniGraphValueError": "controller",
    "Problem": "errors",
    "RunError": "errors",
    "UserError": "errors",
    "compile_graphs": "plan",
    "declare": "declaration",
    "load_graph": "loading",
    "node_type": "declaration",
}

__all__ = [
    "UNSET",
    "Attribute",
    "ComputeError",
    "Context",
    "Controller",
    "Database",
    "Graph",
    "LoadedFile",
    "Mark",
    "Node",
    "NodeError",
    "NodeType",
    "OmniGraphError",
    "OmniGraphValueError",
    "Problem",
    "RunError",
    "UserError",
    "compile_graphs",
    "declare",
    "load_graph",
    "node_type",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
