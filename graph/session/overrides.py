"""Values of the caller that replace those of a graph file: `--set NODE.ATTR=VALUE`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from graph.base.errors import UserError
from graph.base.suggest import did_you_mean
from graph.spec.file_spec import FileSpec, GraphSpec


def override_inputs(spec: FileSpec, overrides: Mapping[str, str]) -> FileSpec:
    """The file with `NODE.ATTR` inputs replaced; NODE is a node's name, or its path if the name is not unique."""
    from graph.files import parse_value

    graphs = list(spec.graphs)
    for target, text in overrides.items():
        name, _, attribute = target.rpartition(".")
        found = [
            (g, n)
            for g, graph in enumerate(graphs)
            for n, node in enumerate(graph.nodes)
            if name in (node.name, f"{graph.path}/{node.name}")
        ]
        if len(found) != 1:
            known = [node.name for graph in graphs for node in graph.nodes]
            near = f"no node has that name{did_you_mean(name, known)}"
            raise UserError(
                f"--set {target}: {'several graphs have such a node; give its whole path' if found else near}"
            )
        [(g, n)] = found
        attribute = attribute.removeprefix("inputs:")
        if _is_connected(graphs[g], graphs[g].nodes[n].name, attribute):
            raise UserError(f"--set {target}: a connection feeds this input; set the attribute at its source")
        graphs[g] = _with_input(graphs[g], n, attribute, parse_value(text))
    return replace(spec, graphs=tuple(graphs))


def _is_connected(graph: GraphSpec, node: str, attribute: str) -> bool:
    ends = (connection.target.rpartition(".") for connection in graph.connections)
    return any(
        end in (node, f"{graph.path}/{node}") and name.removeprefix("inputs:") == attribute for end, _, name in ends
    )


def _with_input(graph: GraphSpec, index: int, attribute: str, value: Any) -> GraphSpec:
    nodes = list(graph.nodes)
    nodes[index] = replace(nodes[index], inputs={**nodes[index].inputs, attribute: value})
    return replace(graph, nodes=tuple(nodes))
