"""Warnings of `graph check` and of a run about graphs that compile but do not do what they seem to do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

from graph.node.declaration import NEVER_FIRES, PHYSICS_STEP
from graph.plan.order import cycles

from .graph_links import Links, link_notes
from .runner import frame_entries, runs_by_itself

if TYPE_CHECKING:
    from graph.evaluate import Graph, Node
    from graph.node.declaration import NodeType
    from graph.spec.file_spec import Note

MOST_CYCLES = 8
"""Most cycles of one graph that are named."""
MOST_LINKED_NODES = 512
"""Above this many nodes, connections are checked by `graph explain` only, because fan-outs are compared in pairs."""
SHOWN = 12
"""Most nodes of a cycle that are named."""


def graph_notes(graphs: Iterable[Graph]) -> Iterator[Note]:
    """Warnings: graphs that nothing evaluates, empty frames, cycles of execution wires that never end, `link_notes`."""
    graphs = list(graphs)
    for graph in graphs:
        if why := _never_runs(graph):
            yield "graph-never-runs", str(graph.mark or graph.path), f"graph {graph.path} never runs: {why}"
        yield from _empty_frames(graph)
        yield from _missed_steps(graph)
        if graph.evaluator == "execution":
            yield from _execution_cycles(graph)
    if sum(len(graph.nodes) for graph in graphs) <= MOST_LINKED_NODES:
        yield from link_notes(Links(graphs))


def _never_runs(graph: Graph) -> str:
    """Why nothing starts a graph; "" if something starts it or if it has nothing to compute."""
    if not any(node.type.compute is not None for node in graph.nodes.values()):
        return ""
    if graph.pipeline_stage == "on_demand":
        phases = {node.type.phase for node in graph.nodes.values()} - {""}
        return "" if phases else "on_demand graphs wait for a node such as OnPhysicsStep, or for a script; add one"
    if runs_by_itself(graph) or any(node.type.phase for node in graph.nodes.values()):
        return ""
    if graph.pipeline_stage == "post_render":
        if any(frame_entries(graph)):
            return ""
        return "no node of it is started by a frame; leave the execution input of a node with a render product open"
    return "it has no event node; add one, such as OnPlaybackTick"


def idle_nodes(graph: Graph) -> Iterator[Note]:
    """A warning for each node whose execution inputs are all unconnected; tests and scripts may trigger it."""
    if graph.evaluator != "execution" or _never_runs(graph):
        return
    by_frames = {node for node, *_ in frame_entries(graph)} if graph.pipeline_stage == "post_render" else set()
    for node in graph.nodes.values():
        entries = [name for name, attribute in node.type.inputs.items() if attribute.is_execution]
        if not entries or node.type.event is not None or node in by_frames:
            continue
        if not any(node.connected(name) for name in entries):
            what = f"nothing is connected to its {' or '.join(entries[:3])}"
            yield "node-never-runs", str(node.mark or node.path), f"node {node.path} never runs: {what}"


def _empty_frames(graph: Graph) -> Iterator[Note]:
    """Publishers whose messages would name no coordinate frame, though their type has a default one."""
    for node in graph.nodes.values():
        for name in node.type.inputs_as("frame"):
            if node.type.inputs[name].initial and not node.connected(name) and not node.get(name):
                yield (
                    "frame-empty",
                    f"{node.path}.inputs:{name}",
                    "it is empty, so that TF cannot place the messages; name a frame",
                )


def _missed_steps(graph: Graph) -> Iterator[Note]:
    """Events of physics steps in a graph that is not evaluated in them."""
    if graph.pipeline_stage == "on_demand":
        return
    for node in graph.nodes.values():
        if node.type.phase == PHYSICS_STEP:
            yield "physics-step-stage", node.path, NEVER_FIRES.format(stage=graph.pipeline_stage)


def _execution_cycles(graph: Graph) -> Iterator[Note]:
    """Cycles of nodes that all pass execution on: no wait, one execution input, one execution output."""
    passing = [node for node in graph.nodes.values() if _passes_on(node)]
    number = {node: position for position, node in enumerate(passing)}
    readers = [
        [number[step[0]._node] for wire in node.db._wires.values() for step in wire.targets if step[0]._node in number]
        for node in passing
    ]
    for cycle in cycles(len(passing), readers, most=MOST_CYCLES):
        names = [passing[one].name for one in (*cycle, cycle[0])]
        shown = names if len(names) <= SHOWN else [*names[: SHOWN // 2], "...", *names[-SHOWN // 2 :]]
        yield (
            "execution-cycle",
            str(passing[cycle[0]].mark or passing[cycle[0]].path),
            f"graph {graph.path}: execution goes round ({' -> '.join(shown)}) and nothing on the way decides or waits; "
            "lead it through SendCustomEvent and OnCustomEvent, which go on in the next update, or use ForLoop",
        )


def _passes_on(node: Node) -> bool:
    added = any(attribute.is_execution for attribute in node.added.values())
    return not added and len(node.db._wires) == 1 and _has_one_entry(node.type)


@lru_cache(maxsize=1024)
def _has_one_entry(node_type: NodeType) -> bool:
    return not node_type.latent and sum(attribute.is_execution for attribute in node_type.inputs.values()) == 1
