"""Every node type comes with an example that can be typed in as it is."""

import pytest

from graph import RunError, registry
from graph.assembly import build_parts, open_session
from graph.example import example
from graph.files import loads

ALL = registry.all()
NEEDS_MORE = {"AddPrimRelationship", "SetPrimActive", "ToTarget"}
"""Types of OmniGraph itself that need a path which no example can know."""


@pytest.mark.parametrize("node_type", ALL, ids=lambda one: one.short_name)
def test_the_example_is_a_graph_file_without_problems(node_type):
    spec = loads(example(node_type))
    parts = build_parts(spec)
    assert parts.problems == []
    [node] = [one for one in parts.graphs[0].nodes.values() if one.type is node_type][:1]
    assert node.type.has_execution == (parts.graphs[0].evaluator == "execution")


def test_examples_run_or_say_in_one_line_what_they_need():
    """Robots, wheels, frames of sensors and names of message types are more than an example can make up."""
    failed = {}
    for node_type in ALL:
        with open_session(loads(example(node_type)), allow_scripts=True).app as app:
            try:
                app.play()
                app.update(2)
            except RunError as error:
                failed[node_type.id] = str(error)
    assert {one.rpartition(".")[2] for one in failed if one.startswith("omni.graph.")} == NEEDS_MORE
    assert all("\n" not in message for message in failed.values())
    assert len(failed) < len(ALL) / 5


def test_the_example_of_a_node_with_control_flow():
    assert example(registry.get("Countdown")) == (
        "tickgraph: 1\n"
        "graphs:\n"
        "  /World/Graph:\n"
        "    nodes:\n"
        "      tick: OnPlaybackTick\n"
        "      countdown:\n"
        "        type: omni.graph.action.Countdown\n"
        "        inputs:\n"
        "          duration: 5  # updates until `finished` [updates]\n"
        "          period: 1  # updates between two `tick`s [updates]\n"
        "      count: Counter\n"
        "    connections:\n"
        "      - tick.tick -> countdown.execIn\n"
        "      - countdown.tick -> count.execIn\n"
    )


def test_open_inputs_get_values_that_go_together():
    text = example(registry.get("CrossProduct"))
    assert 'a: {type: "vectord[3]", value: [1.0, 2.0, 3.0]}' in text
    assert "evaluator: push" in text


def test_the_command_prints_it(capsys):
    from graph.cli.main import main

    assert main(["node", "Add"]) == 0
    assert "        type: omni.graph.nodes.Add" in capsys.readouterr().out
