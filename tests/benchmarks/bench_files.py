"""Reading large graph files: against the standard library's JSON, and against YAML events alone."""

import json
import tempfile
from collections.abc import Iterable
from pathlib import Path

from measure import Row, ratio, seconds

TITLE = "graph files: text to specification"
ADD = "omni.graph.nodes.Add"


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


def measure(quick: bool) -> Iterable[Row]:
    """Seconds of JSON and USD, milliseconds a node of YAML; ratios to json.loads and to bare YAML events."""
    from ruamel.yaml import YAML

    from graph import load_graph
    from graph.files import loads

    loads("tickgraph: 1\n")  # imports what is needed
    nodes = 20_000 if quick else 100_000
    text = json.dumps(document(nodes))
    yield Row(f"JSON, {nodes:,} nodes", seconds(lambda: loads(text, name="a.json")), 10.0, "s")
    with tempfile.TemporaryDirectory() as folder:
        one, scene = Path(folder, "one.usda"), Path(folder, "scene.usda")
        one.write_text(as_usd(1))
        scene.write_text(as_usd(nodes))
        load_graph(one)  # imports what is needed
        yield Row(f"USD, {nodes:,} nodes, read and compiled", seconds(lambda: load_graph(scene)), 10.0, "s")
    small = json.dumps(document(5_000))
    yield Row("JSON, against json.loads", ratio(lambda: loads(small, name="a.json"), lambda: json.loads(small), 5))
    lines = 500 if quick else 2_000
    written = as_yaml(document(lines))
    yield Row(f"YAML, {lines:,} nodes", seconds(lambda: loads(written)) / lines * 1e3, 0.6, "ms/node")

    def events() -> None:
        for _ in YAML(typ="safe", pure=True).parse(written):
            pass

    yield Row("YAML, against its events alone", ratio(lambda: loads(written), events, 3, 1))
