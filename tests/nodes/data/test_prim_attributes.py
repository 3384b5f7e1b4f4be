import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

from graph import ComputeError
from graph.testing import run_node
from tests.support.typed_values import of


@pytest.fixture
def prim(stage):
    """/World/Thing with an attribute of each kind; returns the function that makes more of them."""
    thing = UsdGeom.Xform.Define(stage, "/World/Thing").GetPrim()

    def add(name, type_name, value=None):
        attribute = thing.CreateAttribute(name, Sdf.ValueTypeNames.Find(type_name))
        if value is not None:
            attribute.Set(value)
        return attribute

    return add


def read(app, name, **more):
    trace = run_node("ReadPrimAttribute", inputs={"prim": "/World/Thing", "name": name, **more}, app=app)
    return trace.value("value")


def write(app, name, value, **more):
    return run_node(
        "WritePrimAttribute",
        inputs={"prim": "/World/Thing", "name": name, "value": value, **more},
        pulses={"execIn": [0]},
        app=app,
    )


@pytest.mark.parametrize(
    ("type_name", "authored", "value"),
    [
        ("double", 2.5, 2.5),
        ("int", -3, -3),
        ("uchar", 7, 7),
        ("bool", True, True),
        ("token", "a", "a"),
        ("string", "text", "text"),
        ("asset", Sdf.AssetPath("x.usd"), "x.usd"),
        ("timecode", Sdf.TimeCode(4), 4.0),
        ("token[]", ["a", "b"], ["a", "b"]),
        ("double3", Gf.Vec3d(1, 2, 3), [1, 2, 3]),
        ("point3f[]", [Gf.Vec3f(1, 2, 3)], [[1, 2, 3]]),
        ("quatd", Gf.Quatd(1, 2, 3, 4), [2, 3, 4, 1]),
        (
            "matrix4d",
            Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(7, 8, 9)),
            [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [7, 8, 9, 1]],
        ),
    ],
)
def test_values_of_the_stage_come_as_graphs_hold_them(world, prim, type_name, authored, value):
    prim("x", type_name, authored)
    found = read(world(), "x")
    assert np.array_equal(found, value)
    assert type(found) is type(value) or isinstance(found, np.ndarray)


@pytest.mark.parametrize(
    ("type_name", "value", "stored"),
    [
        ("double", 2.5, 2.5),
        ("float", of("double", 0.5), 0.5),
        ("int", 3, 3),
        ("token", "a", "a"),
        ("double3", [1, 2, 3], Gf.Vec3d(1, 2, 3)),
        ("color3f", [1, 0.5, 0], Gf.Vec3f(1, 0.5, 0)),
        ("quatf", [2, 3, 4, 1], Gf.Quatf(1, 2, 3, 4)),
        ("int[]", [1, 2], [1, 2]),
        ("token[]", ["a"], ["a"]),
        ("matrix2d", [[1, 2], [3, 4]], Gf.Matrix2d(1, 2, 3, 4)),
        ("bool", True, True),
    ],
)
def test_values_are_written_in_the_type_of_the_attribute(world, prim, type_name, value, stored):
    attribute = prim("x", type_name)
    trace = write(world(), "x", value)
    found = attribute.Get()
    assert (list(found) if isinstance(stored, list) else found) == stored
    assert trace.fired("execOut") == [0]


def test_what_only_fabric_has_is_read_back_but_not_on_the_stage(world, prim):
    attribute = prim("x", "double", 1.0)
    app = world()
    write(app, "x", 5.0, usdWriteBack=False)
    assert attribute.Get() == 1.0
    assert read(app, "x") == 5.0
    write(app, "x", 6.0)
    assert (attribute.Get(), read(app, "x")) == (6.0, 6.0)


def test_a_value_that_does_not_fit_is_an_error(world, prim):
    prim("x", "token")
    with pytest.raises(ComputeError, match=r"the value \(double\) cannot be written to /World/Thing\.x \(token\)"):
        write(world(), "x", 5.0)


def test_a_connected_value_is_converted_as_a_connection_would(world, prim):
    attribute = prim("x", "int")
    run_node(
        "WritePrimAttribute",
        inputs={"prim": "/World/Thing", "name": "x", "value": 2.9},
        connect={"value": "double"},
        pulses={"execIn": [0]},
        app=world(),
    )
    assert attribute.Get() == 2
    prim("y", "double3")
    with pytest.raises(
        ComputeError, match=r"the value \(double\) cannot be written to /World/Thing\.y \(double\[3\]\)"
    ):
        run_node(
            "WritePrimAttribute",
            inputs={"prim": "/World/Thing", "name": "y", "value": 2.9},
            connect={"value": "double"},
            pulses={"execIn": [0]},
            app=world(),
        )


def test_a_missing_prim_is_passed_by_with_a_warning(world, prim):
    app = world()
    for inputs in (
        {"prim": "/World/Nothing"},
        {"usePath": True, "primPath": "/World/Nothing"},
        {"usePath": True, "primPath": "x"},
    ):
        trace = run_node(
            "WritePrimAttribute", inputs={"name": "x", "value": 1.0, **inputs}, pulses={"execIn": [0]}, app=app
        )
        assert trace.fired("execOut") == []
        assert [one.code for one in trace.warnings] == ["prim-missing"]
    assert run_node("ReadPrimAttribute", inputs={"name": "x", "prim": "/World/Nothing"}, app=app).value("value") is None


def test_a_missing_attribute_names_the_nearest(world, prim):
    prim("height", "double", 1.0)
    with pytest.raises(ComputeError, match=r'/World/Thing has no attribute "hight"; did you mean "height"\?'):
        read(world(), "hight")
    with pytest.raises(ComputeError, match="input name is empty"):
        read(world(), "")


def test_one_prim_has_to_be_named(world, prim):
    app = world()
    with pytest.raises(ComputeError, match="input prim names 0 prims; give it the path of one prim"):
        run_node("ReadPrimAttribute", inputs={"name": "x"}, app=app)
    with pytest.raises(ComputeError, match="input primPath is empty"):
        run_node("ReadPrimAttribute", inputs={"name": "x", "usePath": True}, app=app)


def test_animated_attributes_are_read_at_a_time_or_now(world, prim):
    attribute = prim("x", "double")
    attribute.Set(0.0, 0)
    attribute.Set(60.0, 60)
    app = world(loop_hz=60)
    assert read(app, "x", usdTimecode=30) == 30.0
    trace = run_node("ReadPrimAttribute", inputs={"prim": "/World/Thing", "name": "x"}, updates=3, app=app)
    steps = np.diff(trace.values("value"))
    assert steps == pytest.approx(steps[0])
    assert steps[0] > 0


def test_a_reader_of_another_number_type_gets_its_own(world, prim):
    prim("x", "float", 0.5)
    trace = run_node("ReadPrimAttribute", inputs={"prim": "/World/Thing", "name": "x"}, app=world())
    assert trace.value("value") == 0.5


def test_a_named_layer_gets_the_value(world, prim, stage):
    attribute = prim("x", "double", 1.0)
    layer = stage.GetSessionLayer()
    write(world(), "x", 5.0, layerIdentifier=layer.identifier)
    assert attribute.Get() == 5.0
    assert layer.GetAttributeAtPath("/World/Thing.x").default == 5.0
    with pytest.raises(
        ComputeError, match=r'input layerIdentifier is "nowhere\.usd", which is not a layer of the stage'
    ):
        write(world(), "x", 6.0, layerIdentifier="nowhere.usd")


def test_a_new_place_of_a_body_on_the_stage_moves_the_body(world, stage):
    from pxr import UsdPhysics

    box = UsdGeom.Cube.Define(stage, "/World/Thing")
    box.AddTranslateOp().Set((0, 0, 5))
    UsdPhysics.RigidBodyAPI.Apply(box.GetPrim())
    UsdPhysics.CollisionAPI.Apply(box.GetPrim())
    app = world()
    app.play()
    app.update(10)
    assert app.fabric.world_matrix("/World/Thing")[2, 3] < 5
    write(app, "xformOp:translate", [3, 0, 9])
    assert app.fabric.world_matrix("/World/Thing")[:3, 3] == pytest.approx([3, 0, 9], abs=0.1)


GRAPH = """\
tickgraph: 1
scene:
  prims:
    /World/Box: {type: Cube, size: 2.5, translate: [1, 2, 3]}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      size: {type: ReadPrimAttribute, inputs: {prim: /World/Box, name: size}}
      place: {type: ReadPrimAttribute, inputs: {prim: /World/Box, name: "xformOp:translate"}}
      parts: BreakVector3
      sum: {type: Add, inputs: {b: {type: double, value: 1}}}
      text: ToString
      write: {type: WritePrimAttribute, inputs: {prim: /World/Box, name: size}}
      log: PrintText
    connections:
      - place.value -> parts.tuple
      - parts.y -> text.value
      - size.value -> sum.a
      - sum.sum -> write.value
      - tick.tick -> write.execIn
      - write.execOut -> log.execIn
      - text.converted -> log.text
"""


def test_values_pass_through_nodes_of_open_types_and_the_stage_is_restored():
    from graph.files import loads
    from graph.session.open import open_session

    with open_session(loads(GRAPH)).app as app:
        size = app.stage.GetPrimAtPath("/World/Box").GetAttribute("size")
        app.play()
        app.update(3)
        assert size.Get() == 5.5
        assert app.graphs["/World/Graph"].nodes["text"].get("converted") == "2.0"
        app.stop()
        assert size.Get() == 2.5
