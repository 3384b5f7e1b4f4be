"""One graph on many prims: what differs from one to the next.

A prim has a graph when its relationship `omniGraphs` (OmniGraphAPI) names it. The graph then runs once for each of
them, with variables, values and memory of its own, and the token `_OMNI_GRAPH_TARGET` in its values means that prim.
A graph that no prim has takes the token for itself.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from graph.spec.file_spec import GraphSpec

GRAPH_TARGET = "_OMNI_GRAPH_TARGET"
"""What stands for the prim of the instance, alone or as a part of a path."""


def with_target(value: Any, target: str) -> Any:
    """The value with the token replaced; texts in lists and in `{type:, value:}` too.

    What stands in front of the token in a path goes: editors anchor `_OMNI_GRAPH_TARGET/arm` at the graph.
    """
    if isinstance(value, str):
        if GRAPH_TARGET not in value:
            return value
        parts = value.split("/")
        if GRAPH_TARGET not in parts:
            return value
        behind = parts[len(parts) - parts[::-1].index(GRAPH_TARGET) :]
        return "/".join([target, *behind])
    if isinstance(value, (list, tuple)):
        return [with_target(one, target) for one in value] if _has_target(value) else value
    if isinstance(value, dict) and _has_target(value.values()):
        return {key: with_target(one, target) for key, one in value.items()}
    return value


def _has_target(values: Iterable[Any]) -> bool:
    return any(isinstance(one, str) and GRAPH_TARGET in one for one in values)


def instance_spec(spec: GraphSpec, prim: str) -> GraphSpec:
    """The graph as one prim has it: the prim's variable values in the place of the graph's."""
    given = spec.instances[prim]
    variables = {
        name: replace(variable, value=given[name]) if name in given else variable
        for name, variable in spec.variables.items()
    }
    return replace(spec, variables=variables, instances={}, evaluation_mode="standalone")
