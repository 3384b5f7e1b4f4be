"""Malformed paths reach every node type that takes a path at run time: USD prints nothing about its own source."""

import json

import pytest

from graph import ComputeError
from graph.files import loads
from graph.node import registry
from graph.plan import compile_graphs
from graph.session.runner import GraphRunner
from graph.testing import run_node
from graph.values.types import Extended

NO_PATH = "/Wo-rld/x y"
ALSO = {
    "usePath": True,
    "variableName": "v",
    "condition": True,
    "value": {"type": "double", "value": 1.0},
    "input0": {"type": "token", "value": "a"},
}
"""What some of the types do not come to their paths without."""
HALVES = {
    "IsaacCreateRenderProduct": "cameraPrim",
    "GetParentPrims": "prims",
    "IsaacArticulationController": "robotPath",
}
"""Types that read paths in three ways: rendered, as texts, on the stage."""


def path_inputs(node_type):
    """The inputs of a type that name prims: targets, and texts called paths."""
    return {
        name: [NO_PATH] if attribute.type == "target" else NO_PATH
        for name, attribute in node_type.inputs.items()
        if attribute.type == "target" or (attribute.type in ("string", "token") and name.endswith("Path"))
    }


def _asked_for(attribute):
    """Whether an input that a type may have must be given for the type to compute."""
    return attribute is not None and (attribute.type in ("bool", "token") or isinstance(attribute.parsed, Extended))


TYPES = [one for one in registry.all() if path_inputs(one)]


@pytest.mark.parametrize("node_type", TYPES, ids=lambda one: one.id)
def test_an_invalid_path_prints_nothing_of_usds_own(world, capfd, node_type):
    needed = {name: value for name, value in ALSO.items() if _asked_for(node_type.inputs.get(name))}
    triggers = [name for name, attribute in node_type.inputs.items() if attribute.type == "execution"]
    text = json.dumps(
        {
            "nodes": {"tick": "OnTick", "n": {"type": node_type.id, "inputs": needed | path_inputs(node_type)}},
            "variables": {"v": {"type": "double"}},
            "connections": [f"tick.tick -> n.{name}" for name in triggers],
            "evaluator": "execution" if triggers else "push",
        }
    )
    app = world()
    graphs = compile_graphs(loads(f'{{"tickgraph": 1, "graphs": {{"/G": {text}}}}}', name="a.json").graphs)
    GraphRunner(app, graphs, on_error="continue")
    app.play()
    app.update(steps=2)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("node_type", [one for one in TYPES if one.short_name in HALVES], ids=lambda one: one.id)
def test_half_a_surrogate_pair_is_no_path(world, node_type):
    """A file cannot hold one; a script can hand it over."""
    name = HALVES[node_type.short_name]
    half = "/World/half\ud800"
    inputs = {name: [half] if node_type.inputs[name].type == "target" else half}
    triggers = {name: [0] for name, one in node_type.inputs.items() if one.type == "execution"}
    with pytest.raises(ComputeError, match=r"no prim /World/half|not an absolute path|/World/half\S* is not a robot"):
        run_node(node_type.id, inputs=inputs, pulses=triggers, updates=1, app=world())
