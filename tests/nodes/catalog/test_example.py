"""Every node type comes with an example that can be typed in as it is."""

import pytest

from graph import RunError
from graph.files import json_schema, loads
from graph.node import registry
from graph.session.open import build_parts, open_session
from nodes.catalog.example import example

ALL = registry.all()
VARIANTS = "a USD scene with a prim that has a variant set, named at prim and variantSetName"
PIPELINE = "SdOnNewFrame and SdOnNewRenderProductFrame before it"
NEEDS_MORE = {
    "DebugDrawRayCast": "a folder for its pictures: graph run --out",
    "GetCameraTarget": "a camera that SetCameraTarget or the editor has aimed",
    "GetVariantNames": VARIANTS,
    "GetVariantSelection": VARIANTS,
    "HolonomicRobotUsdSetup": "a robot in USD whose wheel joints have isaacmecanumwheel:radius and :angle",
    "IsaacConvertDepthToPointCloud": "an image of distances at dataPtr and the lens of its camera",
    "IsaacConvertRGBAToRGB": "an RGBA image at dataPtr",
    "IsaacReadCameraInfo": "the render product of a camera at renderProductPath",
    "IsaacReadFilePath": "a text file notes.txt beside this one",
    "SdFrameIdentifier": PIPELINE,
    "SdRenderVarPtr": PIPELINE,
    "SdRenderVarToRawArray": PIPELINE,
    "ScriptNode": "your leave to run its script: graph run --allow-scripts",
}
"""What no example can bring along."""


@pytest.mark.parametrize("node_type", ALL, ids=lambda one: one.short_name)
def test_the_example_is_a_graph_file_without_problems(node_type):
    spec = loads(example(node_type))
    parts = build_parts(spec)
    assert parts.problems == []
    [node] = [one for one in parts.graphs[0].nodes.values() if one.type is node_type][:1]
    assert node.type.has_execution == (parts.graphs[0].evaluator == "execution")


def test_what_an_example_needs_stands_in_its_first_line():
    first = {one.short_name: example(one).splitlines()[0] for one in ALL}
    assert {name: line for name, line in first.items() if line != "tickgraph: 1"} == {
        name: f"# Needs {needs}." for name, needs in NEEDS_MORE.items() if name in first
    }


def test_every_example_runs_and_only_those_that_need_more_or_are_of_age_warn(tmp_path):
    told = {}
    for node_type in ALL:
        spec = loads(example(node_type), folder=tmp_path)
        with open_session(spec, allow_scripts=node_type.runs_code).app as app:
            try:
                app.play()
                app.update(2)
            except RunError as error:
                told[node_type.id] = str(error)
            for warned in app.warnings:
                if warned.code != "node-deprecated" and node_type.short_name not in NEEDS_MORE:
                    told[node_type.id] = warned.message
    assert told == {}


@pytest.mark.parametrize(
    "name",
    [
        "IsaacComputeRTXLidarFlatScan",
        "OgnIsaacExtractRTXSensorPointCloud",
        "IsaacCreateRTXLidarScanBuffer",
        "IsaacAttachHydraTexture",
        "IsaacSetCameraOnRenderProduct",
        "IsaacJointNameResolver",
        "SetPrimActive",
        "WritePrimMaterial",
    ],
)
def test_what_follows_the_node_of_an_example_is_reached(name):
    with open_session(loads(example(registry.get(name)))).app as app:
        app.play()
        app.update(20)
        assert app.graphs["/World/Graph"].nodes["count"].get("count") > 0


def test_added_inputs_stand_in_the_example_of_a_message():
    lines = example(registry.get("ROS2Publisher")).splitlines()
    assert "          messageName: Point  # name of the type" in lines
    assert "          x: 1.5  # a field of the message; its type comes from the message type" in lines


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


def test_the_choices_of_every_example_are_choices_of_the_schema():
    rules = json_schema(ALL)["$defs"]["Node"]["allOf"]
    inputs_of = {
        name: rule["then"]["properties"]["inputs"]["properties"]
        for rule in rules
        for name in rule["if"]["properties"]["type"]["enum"]
    }
    checked = 0
    for node_type in ALL:
        node = loads(example(node_type)).graphs[0].nodes[-2 if "count: Counter" in example(node_type) else -1]
        for name, value in node.inputs.items():
            allowed = inputs_of[node_type.id].get(name, {}).get("enum")
            checked += allowed is not None
            assert allowed is None or value in allowed, (node_type.id, name)
    assert checked > 10
