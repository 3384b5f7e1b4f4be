"""The shape of graphs: their longest chain of nodes, and their cycles."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graph.evaluate import Graph


def graph_facts(graphs: Iterable[Graph]) -> list[dict[str, Any]]:
    """For each graph: path, evaluator, stage, counts of nodes and connections, the longest chain, its cycles.

    longest_chain: names of nodes, each of which waits for the one before, by data or execution; the nodes of a cycle
    count as one. cycles: one for each group of nodes that reach each other, as names in the direction of the
    connections, with the first repeated at the end.
    """
    import networkx

    facts = []
    for graph in graphs:
        network = graph.to_networkx()
        parts = networkx.condensation(networkx.DiGraph(network))
        members = parts.nodes(data="members")
        chain = [min(members[part], key=_position(graph)) for part in networkx.dag_longest_path(parts)]
        rounds = [found for found in networkx.strongly_connected_components(network) if len(found) > 1]
        facts.append(
            {
                "path": graph.path,
                "evaluator": graph.evaluator,
                "stage": graph.pipeline_stage,
                "nodes": len(graph.nodes),
                "connections": network.number_of_edges(),
                "longest_chain": [_name(graph, path) for path in chain],
                "cycles": [_cycle(graph, network.subgraph(found)) for found in rounds],
            }
        )
    return facts


def _cycle(graph: Graph, part: Any) -> list[str]:
    """One cycle in a part of a network whose nodes all reach each other."""
    import networkx

    first = min(part, key=_position(graph))
    edges = [edge[0] for edge in networkx.find_cycle(part, first)]
    return [_name(graph, path) for path in (*edges, edges[0])]


def _position(graph: Graph) -> Any:
    return {node.path: place for place, node in enumerate(graph.nodes.values())}.__getitem__


def _name(graph: Graph, path: str) -> str:
    return path.removeprefix(f"{graph.path}/")
