"""Compiles graph specs into graphs that run, and reports every mistake of a file at once."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.gc_pause import collector_paused
from graph.base.limits import check
from graph.base.suggest import did_you_mean
from graph.evaluate.graph import Graph, evaluator_of
from graph.evaluate.instances import instance_spec
from graph.evaluate.node import Layout, Node
from graph.node.declaration import NodeType
from graph.node.registry import DEFAULT, Registry, UnknownNodeTypeError
from graph.node.variables import Variables
from graph.spec.file_spec import GraphSpec, Note
from graph.values.coercion import coerce, zero
from graph.values.types import Type, concrete_type

from .connections import Nodes, link_all
from .draft import Draft, Shape, all_names, draft_node, initial_values
from .types import settle_types
from .wiring import flows, rank, wire

SKIP_ADVICE = "--skip-unknown runs the rest of the file"
_SUGGESTED = 20
"""Most unknown types of a file for which the nearest name is searched."""
NODE_NAME = re.compile(r"[^\s./:\[\]>]+(?:/[^\s./:\[\]>]+)*")


class _Problems:
    def __init__(self) -> None:
        self.found: list[Problem] = []

    def __call__(self, message: str, mark: Mark | None) -> None:
        self.found.append(Problem(message, mark))

    def raise_if_any(self) -> None:
        if self.found:
            # In the order of the file; problems without a place come last, in the order they were found.
            placed = sorted((p for p in self.found if p.mark), key=lambda p: p.mark or Mark("", 0, 0))
            raise UserError([*placed, *(p for p in self.found if not p.mark)])


def compile_graphs(
    specs: Sequence[GraphSpec], registry: Registry = DEFAULT, kept: Mapping[str, Node] | None = None
) -> list[Graph]:
    """The graphs of a file, in its order, ready to evaluate.

    Resolves short names, checks names, types and values, resolves open types, finds cycles and orders the nodes. kept:
    nodes of an earlier compilation, by path, whose types and initial values are still right.
    Raises UserError with every problem of all graphs, each with its place and, if a name is close, a suggestion; and
    OverLimit beyond the limit graph.nodes.
    """
    nodes = sum(len(spec.nodes) * max(len(spec.instances), 1) for spec in specs)
    check("graph.nodes", nodes, f"the graphs have {nodes:,} nodes, once for each prim that has the graph")
    with collector_paused():
        graphs = _compile(specs, registry, kept=kept or {})
        for graph in graphs:
            if graph.spec.instances:
                graph.instances = _instances(graph, registry)
        return graphs


def _instances(graph: Graph, registry: Registry) -> dict[str, Graph]:
    """A copy of the graph for each prim that has it."""
    spec = graph.spec
    if graph.linked:
        others = ", ".join(sorted(graph.linked))
        raise UserError(
            Problem(
                f"graph {graph.path} is instanced on prims and exchanges data with {others}; an instanced graph stands "
                "alone, pass values by the world or by events",
                spec.mark,
            )
        )
    unknown = [
        Problem(
            f'graph {graph.path} has no variable "{name}", which {prim} sets{did_you_mean(name, spec.variables)}',
            spec.mark,
        )
        for prim, given in spec.instances.items()
        for name in given
        if name not in spec.variables
    ]
    if unknown:
        raise UserError(unknown)
    return {prim: _compile([instance_spec(spec, prim)], registry, prim)[0] for prim in spec.instances}


def _compile(
    specs: Sequence[GraphSpec], registry: Registry, target: str = "", kept: Mapping[str, Node] = MappingProxyType({})
) -> list[Graph]:
    report = _Problems()
    graphs: list[Graph] = []
    nodes = Nodes()
    shapes: dict[NodeType, Shape] = {}
    paths: set[str] = set()
    for spec in specs:
        if spec.path in paths:
            report(f"graph {spec.path} is written twice; rename or merge one", spec.mark)
            continue
        paths.add(spec.path)
        graph = Graph(spec, _variables(spec, report), evaluator_of, target)
        graphs.append(graph)
        _draft_nodes(spec, graph, nodes, shapes, registry, kept, report)
    drafts = list(nodes.drafts.values())
    links = link_all(specs, nodes, report)
    settle_types(drafts, links, report)
    found = flows(links, report)
    rank(drafts, found, report)
    starts: list[tuple[Draft, Any]] = [
        (draft, draft.kept.initial_values if draft.kept else initial_values(draft, shapes[draft.type], report))
        for draft in drafts
    ]
    report.raise_if_any()
    for draft, initial in starts:
        shape = shapes[draft.type]
        same = draft.types is shape.types or draft.types == shape.types
        types, names, layout = shape.types if same else draft.types, shape.names, shape.layout
        if draft.dynamic:
            names = all_names(draft, shape)
            layout = Layout.of(draft.type.short_name, names, initial)
        draft.node.build(names, types, initial, draft.dynamic, layout, draft.late)
        draft.node.graph.members[draft.node.name] = draft.node
    wire(drafts, links, found, report)
    report.raise_if_any()
    for draft in drafts:
        if shapes[draft.type].deprecates or draft.dynamic:
            draft.node.graph.notes += tuple(_deprecations(draft))
    return graphs


def _draft_nodes(
    spec: GraphSpec,
    graph: Graph,
    nodes: Nodes,
    shapes: dict[NodeType, Shape],
    registry: Registry,
    kept: Mapping[str, Node],
    report: _Problems,
) -> None:
    names = nodes.of_graph.setdefault(spec.path, [])
    types: dict[str, NodeType | str] = {}
    for node in spec.nodes:
        path = f"{spec.path}/{node.name}"
        if path in nodes.drafts or path in nodes.broken:
            report(f'node "{node.name}" is written twice in graph {spec.path}; rename one', node.mark)
            continue
        if not NODE_NAME.fullmatch(node.name):
            report(f'"{node.name}" is not a node name; use letters, digits and underscores', node.mark)
        names.append(node.name)
        node_type = types.get(node.type) or types.setdefault(node.type, _node_type(node.type, nodes, registry))
        if isinstance(node_type, str):
            nodes.broken.add(path)
            report(f'node "{node.name}": {node_type}', node.mark)
            continue
        if node_type not in shapes:
            shapes[node_type] = Shape.of(node_type)
        index = len(nodes.drafts)
        old = None if shapes[node_type].deprecates else kept.get(path)
        if old is None or old.added or None in old.types.values():
            nodes.drafts[path] = draft_node(graph, node, node_type, shapes[node_type], index, report)
        else:
            fresh = Node(graph, node.name, node_type, index, node.mark)
            nodes.drafts[path] = Draft(fresh, node_type, node, dict(old.types), (), late=dict(old.late), kept=old)


def _node_type(name: str, nodes: Nodes, registry: Registry) -> NodeType | str:
    """The type with that name, or why it is unknown; with the nearest name for the first few of a file only."""
    if name in nodes.unknown:
        return nodes.unknown[name]
    try:
        return registry.get(name, suggest=len(nodes.unknown) < _SUGGESTED)
    except UnknownNodeTypeError as error:
        message = error.problems[0].message
        advice = "" if "did you mean" in message else f"; {SKIP_ADVICE}"
        return nodes.unknown.setdefault(name, message + advice)


def _variables(spec: GraphSpec, report: _Problems) -> Variables:
    types: dict[str, Type] = {}
    initial: dict[str, Any] = {}
    for name, variable in spec.variables.items():
        try:
            types[name] = concrete_type(variable.type)
            initial[name] = zero(types[name])
            if variable.value is not None:
                initial[name] = coerce(types[name], variable.value)
        except ValueError as error:
            report(f'variable "{name}": {error}', variable.mark)
    return Variables(types, initial)


def _deprecations(draft: Draft) -> list[Note]:
    return [
        ("deprecated-attribute", draft.node.path, f"{full} is deprecated: {instead}")
        for full in (*draft.authored, *draft.fed)
        if (instead := draft.attribute(full).deprecated) and not draft.attribute(full).warns_itself
    ]
