"""Everything that can be said about a graph file before it runs, as plain data: the JSON of `graph explain`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.exact import shortest
from graph.session.graph_links import Links

from .explain_clocks import MOST_PLANNED_UPDATES, clock_facts, duration_of, plan_updates, updates_of
from .explain_run import observe
from .explain_sensors import sensors_of
from .explain_topics import topic_facts
from .explain_traps import find_traps

if TYPE_CHECKING:
    from graph.evaluate import Graph
    from graph.session.open import Session
    from graph.sim.app import App

    from .explain_run import Observed


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


Part = tuple[str, str, Sequence[str], str]
"""Part of the run, where, the names of what is left out there (none: all of it), why."""


def left_out(
    session: Session, seen: Observed, sensors: Sequence[Mapping[str, Any]], topics: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Everything that is left out, as JSON data, of an App that plays its first updates."""
    app = session.app
    parts = [*_physics(app), *_casts(app, seen, sensors), *_channels(sensors), *_poses(app), *_messages(topics)]
    return [{"part": part, "where": where, "names": [*names], "why": why} for part, where, names, why in parts]


def _physics(app: App) -> Iterator[Part]:
    from graph.sim.geometry.collect import visible_prims

    if app.physics is None:
        yield "physics", "/", (), "nothing on the stage can move: no model, no steps"
        return
    colliders = {collider.path.partition("[")[0] for collider in app.physics.world.colliders}
    names = [path for _, path in visible_prims(app.stage) if path not in colliders]
    if names and app.mjcf is None:
        yield "physics", "/", names, "no colliders"


def _casts(app: App, seen: Observed, sensors: Sequence[Mapping[str, Any]]) -> Iterator[Part]:
    from graph.sim.renderer.wrapper import unwrapped
    from sensors.raycast.shared import cast_world

    if not seen.products and not app.rendering.polled:
        yield "casts", "/", (), "no sensor is rendered or polled: no structure for rays, no cast"
    for sensor in sensors:
        if sensor.get("product") is None or not sensor["channels"]:
            continue
        runtime: Any = unwrapped(seen.products[sensor["product"]].sensor)
        if math.isfinite(runtime.reach):
            world = cast_world(app.world)
            names = [
                world.surfaces[number].path for number in world.standing.beyond(runtime.pose()[:3, 3], runtime.reach)
            ]
            if names:
                yield "casts", sensor["path"], names, f"beyond its range of {shortest(runtime.reach)} m"


def _channels(sensors: Sequence[Mapping[str, Any]]) -> Iterator[Part]:
    from sensors.sensor_types import sensor_type

    for sensor in sensors:
        kind = sensor_type(sensor["type"])
        if kind is None or kind.read_by:
            continue
        if not sensor["product"]:
            yield "sensors", sensor["path"], (), "no render product: no cast, no frame"
        elif not sensor["channels"]:
            yield "channels", sensor["path"], (), "nothing reads it: its frames are empty"
        elif names := [one.name for one in kind.channels if one.name not in sensor["channels"]]:
            yield "channels", sensor["path"], names, "nothing reads them"


def _poses(app: App) -> Iterator[Part]:
    if app.physics is not None and not app.phases["physics_post_step"]:
        yield "poses", "/", (), "copied only for a sensor that is due: nothing reads them after every physics step"


def _messages(topics: Sequence[Mapping[str, Any]]) -> Iterator[Part]:
    names = [topic["topic"] for topic in topics if not topic["heard_in_file"]]
    if not topics:
        yield "messages", "/", (), "nothing publishes"
    elif names:
        yield "messages", "/", names, "made only for a recording or a live transport: nothing in the file subscribes"
