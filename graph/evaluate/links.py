"""The connections of compiled graphs, node to node: for reports, checks and users' own analyses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass

if TYPE_CHECKING:
    from .graph import Graph
    from .node import Node


@dataclass(frozen=True, slots=True)
class Link:
    """One connection; attribute names without prefix."""

    source: Node
    output: str
    target: Node
    input: str
    execution: bool


def links_of(graphs: Iterable[Graph]) -> Iterator[Link]:
    """Every connection of these graphs, in file order, except those to nodes of other graphs."""
    graphs = list(graphs)
    nodes = {node.path: node for graph in graphs for node in graph.nodes.values()}
    for graph in graphs:
        for connection in graph.spec.connections:
            source = _end(nodes, graph.path, connection.source, ("outputs", "inputs", "state"))
            target = _end(nodes, graph.path, connection.target, ("inputs", "state"))
            if source and target:
                (at, output), (to, name) = source, target
                execution = to.attribute(name).is_execution
                yield Link(at, output.partition(":")[2], to, name.partition(":")[2], execution)


def _end(nodes: dict[str, Node], graph: str, text: str, sides: Sequence[str]) -> tuple[Node, str] | None:
    name, _, attribute = text.rpartition(".")
    owner, _, last = name.rpartition(".")
    places = (name, f"{owner}/{last}") if name.startswith("/") else (f"{graph}/{name}",)
    node = next((nodes[place] for place in places if place in nodes), None)
    if node is None:
        return None
    given, _, short = attribute.partition(":")
    if given not in ("inputs", "outputs", "state") or not short:
        short = attribute
    else:
        sides = (given,)
    return next(((node, f"{side}:{short}") for side in sides if short in node.names[side]), None)


def to_networkx(graphs: Iterable[Graph]) -> Any:
    """Graphs as one `networkx.MultiDiGraph`.

    Nodes are node paths, with the attributes `graph` (path), `name` and `type` (id); edges are connections from source
    to target, with `output`, `input` (names without prefix) and `execution` (bool; False: data).
    """
    import networkx

    graphs = list(graphs)
    network = networkx.MultiDiGraph()
    for graph in graphs:
        for node in graph.nodes.values():
            network.add_node(node.path, graph=graph.path, name=node.name, type=node.type.id)
    for link in links_of(graphs):
        network.add_edge(
            link.source.path, link.target.path, output=link.output, input=link.input, execution=link.execution
        )
    return network
