"""Variables, prims, keys, stage: the nodes that wait for something to change."""

import pytest

from graph import ComputeError, Context, Controller, compile_graphs
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec, VariableSpec

K = Controller.Keys


@pytest.fixture
def bound(world):
    """A function that makes an action graph in an App; gives the App, its Controller and the graph."""

    def make(nodes, connections=(), values=()):
        app = world()
        control = Controller(app=app)
        graph, *_ = control.edit(
            {"graph_path": "/World/G", "evaluator_name": "execution"},
            {K.CREATE_NODES: list(nodes), K.CONNECT: list(connections), K.SET_VALUES: list(values)},
        )
        return app, control, graph

    return make


def test_a_variable_fires_when_it_differs_from_last_time():
    spec = GraphSpec(
        "/G",
        (NodeSpec("on", "OnVariableChange", {"variableName": "v"}),),
        variables={"v": VariableSpec("double[3]", [1, 2, 3])},
    )
    graph, context = compile_graphs([spec])[0], Context.standalone()
    fired = []
    for value in (None, [1, 2, 3], [1, 2, 4], None, [1, 2, 3]):
        if value is not None:
            graph.variables["v"] = value
        context.advance()
        graph.evaluate(context)
        fired.append(graph.nodes["on"].fired["changed"])
    assert fired == [0, 0, 1, 1, 2]


def test_a_variable_that_is_written_in_the_graph_fires_in_the_next_evaluation():
    spec = GraphSpec(
        "/G",
        (
            NodeSpec("tick", "OnTick"),
            NodeSpec("count", "Counter"),
            NodeSpec("write", "WriteVariable", {"variableName": "v"}),
            NodeSpec("on", "OnVariableChange", {"variableName": "v"}),
        ),
        (
            ConnectionSpec("tick.tick", "count.execIn"),
            ConnectionSpec("count.execOut", "write.execIn"),
            ConnectionSpec("count.count", "write.value"),
        ),
        variables={"v": VariableSpec("int", 0)},
    )
    graph, context = compile_graphs([spec])[0], Context.standalone()
    fired = []
    for _ in range(3):
        graph.evaluate(context)
        context.advance()
        fired.append(graph.nodes["on"].fired["changed"])
    assert fired == [0, 1, 2]


def test_a_variable_that_is_missing_is_reported():
    spec = GraphSpec(
        "/G", (NodeSpec("on", "OnVariableChange", {"variableName": "sped"}),), variables={"speed": VariableSpec("int")}
    )
    with pytest.raises(ComputeError, match='the graph has no variable "sped"; did you mean "speed"'):
        compile_graphs([spec])[0].evaluate(Context.standalone())


def test_a_property_of_a_prim_fires_once_per_evaluation_with_its_name(bound):
    from pxr import UsdGeom

    app, _, graph = bound(
        [("on", "OnObjectChange"), ("radius", "OnObjectChange")],
        values=[
            ("on.inputs:path", "/World/Ball"),
            ("radius.inputs:prim", "/World/Ball"),
            ("radius.inputs:name", "radius"),
        ],
    )
    ball = UsdGeom.Sphere.Define(app.stage, "/World/Ball")
    other = UsdGeom.Sphere.Define(app.stage, "/World/Other")
    app.play()
    app.update(2)
    assert [graph.nodes[name].fired["changed"] for name in ("on", "radius")] == [0, 0]
    ball.GetRadiusAttr().Set(2.0)
    ball.GetRadiusAttr().Set(3.0)
    other.GetRadiusAttr().Set(3.0)
    app.update(2)
    assert [graph.nodes[name].fired["changed"] for name in ("on", "radius")] == [1, 1]
    assert graph.nodes["on"].get("propertyName") == "radius"
    ball.GetDisplayColorAttr().Set([(1, 0, 0)])
    app.update(1)
    assert [graph.nodes[name].fired["changed"] for name in ("on", "radius")] == [2, 1]


def test_stage_events_come_once_per_play_and_stop(bound):
    names = ["OmniGraph Start Play", "Simulation Start Play", "Simulation Stop Play", "Animation Stop Play"]
    app, _, graph = bound(
        [(f"n{i}", "OnStageEvent") for i in range(4)],
        values=[
            entry
            for i, name in enumerate(names)
            for entry in ((f"n{i}.inputs:eventName", name), (f"n{i}.inputs:onlyPlayback", False))
        ],
    )

    def fired():
        return [graph.nodes[f"n{i}"].fired["execOut"] for i in range(4)]

    app.update(2)
    assert fired() == [0, 0, 0, 0]
    app.play()
    app.update(2)
    assert fired() == [1, 1, 0, 0]
    app.pause()
    app.update(2)
    app.play()
    app.update(2)
    assert fired() == [1, 1, 0, 0], "pause and resume are no events"
    app.stop()
    app.update(2)
    assert fired() == [1, 1, 1, 1]


def test_a_change_of_the_hierarchy_fires(bound):
    app, _, graph = bound([("on", "OnStageEvent")], values=[("on.inputs:eventName", "Hierarchy Changed")])
    app.play()
    app.update(2)
    app.stage.DefinePrim("/World/New/Box")
    app.update(2)
    assert graph.nodes["on"].fired["execOut"] == 1


def test_loaded_fires_once_ahead_of_all_others_and_not_after_a_stop(bound):
    app, _, graph = bound(
        [("tick", "OnTick"), ("count", "Counter"), ("loaded", "OnLoaded"), ("log", "Counter")],
        [("tick.outputs:tick", "count.inputs:execIn"), ("loaded.outputs:execOut", "count.inputs:reset")],
    )
    app.play()
    app.update(2)
    assert graph.nodes["count"].get("count") == 2, "the reset came before the first tick"
    app.stop()
    app.play()
    app.update(2)
    assert graph.nodes["loaded"].fired["execOut"] == 1


def test_a_key_fires_once_per_press_and_once_per_release(bound):
    from graph.sim.keyboard import keyboard_of

    app, _, graph = bound(
        [("a", "OnKeyboardInput"), ("shifted", "OnKeyboardInput")],
        values=[("shifted.inputs:shiftIn", True)],
    )
    keys = keyboard_of(app)
    app.play()

    def update():
        app.update(1)
        return [tuple(graph.nodes[name].fired.values()) for name in ("a", "shifted")]

    assert update() == [(0, 0), (0, 0)]
    keys.press("A")
    assert update() == update() == [(1, 0), (0, 0)]
    assert (graph.nodes["a"].get("isPressed"), graph.nodes["a"].get("keyOut")) == (True, "A")
    keys.release("A")
    assert update() == [(1, 1), (0, 0)]
    assert graph.nodes["a"].get("isPressed") is False
    keys.press("LeftShift")
    keys.press("A")
    keys.release("A")
    assert update() == [(1, 1), (1, 1)]


def test_without_a_world_a_key_stays_silent():
    graph = compile_graphs([GraphSpec("/G", (NodeSpec("on", "OnKeyboardInput"),))])[0]
    graph.evaluate(Context.standalone())
    assert graph.nodes["on"].fired == {"pressed": 0, "released": 0}
