"""Everything that can be said about a graph file before it runs, as plain data: the JSON of `graph explain`."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.session.graph_links import Links

from .explain_clocks import MOST_PLANNED_UPDATES, clock_facts, duration_of, plan_updates, updates_of
from .explain_run import observe
from .explain_sensors import sensors_of
from .explain_topics import topic_facts
from .explain_traps import find_traps
from .left_out import left_out

if TYPE_CHECKING:
    from graph.evaluate import Graph
    from graph.session.open import Session


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


def explain(session: Session, file: str | Path) -> dict[str, Any]:
    """Plays the first updates of a session (without casting rays) and plans the rest.

    Times and rates are exact numbers (int or Fraction) [s, Hz]. The App is left playing; the caller closes it.
    """
    app, updates = session.app, updates_of(session)
    links = Links(session.runner.graphs.values())
    seen = observe(session)
    planned = max(min(updates, MOST_PLANNED_UPDATES), len(seen.substeps))
    steps = list(islice(plan_updates(app), planned))
    sensors = sensors_of(app, seen, steps[: min(updates, planned)])
    topics = topic_facts(session)
    return {
        "file": str(file),
        "duration_s": duration_of(session),
        "updates": updates,
        "counted_updates": min(updates, MOST_PLANNED_UPDATES),
        "clocks": clock_facts(app, steps) | {"substeps": seen.substeps},
        "physics": None if app.physics is None else app.physics.facts(),
        "graphs": graph_facts(session.runner.graphs.values()),
        "sensors": sensors,
        "topics": topics,
        "left_out": left_out(session, seen, sensors, topics),
        "traps": [
            {"code": code, "where": where, "message": message}
            for code, where, message in find_traps(session, links, seen, sensors, steps)
        ],
    }
