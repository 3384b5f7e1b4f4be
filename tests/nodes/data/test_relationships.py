"""Relationships, variants, places and directions of prims; settings and the timeline."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from graph import ComputeError
from graph.testing import run_node


@pytest.fixture
def cube(stage):
    prim = UsdGeom.Cube.Define(stage, "/World/Cube").GetPrim()
    prim.CreateRelationship("friend").SetTargets(["/World/Other", "/World/Cube.size"])
    variants = prim.GetVariantSets().AddVariantSet("look")
    for name in ("plain", "shiny"):
        variants.AddVariant(name)
    variants.SetVariantSelection("shiny")
    return prim


CUBE = {"prim": "/World/Cube"}


@pytest.mark.parametrize(
    ("kind", "output", "inputs", "result"),
    [
        ("ReadPrimRelationship", "value", {"name": "friend"}, ["/World/Other", "/World/Cube.size"]),
        ("GetPrimRelationship", "paths", {"name": "friend"}, ["/World/Other", "/World/Cube.size"]),
        ("HasVariantSet", "exists", {"variantSetName": "look"}, True),
        ("HasVariantSet", "exists", {"variantSetName": "size"}, False),
        ("GetVariantSetNames", "variantSetNames", {}, ["look"]),
        ("GetVariantNames", "variantNames", {"variantSetName": "look"}, ["plain", "shiny"]),
        ("GetVariantSelection", "variantName", {"variantSetName": "look"}, "shiny"),
    ],
)
def test_what_a_prim_has_is_read(world, cube, kind, output, inputs, result):
    assert run_node(kind, inputs={**CUBE, **inputs}, app=world()).value(output) == result


@pytest.mark.parametrize(
    ("kind", "output"), [("GetVariantNames", "variantNames"), ("GetVariantSelection", "variantName")]
)
def test_no_name_of_a_variant_set_is_a_warning(world, cube, kind, output):
    trace = run_node(kind, inputs=CUBE, app=world())
    assert not trace.value(output)
    assert [one.code for one in trace.warnings] == ["variant-set-missing"]


@pytest.mark.parametrize(
    ("kind", "inputs", "message"),
    [
        ("ReadPrimRelationship", {"name": "foe"}, 'has no relationship "foe"'),
        ("ReadPrimRelationship", {}, "input name is empty"),
        ("GetVariantSelection", {"variantSetName": "size"}, 'has no variant set "size"; it has look'),
    ],
)
def test_what_it_has_not_fails(world, cube, kind, inputs, message):
    with pytest.raises(ComputeError, match=message):
        run_node(kind, inputs={**CUBE, **inputs}, app=world())


def test_a_missing_prim_is_warned_of(world):
    for kind in ("ReadPrimRelationship", "GetVariantSetNames", "WritePrimLocalTransform", "WritePrimRelationship"):
        pulses = {"execIn": [0]} if kind.startswith("Write") else {}
        trace = run_node(kind, inputs={"prim": "/Nowhere"}, pulses=pulses, app=world())
        assert [one.code for one in trace.warnings] == ["prim-missing"]


def test_a_relationship_is_written_and_made_where_it_is_missing(world, stage, cube):
    for name in ("friend", "fresh"):
        inputs = {**CUBE, "name": name, "value": ["/World/A"]}
        trace = run_node("WritePrimRelationship", inputs=inputs, pulses={"execIn": [0]}, app=world())
        assert trace.fired("execOut") == [0]
        assert [str(one) for one in cube.GetRelationship(name).GetTargets()] == ["/World/A"]


def test_a_relationship_goes_into_the_layer_asked_for(world, stage, cube):
    app = world()
    inputs = {**CUBE, "name": "fresh", "value": ["/World/A"], "layerIdentifier": "<Session Layer>"}
    run_node("WritePrimRelationship", inputs=inputs, pulses={"execIn": [0]}, app=app)
    assert stage.GetSessionLayer().GetRelationshipAtPath("/World/Cube.fresh")
    assert not stage.GetRootLayer().GetRelationshipAtPath("/World/Cube.fresh")


def test_a_place_is_written_and_read_again(world, stage):
    frame = UsdGeom.Xform.Define(stage, "/World/Frame").GetPrim()
    app = world()
    # A quarter turn about z, twice as long along its x, at 1 2 3: rows of the matrix.
    place = [[0, 2, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]]
    inputs = {"prim": "/World/Frame"}
    trace = run_node("WritePrimLocalTransform", inputs={**inputs, "value": place}, pulses={"execIn": [0]}, app=app)
    assert trace.fired("execOut") == [0]
    ops = {op.GetOpName(): op.Get() for op in UsdGeom.Xformable(frame).GetOrderedXformOps()}
    assert ops["xformOp:translate"] == Gf.Vec3d(1, 2, 3)
    assert np.allclose(ops["xformOp:scale"], [2, 1, 1])
    assert np.allclose(run_node("ReadPrimLocalTransform", inputs=inputs, app=app).value("value"), place)


def test_an_invalid_place_fails(world, cube):
    for value, message in (
        (np.diag([1, 1, 0, 1]).tolist(), "is not a place"),
        ([[1, 0, 0, 0], [1, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "is sheared"),
    ):
        with pytest.raises(ComputeError, match=message):
            run_node("WritePrimLocalTransform", inputs={**CUBE, "value": value}, pulses={"execIn": [0]}, app=world())


def test_a_prim_has_directions_as_a_camera_has(world, stage, cube):
    """A quarter turn about x: its y axis points along the world's z, its z axis along -y."""
    UsdGeom.Xformable(cube).AddRotateXOp().Set(90)
    trace = run_node("GetPrimDirectionVector", inputs={"primPath": "/World/Cube"}, app=world())
    expected = {"right": [1, 0, 0], "up": [0, 0, 1], "backward": [0, -1, 0]}
    opposite = {"right": "left", "up": "down", "backward": "forward"}
    for name, direction in expected.items():
        assert np.allclose(trace.value(f"{name}Vector"), direction)
        assert np.allclose(trace.value(f"{opposite[name]}Vector"), np.negative(direction))


def test_settings_are_read_and_written(world):
    app = world(settings={"/my/number": 2.5, "/my/text": "hello"})
    assert run_node("ReadSetting", inputs={"settingPath": "/my/number"}, app=app).value("value") == 2.5
    assert run_node("ReadSetting", inputs={"settingPath": "/my/text"}, app=app).value("value") == "hello"
    value = {"settingPath": "/my/number", "value": {"type": "double", "value": 7.0}}
    trace = run_node("WriteSetting", inputs=value, pulses={"execIn": [0]}, app=app)
    assert trace.fired("execOut") == [0]
    assert app.settings.get("/my/number") == 7.0


def test_a_setting_that_nobody_set_is_reported_so(world):
    trace = run_node("ReadSetting", inputs={"settingPath": "/my/nothing"}, app=world())
    assert [one.code for one in trace.warnings] == ["setting-unset"]
    with pytest.raises(ComputeError, match="has settings below it"):
        run_node("ReadSetting", inputs={"settingPath": "/my"}, app=world(settings={"/my/number": 2.5}))


def test_a_paused_timeline_goes_on(world):
    app = world()
    app.play()
    app.update()
    app.pause()
    app.update()
    assert not app.timeline.is_playing()
    trace = run_node("StartTimeline", pulses={"execIn": [0]}, app=app, updates=2)
    assert trace.fired("execOut") == [0]
    assert app.timeline.is_playing()
