"""Node types: declaration, registry, and the database and context that a compute function gets.

    from graph.node import Attribute, Database, node_type

Names are imported at their first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names

if TYPE_CHECKING:
    from .at_load import NodeAtLoad
    from .context import Context
    from .database import Database, LackError, NodeError
    from .declaration import UNSET, Attribute, NodeType
    from .decorator import declare, node_type
    from .known_types import KnownTypes

_HOMES = {
    "UNSET": "declaration",
    "Attribute": "declaration",
    "Context": "context",
    "Database": "database",
    "KnownTypes": "known_types",
    "LackError": "database",
    "NodeAtLoad": "at_load",
    "NodeError": "database",
    "NodeType": "declaration",
    "declare": "decorator",
    "node_type": "decorator",
}

__all__ = [
    "UNSET",
    "Attribute",
    "Context",
    "Database",
    "KnownTypes",
    "LackError",
    "NodeAtLoad",
    "NodeError",
    "NodeType",
    "declare",
    "node_type",
]

__getattr__, __dir__ = lazy_names(__name__, _HOMES)
