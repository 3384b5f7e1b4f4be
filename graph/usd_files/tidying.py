"""Leaves out data of saved graphs that the node types do not know, with one warning of each kind for the whole file.

The original also drops such data when it loads a file, with an entry in its log.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from graph.node.declaration import Attribute, NodeType
from graph.node.registry import DEFAULT, Registry
from graph.spec.file_spec import ConnectionSpec, FileSpec, GraphSpec, NodeSpec
from graph.spec.migration import Notes
from graph.values.types import Extended, parse_type

_VECTOR = re.compile(r"\s*\([-+0-9eE.,() ]{1,1000}\)\s*")
_REPLICATOR = ("omni.replicator.", "omni.syntheticdata.", "omni.syntheticdata.Sd")


def tidied(spec: FileSpec, ours: Collection[str] = (), registry: Registry = DEFAULT) -> FileSpec:
    """The file without meaningless data, with a warning for each kind that was left out.

    ours: paths of graphs and nodes that `graph convert` wrote; there nothing is left out, as in a YAML file.
    """
    notes = Notes()
    graphs = tuple(_graph(graph, ours, registry, notes) for graph in _without_replicator(spec.graphs, ours, notes))
    return replace(spec, graphs=graphs, notes=(*spec.notes, *notes.all()))


def _without_replicator(graphs: Iterable[GraphSpec], ours: Collection[str], notes: Notes) -> Iterator[GraphSpec]:
    """Leaves out Replicator's pipelines:

    Replicator builds them in every session; one in a file was saved by accident.
    """
    for graph in graphs:
        if graph.path in ours:
            yield graph
            continue
        at = graph.mark, graph.path
        pipeline = graph.path.endswith("/SDGPipeline") or (
            graph.nodes and all(node.type.startswith(_REPLICATOR) for node in graph.nodes)
        )
        if pipeline:
            message = f"{graph.path} is a Replicator pipeline ({len(graph.nodes)} nodes) saved by accident; left out"
            notes.add("usd-replicator", message, *at)
            continue
        if not graph.nodes:
            notes.add("usd-empty-graph", f"{graph.path} has no nodes", *at)
        yield graph


def _graph(graph: GraphSpec, ours: Collection[str], registry: Registry, notes: Notes) -> GraphSpec:
    types = {name: registry.get(name) for name in {node.type for node in graph.nodes} if name in registry}
    strict = {node.name for node in graph.nodes if f"{graph.path}/{node.name}" in ours}
    nodes = tuple(
        node if node.name in strict else _node(node, graph, types.get(node.type), notes) for node in graph.nodes
    )
    by_name = {node.name: node for node in nodes}
    connections = tuple(_connections(graph, by_name, strict, types, notes))
    if graph.evaluator != "execution":
        events = [node.name for node in nodes if (known := types.get(node.type)) and known.event is not None]
        if events:
            message = (
                f"{graph.path} is a {graph.evaluator} graph with event nodes ({', '.join(events[:3])}): every node "
                "computes in every update, execution connections order nothing"
            )
            notes.add("event-in-push-graph", message, graph.mark, graph.path)
    return replace(graph, nodes=nodes, connections=connections)


def _node(node: NodeSpec, graph: GraphSpec, known: NodeType | None, notes: Notes) -> NodeSpec:
    if known is None:
        used = {full: type_ for full, type_ in node.attributes.items() if full.removeprefix("inputs:") in node.inputs}
        return _with(node, node.inputs, used)
    if not node.inputs and not node.attributes:
        return node
    inputs: dict[str, Any] = {}
    for key, value in node.inputs.items():
        prefix, name = split(key)
        declared = known.find(prefix, name)
        if declared is None:
            at = node.input_marks.get(key, node.mark), f"{graph.path}/{node.name}"
            message = f"{known.short_name} has no {prefix}:{name} (any more); its value is left out"
            notes.add("attribute-unknown", message, *at)
        elif not declared.is_execution and declared.type != "bundle":
            inputs[key] = _typed(value, declared, node.attributes.get(f"{prefix}:{name}"))
    return _with(node, inputs, dict(_added(node, known)) if node.attributes.keys() - known.names else {})


def _with(node: NodeSpec, inputs: Mapping[str, Any], attributes: Mapping[str, str]) -> NodeSpec:
    return NodeSpec(node.name, node.type, inputs, node.mark, node.input_marks, attributes)  # 3 x as fast as replace


def _typed(value: Any, declared: Attribute, written: str | None) -> Any:
    """The value, with the type in the file if the node type leaves it open.

    A file without a type for it may hold a vector as text: `(90, 0, 0)`.
    """
    if isinstance(declared.parsed, Extended) and isinstance(value, str):
        return _vector(value)
    if not isinstance(declared.parsed, Extended) or isinstance(value, dict) or written in (None, "token", "target"):
        return value
    return {"type": written, "value": value}


def _vector(text: str) -> Any:
    """The numbers of a vector or matrix in USD's notation; any other text unchanged."""
    if not _VECTOR.fullmatch(text):
        return text
    try:
        value = ast.literal_eval(text)
    except (ValueError, SyntaxError, RecursionError, MemoryError):
        return text
    rows = value if isinstance(value, tuple) else ()
    return [list(row) if isinstance(row, tuple) else row for row in rows] or text


def _added(node: NodeSpec, known: NodeType) -> Iterator[tuple[str, str]]:
    """The node's attributes beside those of its type, if the type leaves their types open."""
    for full, written in node.attributes.items():
        prefix, name = split(full)
        if name in getattr(known, prefix):
            continue
        declared = known.find(prefix, name)
        if declared is not None and isinstance(declared.parsed, Extended) and written != "token":
            parsed = parse_type(written)
            if parsed is not None and (written == "execution" or not isinstance(parsed, Extended)):
                yield full, written


def _connections(
    graph: GraphSpec,
    nodes: Mapping[str, NodeSpec],
    strict: Collection[str],
    types: Mapping[str, NodeType],
    notes: Notes,
) -> Iterator[ConnectionSpec]:
    counts: dict[tuple[str, str], str] = {}
    """By node and input, the source that counts: the first whose node type is known, because others are left out."""
    for connection in sorted(graph.connections, key=lambda one: not _may_run(one, nodes, types)):
        name, _, attribute = connection.target.rpartition(".")
        counts.setdefault((name, ":".join(split(attribute))), connection.source)
    declared_as: dict[tuple[str, str], tuple[str, Attribute | None]] = {}
    for connection in graph.connections:
        name, _, attribute = connection.target.rpartition(".")
        if name in strict or name not in nodes:
            yield connection
            continue
        node = nodes[name]
        known = types.get(node.type)
        key = node.type, attribute
        if key not in declared_as:
            prefix, bare = split(attribute)
            declared_as[key] = f"{prefix}:{bare}", known.find(prefix, bare) if known else None
        full, declared = declared_as[key]
        at = connection.mark, graph.path
        if known and declared is None:
            message = f"{known.short_name} has no {full} (any more); the connection to it is left out"
            notes.add("attribute-unknown", message, *at)
            continue
        if not _source_exists(connection, nodes, types):
            notes.add("attribute-unknown", f"{connection.source} does not exist; the connection is left out", *at)
            continue
        written = node.attributes.get(full)
        execution = declared.is_execution if declared else written == "execution"
        execution = execution or written == "execution"
        other = counts[name, full]
        if other != connection.source and not execution and known:
            message = f"{graph.path}/{connection.target} has two sources; {other} counts, {connection.source} does not"
            notes.add("two-sources", message, *at)
            continue
        yield connection


def _may_run(connection: ConnectionSpec, nodes: Mapping[str, NodeSpec], types: Mapping[str, NodeType]) -> bool:
    """Whether the source of a connection is outside the graph, or its type is known and has the attribute."""
    node = nodes.get(connection.source.rpartition(".")[0])
    return node is None or (node.type in types and _source_exists(connection, nodes, types))


def _source_exists(connection: ConnectionSpec, nodes: Mapping[str, NodeSpec], types: Mapping[str, NodeType]) -> bool:
    """Whether the source of a connection within one graph is an attribute that its node has, or may have."""
    name, _, attribute = connection.source.rpartition(".")
    node = nodes.get(name)
    known = types.get(node.type) if node else None
    if known is None:
        return True
    prefix, bare = split(attribute, "outputs")
    return known.find(prefix, bare) is not None


def split(attribute: str, default: str = "inputs") -> tuple[str, str]:
    """Prefix and name of an attribute that may be written without its prefix."""
    prefix, colon, name = attribute.partition(":")
    return (prefix, name) if colon and prefix in ("inputs", "outputs", "state") else (default, attribute)
