"""Which prims of a stage have which graphs: the relationship `omniGraphs` of OmniGraphAPI."""

from __future__ import annotations

from typing import Any

from .graph_prims import _GRAPHS, _variables_of


def instances_on(stage: Any) -> dict[str, dict[str, dict[str, Any]]]:
    """By graph path, the prims that have the graph, in stage order, each with the variable values it gives."""
    users: dict[str, dict[str, dict[str, Any]]] = {}
    for prim in stage.Traverse():
        if prim.HasRelationship(_GRAPHS):
            for path in prim.GetRelationship(_GRAPHS).GetTargets():
                users.setdefault(str(path), {})[str(prim.GetPath())] = _variables_of(prim)
    return users
