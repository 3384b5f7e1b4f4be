import json

import pytest

from graph.base.errors import UserError
from graph.cli.main import main
from graph.files import json_schema, loads
from graph.files.prim_schema import PRIM
from graph.node import registry

jsonschema = pytest.importorskip("jsonschema")

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


@pytest.fixture(params=["bare", "printed"])
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


def test_an_editor_finds_sensor_configurations_and_prim_types_and_takes_others(printed):
    prims = printed["$defs"]["Scene"]["properties"]["prims"]["anyOf"][0]["additionalProperties"]["anyOf"][0]
    offered = {key: prims["properties"][key]["anyOf"][0]["enum"] for key in ("config", "type")}
    assert {"OS1", "Example_Rotary", "XT32"} <= {*offered["config"]}
    assert {"OmniLidar", "Cube", "PhysicsRevoluteJoint"} <= {*offered["type"]}
    own = {"/L": {"type": "OmniLidar", "config": "my_profile.json"}, "/D": {"type": "DomeLight"}}
    assert jsonschema.Draft202012Validator(printed).is_valid({"tickgraph": 1, "scene": {"prims": own}})
    assert "anyOf" not in PRIM["properties"]["config"]


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
