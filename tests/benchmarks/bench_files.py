"""Large graphs from files and from Python: against the standard library's JSON, and against YAML events alone."""

import json
import tempfile
from collections.abc import Iterable
from pathlib import Path

from measure import Row, ratio, seconds

from graph import Controller
from graph.isaac.og import GraphSet

TITLE = "large graphs: text to specification, USD and the Controller to graphs that run"
ADD = "omni.graph.nodes.Add"
COUNTER = "omni.graph.action.Counter"
DELAY = "omni.graph.action.Delay"


def document(nodes: int) -> dict:
    """A chain of `nodes` nodes, two values each, all connected."""
    return {
        "tickgraph": 1,
        "graphs": {
            "/World/Graph": {
                "nodes": {f"n{i}": {"type": ADD, "inputs": {"a": i, "b": 1.5}} for i in range(nodes)},
                "connections": [f"n{i}.sum -> n{i + 1}.a" for i in range(nodes - 1)],
            }
        },
    }


def as_yaml(tree: dict) -> str:
    """The document as people write it: one line for each node and connection."""
    graph = tree["graphs"]["/World/Graph"]
    nodes = "".join(f"      {name}: {json.dumps(node)}\n" for name, node in graph["nodes"].items())
    connections = "".join(f"      - {text}\n" for text in graph["connections"])
    return f"tickgraph: 1\ngraphs:\n  /World/Graph:\n    nodes:\n{nodes}    connections:\n{connections}"


def as_usd(nodes: int) -> str:
    """A chain of `nodes` nodes, all connected, as a scene saves it."""
    marked = "(customData = {bool isExecution = 1})"
    lines = ["#usda 1.0", 'def OmniGraph "G" {', 'token evaluator:type = "execution"']
    for i in range(nodes):
        lines += [
            f'def OmniGraphNode "n{i}" {{',
            'token node:type = "omni.graph.action.Counter"',
            "int node:typeVersion = 2",
            f"custom uint inputs:execIn {marked}",
            f"prepend uint inputs:execIn.connect = </G/n{i - 1}.outputs:execOut>" if i else "",
            f"custom uint outputs:execOut {marked}",
            "custom int outputs:count",
            "}",
        ]
    return "\n".join([*lines, "}"])


def in_one_edit(nodes: int) -> None:
    """A chain of `nodes` action nodes by one call of the Controller."""
    keys = Controller.Keys
    Controller(graphs=GraphSet()).edit(
        {"graph_path": "/G", "evaluator_name": "execution"},
        {
            keys.CREATE_NODES: [(f"n{i}", COUNTER) for i in range(nodes)],
            keys.CONNECT: [(f"n{i}.outputs:execOut", f"n{i + 1}.inputs:execIn") for i in range(nodes - 1)],
        },
    )


def in_single_edits(edits: int) -> None:
    """A chain of action nodes by `edits` calls: each node is created, given a value and connected."""
    keys = Controller.Keys
    control = Controller(graphs=GraphSet())
    graph = control.edit({"graph_path": "/G", "evaluator_name": "execution"})[0]
    for i in range(edits // 3):
        control.create_node(f"/G/n{i}", DELAY)
        control.edit(graph, {keys.SET_VALUES: [(f"n{i}.inputs:duration", float(i))]})
        if i:
            control.connect(f"/G/n{i - 1}.outputs:finished", f"/G/n{i}.inputs:execIn")


def sums_by_single_edits(nodes: int) -> None:
    """A chain of sums: `nodes` of them created, connected, set and deleted again, each by a call of its own."""
    control = Controller(graphs=GraphSet())
    graph = control.edit("/G")[0]
    control.create_node("/G/one", "omni.graph.nodes.ConstantDouble")
    for i in range(nodes):
        control.create_node(f"/G/n{i}", "omni.graph.nodes.Add")
        source = f"/G/n{i - 1}.outputs:sum" if i else "/G/one.inputs:value"
        control.connect(source, f"/G/n{i}.inputs:a")
        control.set(f"/G/n{i}.inputs:b", 1.0)
    control.evaluate_sync(graph)
    for i in reversed(range(nodes)):
        control.delete_node(f"/G/n{i}")


def measure(quick: bool) -> Iterable[Row]:
    """Seconds of JSON, USD and the Controller, milliseconds a node of YAML; ratios to what the text alone costs."""
    from ruamel.yaml import YAML

    from graph import load_graph
    from graph.files import loads

    loads("tickgraph: 1\n")  # imports what is needed
    nodes = 2_000 if quick else 100_000
    text = json.dumps(document(nodes))
    yield Row(f"JSON, {nodes:,} nodes", seconds(lambda: loads(text, name="a.json")), 10.0, "s")
    with tempfile.TemporaryDirectory() as folder:
        one, scene = Path(folder, "one.usda"), Path(folder, "scene.usda")
        one.write_text(as_usd(1))
        scene.write_text(as_usd(nodes))
        load_graph(one)  # imports what is needed
        yield Row(f"USD, {nodes:,} nodes, read and compiled", seconds(lambda: load_graph(scene)), 10.0, "s")
    in_one_edit(2)  # imports what is needed
    in_single_edits(6)
    yield Row(f"Controller, {nodes:,} nodes in one edit", seconds(lambda: in_one_edit(nodes)), 10.0, "s")
    edits = 120 if quick else 6_000
    few, many = seconds(lambda: in_single_edits(edits // 3)) * 3, seconds(lambda: in_single_edits(edits))
    yield Row(f"Controller, {edits:,} single edits, each", many / edits * 1e3, 1.0, "ms")
    yield Row(f"Controller, an edit of {edits:,} / of {edits // 3:,}", many / few, 2.0)
    sums_by_single_edits(2)
    few, many = (
        seconds(lambda: sums_by_single_edits(edits // 12)) * 3,
        seconds(lambda: sums_by_single_edits(edits // 4)),
    )
    yield Row(f"Controller, {edits:,} single edits of sums, each", many / edits * 1e3, 1.5, "ms")
    yield Row(f"Controller, an edit of sums of {edits:,} / of {edits // 3:,}", many / few, 2.5)
    small = json.dumps(document(5_000))
    yield Row("JSON, against json.loads", ratio(lambda: loads(small, name="a.json"), lambda: json.loads(small), 5))
    lines = 100 if quick else 2_000
    written = as_yaml(document(lines))
    yield Row(f"YAML, {lines:,} nodes", seconds(lambda: loads(written)) / lines * 1e3, 0.6, "ms/node")

    def events() -> None:
        for _ in YAML(typ="safe", pure=True).parse(written):
            pass

    yield Row("YAML, against its events alone", ratio(lambda: loads(written), events, 3, 1))
