"""Runs the valid part of a file: unknown node types left out on request, saved scenes compiled as far as possible."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace

from graph.base.errors import Problem, UserError
from graph.evaluate import Graph
from graph.node.declaration import UNSET
from graph.node.registry import DEFAULT, Registry
from graph.plan import SKIP_ADVICE, compile_graphs
from graph.spec.file_spec import ConnectionSpec, FileSpec, GraphSpec, NodeSpec, Note

_ROUNDS = 20
"""Leaving a part out can reveal another mistake; bounded."""


def compile_file(
    spec: FileSpec, registry: Registry = DEFAULT, *, skip_unknown: bool = False
) -> tuple[list[Graph], FileSpec]:
    """The compiled graphs of a file, and the file without the parts left out, each with a note.

    skip_unknown: nodes of unknown types are left out with their connections. In a lenient file (a saved scene)
    everything that cannot be compiled is left out: a value, a connection, else the node. Raises UserError with every
    other problem.
    """
    if spec.lenient:
        spec = without_untyped(spec)
    if skip_unknown:
        spec = without_unknown_types(spec, registry)
    for _ in range(_ROUNDS):
        try:
            return compile_graphs(spec.graphs, registry), spec
        except UserError as error:
            if not spec.lenient:
                raise
            rest, spec = _left_out(spec, error.problems, registry)
            if rest:
                raise UserError(rest) from None
    return compile_graphs(spec.graphs, registry), spec


def compile_rest(spec: FileSpec, registry: Registry = DEFAULT) -> list[Graph]:
    """The part of a file with mistakes that can be compiled, so that further mistakes are found; [] if nothing can."""
    tolerant = replace(spec, graphs=tuple(replace(graph, saved=True) for graph in spec.graphs))
    try:
        return compile_file(tolerant, registry, skip_unknown=True)[0]
    except UserError:
        return []


def without_unknown_types(spec: FileSpec, registry: Registry = DEFAULT) -> FileSpec:
    """The file without nodes of unregistered types; one note for each type says how many there were.

    What those nodes fed may stay without a value: their graphs are partial.
    """
    lost: dict[str, list[tuple[GraphSpec, NodeSpec]]] = {}
    for graph in spec.graphs:
        for node in graph.nodes:
            if node.type not in registry:
                lost.setdefault(node.type, []).append((graph, node))
    if not lost:
        return spec
    notes: list[Note] = []
    for type_id, places in lost.items():
        graph, node = places[0]
        names = ", ".join(node.name for _, node in places[:3]) + (", ..." if len(places) > 3 else "")
        what = f"{len(places)} node{'' if len(places) == 1 else 's'} of it left out ({names})"
        at = str(node.mark or f"{graph.path}/{node.name}")
        notes.append(("node-type-unknown", at, f'there is no node type "{type_id}" here; {what}'))
    gone = {f"{graph.path}/{node.name}" for places in lost.values() for graph, node in places}
    partial = {graph.path for places in lost.values() for graph, _ in places}
    graphs = tuple(replace(one, unfinished=True, partial=True) if one.path in partial else one for one in spec.graphs)
    return _without_nodes(replace(spec, graphs=graphs, notes=(*spec.notes, *notes)), gone)


def without_untyped(spec: FileSpec) -> FileSpec:
    """The file without USD prims that are nodes without a type, with notes. No graph file can express such a node."""
    untyped = {
        f"{graph.path}/{node.name}": node for graph in spec.graphs for node in graph.nodes if not node.type.strip()
    }
    notes = tuple(
        ("usd-no-type", str(node.mark or path), f"{path} has no node type; it is left out, with its connections")
        for path, node in untyped.items()
    )
    return _without_nodes(replace(spec, notes=(*spec.notes, *notes)), set(untyped)) if untyped else spec


def _left_out(spec: FileSpec, problems: Iterable[Problem], registry: Registry) -> tuple[list[Problem], FileSpec]:
    """The problems that leaving out cannot solve, and the file without the parts that have the other problems."""
    nodes: dict[int, str] = {}
    unknown: set[int] = set()
    values: dict[int, tuple[str, str]] = {}
    types: dict[str, str] = {}
    connections: set[int] = set()
    for graph in spec.graphs:
        for node in graph.nodes:
            path = f"{graph.path}/{node.name}"
            nodes[id(node.mark)], types[path] = path, node.type
            values |= {id(mark): (path, key) for key, mark in node.input_marks.items()}
            if node.type not in registry:
                unknown.add(id(node.mark))
        connections |= {id(connection.mark) for connection in graph.connections}
    rest: list[Problem] = []
    notes: list[Note] = []
    lost_nodes: set[str] = set()
    lost_values: set[tuple[str, str]] = set()
    lost_connections: set[int] = set()
    for problem in problems:
        mark = id(problem.mark)
        if problem.mark is None:
            rest.append(problem)
        elif mark in unknown:
            rest.append(_with_advice(problem))
        elif mark in connections:
            lost_connections.add(mark)
            notes.append(_note("connection-left-out", problem, "the connection is left out"))
        elif mark in values:
            path, key = values[mark]
            lost_values.add((path, key))
            notes.append(
                _note("value-left-out", problem, f"the value is left out{_instead(registry, types[path], key)}")
            )
        elif mark in nodes and nodes[mark] in lost_nodes:
            continue  # one line for each node is enough
        elif mark in nodes:
            lost_nodes.add(nodes[mark])
            notes.append(_note("node-left-out", problem, "the node is left out"))
        else:
            rest.append(problem)
    spec = replace(
        spec,
        notes=(*spec.notes, *dict.fromkeys(notes)),
        graphs=tuple(_without(graph, lost_values, lost_connections) for graph in spec.graphs),
    )
    return rest, _without_nodes(spec, lost_nodes)


def _with_advice(problem: Problem) -> Problem:
    """The problem of an unknown type with the general advice: nobody typed the names of a saved scene."""
    asks = problem.message.endswith("?")
    return replace(problem, message=f"{problem.message} {SKIP_ADVICE}") if asks else problem


def _instead(registry: Registry, type_id: str, key: str) -> str:
    """What a node takes for a value of the file that is left out, if its type has a default other than nothing."""
    declared = registry.get(type_id).find("inputs", key.removeprefix("inputs:")) if type_id in registry else None
    default = UNSET if declared is None else declared.default
    return "" if default is UNSET or default in ("", None) else f", and the default counts: {json.dumps(default)}"


def _note(code: str, problem: Problem, what: str) -> Note:
    return code, str(problem.mark), f"{problem.message.rstrip('.')}; {what}"


def _without(graph: GraphSpec, values: set[tuple[str, str]], connections: set[int]) -> GraphSpec:
    def node(one: NodeSpec) -> NodeSpec:
        kept = {key: value for key, value in one.inputs.items() if (f"{graph.path}/{one.name}", key) not in values}
        return one if len(kept) == len(one.inputs) else replace(one, inputs=kept)

    kept = tuple(one for one in graph.connections if id(one.mark) not in connections)
    return replace(graph, nodes=tuple(map(node, graph.nodes)) if values else graph.nodes, connections=kept)


def _without_nodes(spec: FileSpec, gone: set[str]) -> FileSpec:
    """The file without some nodes, by path, and without their connections."""
    if not gone:
        return spec

    def stands(connection: ConnectionSpec, graph: GraphSpec) -> bool:
        return not ({_node_path(connection.source, graph), _node_path(connection.target, graph)} & gone)

    return replace(
        spec,
        graphs=tuple(
            replace(
                graph,
                nodes=tuple(node for node in graph.nodes if f"{graph.path}/{node.name}" not in gone),
                connections=tuple(one for one in graph.connections if stands(one, graph)),
            )
            for graph in spec.graphs
        ),
    )


def _node_path(end: str, graph: GraphSpec) -> str:
    node = end.rpartition(".")[0]
    return node.replace(".", "/") if node.startswith("/") else f"{graph.path}/{node}"
