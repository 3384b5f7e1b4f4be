"""Finds graphs, nodes and attributes by the forms in which scripts name them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graph.base.suggest import did_you_mean
from graph.editing.errors import OmniGraphError
from graph.editing.graph_set import GraphSet
from graph.editing.model import SUBGRAPH
from graph.evaluate import Graph, Node
from graph.evaluate.omnigraph_names import AttributeOf

from .handles import Compound
from .names import attribute_text, end_text, node_text


def graph_path(graph_id: Any) -> str:
    """The path that a graph id means."""
    if isinstance(graph_id, Mapping):
        if "graph_path" not in graph_id:
            raise OmniGraphError('a graph dict needs "graph_path"')
        graph_id = graph_id["graph_path"]
    return node_text(graph_id, "graph")


def inside_compound(graphs: GraphSet, graph_id: Any) -> tuple[str, str]:
    """The graph and the prefix of the names if the path is a compound's inside; else "", ""."""
    path = graph_path(graph_id)
    if not path.endswith(f"/{SUBGRAPH}") or graphs.latest(path) is not None:
        return "", ""
    owner = graphs.owner_of(path)
    name = "" if owner is None else path[len(owner.path) + 1 :].removesuffix(f"/{SUBGRAPH}")
    if owner is None or name not in owner.spec.compounds:
        return "", ""
    if isinstance(graph_id, Mapping):
        raise OmniGraphError(f"{path} is the inside of a compound; give its path instead of a dict to change it")
    return owner.path, f"{name}/{SUBGRAPH}/"


def existing(graphs: GraphSet, graph_id: Any) -> str:
    """The path of the graph to edit; "" if it is to be made. Raises OmniGraphError for a dict of an existing graph."""
    path = graph_path(graph_id)
    there = graphs.latest(path) is not None
    if isinstance(graph_id, Graph) and not there:
        raise OmniGraphError(f"graph {path} is not among these graphs; it was deleted or belongs to another App")
    if isinstance(graph_id, Mapping) and there:
        raise OmniGraphError(f"graph {path} already exists; give its path instead of a dict to change it")
    return path if there else ""


def graph(graphs: GraphSet, graph_id: Any) -> Graph:
    """The graph. Raises OmniGraphError with the nearest one."""
    if graph_id is None:
        raise OmniGraphError("name a graph")
    if isinstance(graph_id, Graph) and graph_id.target != graph_id.path:
        return graph_id  # an instance: its path is that of the graph
    return graphs.get(graph_path(graph_id))


def graph_and_name(graphs: GraphSet, node_id: Any) -> tuple[Graph, str]:
    """The graph that a node of that path would belong to, and its name there."""
    path = node_text(node_id)
    owner = graphs.owner_of(path) if path.startswith("/") else None
    if owner is None:
        raise OmniGraphError(f'"{path}" is not a legal node; write the path of one in a graph that exists')
    return graphs.get(owner.path), path[len(owner.path) + 1 :]


def node(graphs: GraphSet, node_id: Any, graph_id: Any = None, *, missing: bool = False) -> Any:
    """The node or compound. If it does not exist: None if `missing` is allowed, else raises OmniGraphError."""
    if isinstance(node_id, (Node, Compound)):
        return node_id
    path = node_text(node_id if graph_id is None else (node_id, graph(graphs, graph_id)))
    found = graphs.node(path)
    if found is not None:
        return found
    owner = graphs.owner_of(path)
    if owner is not None:
        name = path[len(owner.path) + 1 :]
        if name in owner.spec.compounds:
            return Compound(graphs.get(owner.path), name)
    if missing:
        return None
    near = did_you_mean(path, [one.path for one in owner.nodes.values()]) if owner is not None else ""
    hint = "" if path.startswith("/") else "; write its path, or name the graph too"
    raise OmniGraphError(f'"{path}" is not a legal node; no node has that path{near or hint}')


def attribute(graphs: GraphSet, attribute_id: Any, node_id: Any = None, graph_id: Any = None) -> AttributeOf:
    """The attribute. Raises OmniGraphError with the nearest one."""
    if isinstance(attribute_id, AttributeOf):
        return attribute_id
    if node_id is None:
        if isinstance(attribute_id, tuple) and len(attribute_id) >= 2:
            attribute_id, node_id, *rest = attribute_id
            graph_id = rest[0] if rest else graph_id
        else:
            node_id, _, attribute_id = end_text(attribute_id).rpartition(".")
    owner = node(graphs, node_id, graph_id)
    try:
        found: AttributeOf = owner.get_attribute(attribute_text(attribute_id))
    except KeyError as error:
        raise OmniGraphError(f'"{attribute_id}" is not a legal attribute: {error.args[0]}') from None
    return found


def graph_of_end(graphs: GraphSet, end: Any) -> Graph:
    """The graph of the node that an attribute belongs to, as last edited."""
    if isinstance(end, AttributeOf):
        return end.node.graph
    owner = end_text(end).rpartition(".")[0]
    return graph_and_name(graphs, owner)[0]
