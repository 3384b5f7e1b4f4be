"""TickGraph: node graphs over a simulated world, with the clocks and sensors of a robot simulator.

    from graph import Attribute, node_type, load_graph

Names are imported when first used, so that `import graph` costs next to nothing.
"""

from __future__ import annotations

from .base.lazy_names import lazy_names as _lazy_names

TYPE_CHECKING = False  # importing typing would take longer than all the rest
if TYPE_CHECKING:
    from .base.errors import Mark, Problem, RunError, UserError
    from .evaluate import ComputeError, Graph, Node
    from .isaac.og import Controller, OmniGraphError, OmniGraphValueError
    from .node.context import Context
    from .node.database import Database, NodeError
    from .node.declaration import UNSET, Attribute, NodeType
    from .node.decorator import declare, node_type
    from .plan import compile_graphs
    from .session.load import LoadedFile, load_graph

_HOMES = {
    "UNSET": "node.declaration",
    "Attribute": "node.declaration",
    "ComputeError": "evaluate",
    "Context": "node.context",
    "Controller": "isaac.og",
    "Database": "node.database",
    "Graph": "evaluate",
    "LoadedFile": "session.load",
    "Mark": "base.errors",
    "Node": "evaluate",
    "NodeError": "node.database",
    "NodeType": "node.declaration",
    "OmniGraphError": "isaac.og",
    "OmniGraphValueError": "isaac.og",
    "Problem": "base.errors",
    "RunError": "base.errors",
    "UserError": "base.errors",
    "compile_graphs": "plan",
    "declare": "node.decorator",
    "load_graph": "session.load",
    "node_type": "node.decorator",
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


__getattr__, __dir__ = _lazy_names(__name__, _HOMES)
