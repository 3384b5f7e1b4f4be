"""Applies edits to existing graphs: they take over the newly compiled form and keep what they have gathered."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from graph.node.attribute_names import python_name

from .dirty import DirtyPushEvaluator
from .graph import Graph
from .node import Node

_FROM_FRESH = (
    "added",
    "consumed_names",
    "db",
    "fed_names",
    "index",
    "initial_values",
    "late",
    "mark",
    "names",
    "passes",
    "rank",
    "readers",
    "sources",
    "types",
    "wires_in",
)
"""What an edit renews of a node."""


def adopt(graphs: Mapping[str, Graph], fresh: Mapping[str, Graph], touched: Mapping[str, Collection[str]]) -> None:
    """Gives each of `graphs` the form of the graph with the same path in `fresh`; none of them may be running.

    Graphs that are only in `fresh` are new; they are connected to the nodes of the graphs that stay. Graph, Node and
    Variables objects stay the same, so that references to them remain valid; they keep memory, state, outputs, sleep
    and counts. A node whose type id changed is a new node. `touched` names the nodes that the edit concerns, by graph
    path: a lazy graph computes these again. Removed nodes are released.
    """
    kept: dict[Node, Node] = {}
    changed: dict[str, list[Node]] = {}
    for path, graph in graphs.items():
        graph.refresh()
        changed[path] = _take_nodes(graph, fresh[path], set(touched.get(path, ())), kept)
    for path, new in fresh.items():
        _link(graphs.get(path, new), kept)
    for path, graph in graphs.items():
        _finish(graph, fresh[path], changed[path])
    for path, new in fresh.items():
        for copy in graphs.get(path, new).starts:
            copy()


def _take_nodes(graph: Graph, new: Graph, touched: set[str], kept: dict[Node, Node]) -> list[Node]:
    """Merges the nodes; returns those that a lazy graph must compute again."""
    nodes: dict[str, Node] = {}
    changed: list[Node] = []
    for name, fresh in new.nodes.items():
        old = graph.nodes.get(name)
        if old is not None and old.type is fresh.type:
            node = kept[fresh] = old
            if _take(node, fresh) or name in touched:
                changed.append(node)
        else:
            node = fresh
            node.graph = graph
            changed.append(node)
        nodes[name] = node
    for name, old in graph.nodes.items():
        if nodes.get(name) is not old:
            old.release()
    graph.members = nodes
    return changed


def _take(node: Node, fresh: Node) -> bool:
    """Takes over an edited node's form and keeps what it has gathered: memory, state, outputs, sleep, counts.

    `fresh` is the same node, newly compiled. Returns whether any of its types changed.
    """
    old, new = node.db, fresh.db
    if old.inputs is None:  # made by an edit and not compiled before
        new._node = node
        for slot in _FROM_FRESH:
            setattr(node, slot, getattr(fresh, slot))
        return True
    same_types = node.types == fresh.types
    for prefix in ("outputs", "state"):
        source, target = getattr(old, prefix), getattr(new, prefix)
        for name in fresh.names[prefix]:
            full = f"{prefix}:{name}"
            if full not in fresh.initial_values or full not in node.initial_values:
                continue
            if same_types or node.types[full] is fresh.types[full]:
                setattr(target, python_name(name), getattr(source, python_name(name)))
    new.memory, new.asleep = old.memory, old.asleep
    new._set_blocked(old._blocked)
    new.computes, new._deaf = old.computes, old._deaf
    for name, wire in new._wires.items():
        if name in old._wires:
            wire.count = old._wires[name].count
    new._node = node
    for slot in _FROM_FRESH:
        setattr(node, slot, getattr(fresh, slot))
    return not same_types


def _link(graph: Graph, kept: Mapping[Node, Node]) -> None:
    for node in graph.nodes.values():
        if node.sources:
            node.sources = tuple(kept.get(one, one) for one in node.sources)
        if node.readers:
            node.readers = tuple(kept.get(one, one) for one in node.readers)


def _finish(graph: Graph, new: Graph, changed: Collection[Node]) -> None:
    graph.variables.take(new.variables)
    graph.take(new)
    for prim, instance in list(graph.instances.items()):
        if prim not in new.instances:
            instance.close()
            del graph.instances[prim]
    instances = {}
    for prim, fresh in new.instances.items():
        instances[prim] = graph.instances.get(prim, fresh)
        if instances[prim] is not fresh:
            adopt({graph.path: instances[prim]}, {graph.path: fresh}, {graph.path: [node.name for node in changed]})
        else:
            fresh.observe_as(graph)
    graph.instances = instances
    before = graph.evaluator_state
    if isinstance(before, DirtyPushEvaluator) and graph.evaluator == "dirty_push":
        lazy = DirtyPushEvaluator(graph)
        lazy.carry(before, changed)
        graph.evaluator_state = lazy
    else:
        graph.evaluator_state = None
