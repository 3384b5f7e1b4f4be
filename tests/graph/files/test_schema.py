import json
from pathlib import Path

import pytest

from graph.base.errors import UserError
from graph.cli.main import main
from graph.files import json_schema, loads
from graph.files.prim_schema import PRIM
from graph.node import registry
from tests.support.without_wing import MISSING_EXAMPLES

jsonschema = pytest.importorskip("jsonschema")
ROOT = Path(__file__).parents[3]

GOOD = [
    {},
    {"scene": None, "clock": None, "graphs": None, "settings": None, "fidelity": None, "record": None},
    {"scene": {"prims": {"/World/Box": {"type": "Cube", "size": 1.0, "translate": [5, 0, 0.5]}, "/A": None}}},
    {"clock": {"physics_hz": "1000/3", "loop_hz": 59.94, "experience": "full", "parity": "isaacsim-6.0.1"}},
    {"duration": "1/240"},
    {"settings": {"/a/b": [1, "x", True], "/c": 2.5}},
    {"fidelity": {"lidar.motion": "frozen", "physics.hz": 240, "fabric": "on", "mesh.tolerance": 0.01}},
    {"graphs": {"/G": None, "/H": {"evaluator": "push", "pipeline_stage": "post_render", "nodes": None}}},
    {"graphs": {"/G": {"nodes": {"a": "OnPlaybackTick", "b": {"type": "Countdown", "inputs": {"duration": 5}}}}}},
    {"graphs": {"/G": {"variables": {"v": {"type": "double"}}, "connections": ["a.x -> b.y", "a.x->[b.y, c.z]"]}}},
    {"record": {"mcap": "a/b.mcap"}},
]
BAD = [
    {"tickgraph": 2},
    {"graph": {}},
    {"scene": {"usd": 5}},
    {"clock": {"loop_hz": 0}},
    {"clock": {"loop_hz": "fast"}},
    {"clock": {"experience": "quick"}},
    {"settings": {"/a": {}}},
    {"fidelity": {"tlas": []}},
    {"graphs": {"G": {}}},
    {"graphs": {"/G": {"nodes": {"a": 5}}}},
    {"graphs": {"/G": {"nodes": {"a": {"inputs": {}}}}}},
    {"graphs": {"/G": {"connections": ["a -> b"]}}},
    {"graphs": {"/G": {"connections": "a.x -> b.y"}}},
    {"graphs": {"/G": {"variables": {"v": {}}}}},
    {"record": {"mcap": 1}},
]


@pytest.fixture(scope="module")
def printed():
    """What `graph schema` prints."""
    import contextlib
    import io

    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main(["schema"]) == 0
    return json.loads(out.getvalue())


@pytest.fixture(params=["bare", "printed"], scope="module")
def validator(request, printed):
    schema = json_schema() if request.param == "bare" else printed
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("tree", GOOD, ids=json.dumps)
def test_what_the_loader_takes_fits_the_schema(validator, tree):
    tree = {"tickgraph": 1, **tree}
    loads(json.dumps(tree), name="a.json")
    assert list(validator.iter_errors(tree)) == []


@pytest.mark.parametrize("tree", BAD, ids=json.dumps)
def test_what_the_loader_refuses_does_not_fit_the_schema(validator, tree):
    tree = {"tickgraph": 1, **tree}
    with pytest.raises(UserError):
        loads(json.dumps(tree), name="a.json")
    assert not validator.is_valid(tree)


@pytest.mark.parametrize(
    "nodes",
    [
        {"a": {"type": "Countdown", "inputs": {"duration": "five"}}},
        {"a": {"type": "omni.graph.action.Countdown", "inputs": {"duration": 1.5}}},
    ],
)
def test_values_of_known_inputs_are_described(printed, nodes):
    assert not jsonschema.Draft202012Validator(printed).is_valid({"tickgraph": 1, "graphs": {"/G": {"nodes": nodes}}})


def test_an_editor_finds_every_type_input_knob_and_setting(printed):
    names = {one.get("const") for one in printed["$defs"]["NodeType"]["anyOf"]}
    assert {one.id for one in registry.all()} <= names
    assert {"Countdown", "OnPlaybackTick"} <= names
    [countdown] = [
        rule["then"]["properties"]["inputs"]["properties"]
        for rule in printed["$defs"]["Node"]["allOf"]
        if "Countdown" in rule["if"]["properties"]["type"]["enum"]
    ]
    assert countdown["duration"]["type"] == "integer"
    assert countdown["duration"]["default"] == 5
    assert "execIn" not in countdown
    fidelity = printed["properties"]["fidelity"]["anyOf"][0]
    assert fidelity["properties"]["lidar.motion"]["enum"] == ["frozen", "update", "continuous"]
    assert not fidelity["additionalProperties"]
    assert "/rtx/hydra/supportMultiTickRate" in printed["properties"]["settings"]["anyOf"][0]["properties"]


def test_an_editor_finds_sensor_configurations_and_prim_types(printed):
    prims = printed["$defs"]["Scene"]["properties"]["prims"]["anyOf"][0]["additionalProperties"]["anyOf"][0]
    assert {"OS1", "Example_Rotary", "XT32"} <= {*prims["properties"]["config"]["anyOf"][0]["enum"]}
    assert {"OmniLidar", "Cube", "PhysicsRevoluteJoint", "DomeLight"} <= {*prims["properties"]["type"]["enum"]}
    assert PRIM["properties"]["config"]["type"] == "string"


def _prim(**keys):
    return {"tickgraph": 1, "scene": {"prims": {"/World/A": keys}}}


def _node(node):
    return {"tickgraph": 1, "graphs": {"/G": {"nodes": {"a": node}}}}


@pytest.mark.parametrize(
    "tree",
    [
        _prim(type="OmniLidar", config="my_profile.json"),
        _prim(type="OmniLidar", config="OS1", variant={"Product": "OS1"}),
        _node("my.package.Node"),
        _node({"type": "my.package.Node", "inputs": {"anything": 1}}),
        _node("OgnCountdown"),
        _node("omni.isaac.core_nodes.IsaacReadSimulationTime"),
        _node({"type": "Countdown", "inputs": {"inputs:duration": 5}}),
        _node({"type": "Countdown", "attributes": {"inputs:own": "int"}, "inputs": {"own": 5}}),
        _node({"type": "Add", "inputs": {"a": 1, "c": 3}}),
        _node({"type": "isaacsim.ros2.bridge.ROS2PublishTransformTree", "inputs": {"targetPrim": "/World"}}),
    ],
    ids=json.dumps,
)
def test_own_types_added_inputs_and_former_names_pass(printed, tree):
    assert list(jsonschema.Draft202012Validator(printed).iter_errors(tree)) == []


@pytest.mark.parametrize(
    "tree",
    [
        _prim(type="OmniLidr"),
        _prim(type="OmniLidar", config="OS11"),
        _node("Countdwn"),
        _node("omni.graph.action.Countdwn"),
        _node({"type": "isaacsim.core.nodes.NoSuchNode"}),
        _node({"type": "Countdown", "inputs": {"duraton": 5}}),
        _node({"type": "OgnCountdown", "inputs": {"duraton": 5}}),
        _node({"type": "Add", "inputs": {"count": 5}}),
    ],
    ids=json.dumps,
)
def test_an_editor_underlines_a_misspelt_type_input_or_configuration(printed, tree):
    assert not jsonschema.Draft202012Validator(printed).is_valid(tree)


def test_shipped_graphs_and_templates_fit_the_schema(printed):
    from ruamel.yaml import YAML

    validator = jsonschema.Draft202012Validator(printed)
    files = [*(ROOT / "graphs").glob("*.yaml"), *(ROOT / "graph" / "cli" / "templates").glob("*.yaml")]
    trees = {file.name: YAML(typ="safe").load(file) for file in files if file.stem not in MISSING_EXAMPLES}
    graphs = {name: tree for name, tree in trees.items() if "graphs" in tree}
    assert len(graphs) > 20
    assert {name: error.json_path for name, tree in graphs.items() for error in validator.iter_errors(tree)} == {}


def test_the_keys_of_prims_are_those_that_the_world_knows():
    from graph.sim.scene.prim_keys import KEYS

    assert set(PRIM["properties"]) == set(KEYS)


def test_every_key_has_a_description():
    def undescribed(name, schema):
        if name and "description" not in schema and "$ref" not in schema:
            yield name
        for key, part in schema.get("properties", {}).items():
            if "$ref" not in json.dumps(part):
                yield from undescribed(key, part)

    schema = json_schema()
    parts = {"": schema, **schema["$defs"], "prim": PRIM}
    assert [name for part in parts.values() for name in undescribed("", part)] == []
