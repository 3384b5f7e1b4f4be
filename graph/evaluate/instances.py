"""One graph on many prims: what differs from one instance to the next.

A prim has a graph when its relationship `omniGraphs` (OmniGraphAPI) names it. The graph then runs once for each such
prim, with its own variables, values and memory, and the token `_OMNI_GRAPH_TARGET` in its values means that prim. In a
graph without instances the token means the graph itself.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from graph.spec.file_spec import GraphSpec

GRAPH_TARGET = "_OMNI_GRAPH_TARGET"
"""The token for the prim of the instance, alone or as a part of a path."""


def with_target(value: Any, target: str) -> Any:
    """The value with the token replaced, also in texts inside lists and in `{type:, value:}`.

    What stands before the token in a path is dropped: editors prefix `_OMNI_GRAPH_TARGET/arm` with the graph's path.
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
    """The spec of one instance, with the prim's variable values instead of the graph's."""
    given = spec.instances[prim]
    variables = {
        name: replace(variable, value=given[name]) if name in given else variable
        for name, variable in spec.variables.items()
    }
    return replace(spec, variables=variables, instances={}, evaluation_mode="standalone")
