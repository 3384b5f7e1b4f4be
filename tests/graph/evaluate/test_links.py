"""Graphs as networks, for people's own analyses."""

import subprocess
import sys

import networkx

from graph import load_graph
from tests.support.places import ROOT

TEXT = """\
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      two: {type: ConstantDouble, inputs: {value: 2.0}}
      sum: Add
      print: {type: WriteVariable, inputs: {variableName: total}}
    variables: {total: {type: double, value: 0.0}}
    connections:
      - tick.tick -> print.execIn
      - two.inputs:value -> sum.a
      - tick.outputs:time -> sum.b
      - sum.sum -> print.value
  /World/H:
    evaluator: push
    nodes: {twice: Add}
    connections:
      - /World/G/sum.sum -> twice.a
      - /World/G.sum.sum -> twice.b
"""


def test_a_loaded_file_becomes_a_network(tmp_path):
    (tmp_path / "g.yaml").write_text(TEXT)
    loaded = load_graph(tmp_path / "g.yaml")
    network = loaded.to_networkx()
    assert isinstance(network, networkx.MultiDiGraph)
    assert network.nodes["/World/G/tick"] == {
        "graph": "/World/G", "name": "tick", "type": "omni.graph.action.OnPlaybackTick",
    }  # fmt: skip
    edges = [(a.rpartition("/")[2], b.rpartition("/")[2], *data.values()) for a, b, data in network.edges(data=True)]
    assert sorted(edges) == [
        ("sum", "print", "sum", "value", False),
        ("sum", "twice", "sum", "a", False),
        ("sum", "twice", "sum", "b", False),
        ("tick", "print", "tick", "execIn", True),
        ("tick", "sum", "time", "b", False),
        ("two", "sum", "value", "a", False),
    ]
    alone = loaded.graph("/World/G").to_networkx()
    assert networkx.dag_longest_path(networkx.DiGraph(alone))[-1] == "/World/G/print"


def test_a_run_does_not_load_networkx():
    code = "from graph.testing import run_graph; run_graph('graphs/quickstart.yaml', updates=1)"
    look = f"{code}; import sys; print('networkx' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", look], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
