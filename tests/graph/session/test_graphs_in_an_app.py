"""Graphs made and changed while an App runs, and the phases in which they are evaluated."""

import pytest

from graph import Controller, OmniGraphError, RunError
from graph.sim import App

K = Controller.Keys
STAGES = Controller.GraphPipelineStage
INTERRUPTS = "/ext/omni.graph.action/disableInterrupts"


@pytest.fixture
def app():
    with App(physics_hz=240, loop_hz=60) as opened:
        yield opened


def counter(path="/World/G", tick="omni.graph.action.OnPlaybackTick", **settings):
    """An action graph that counts; gives the Counter node."""
    _, nodes, _, _ = Controller.edit(
        {"graph_path": path, "evaluator_name": "execution", **settings},
        {
            K.CREATE_NODES: [("tick", tick), ("count", "omni.graph.action.Counter")],
            K.CONNECT: ("tick.outputs:tick" if tick.endswith("Tick") else "tick.outputs:step", "count.inputs:execIn"),
        },
    )
    return nodes[1]


def test_the_class_works_on_the_graphs_of_the_entered_app(app):
    count = counter()
    assert app.graphs["/World/G"] is count.graph
    app.update(2)
    assert count.get("count") == 0
    app.play()
    app.update(3)
    assert count.get("count") == 3
    app.stop()
    assert count.get("count") == 0
    Controller.delete_graph("/World/G")
    assert app.graphs == {}
    app.play()
    app.update(1)
    assert count.computes == 3


def test_edits_and_stages_count_from_the_next_update_on(app):
    count = counter()
    app.play()
    app.update(2)
    Controller.edit("/World/G", {K.CREATE_NODES: ("more", "omni.graph.action.Counter")})
    Controller.connect("/World/G/count.outputs:execOut", "/World/G/more.inputs:execIn")
    app.update(2)
    assert count.get("count") == 4
    assert Controller.get("/World/G/more.outputs:count") == 2
    count.graph.change_pipeline_stage(STAGES.GRAPH_PIPELINE_STAGE_ONDEMAND)
    app.update(2)
    assert count.get("count") == 4
    Controller.evaluate_sync(count.graph)
    assert count.get("count") == 5
    count.graph.change_pipeline_stage(STAGES.GRAPH_PIPELINE_STAGE_SIMULATION)
    app.update(1)
    assert count.get("count") == 6


def test_a_push_graph_runs_while_stopped_and_an_action_graph_as_its_event_allows(app):
    Controller.edit("/World/Push", {K.CREATE_NODES: ("time", "omni.graph.nodes.ReadTime")})
    playback, any_time = counter("/World/A"), counter("/World/B", "omni.graph.action.OnTick")
    only, demanded = counter("/World/C", "omni.graph.action.OnTick"), counter("/World/D", pipeline_stage="on_demand")
    Controller.set(("inputs:onlyPlayback", "/World/B/tick"), False)
    app.update(10)
    nodes = [playback, any_time, only, demanded]
    assert Controller.node("/World/Push/time").computes == 10
    assert [node.get("count") for node in nodes] == [0, 10, 0, 0]
    app.play()
    app.update(10)
    assert Controller.node("/World/Push/time").computes == 20
    assert [node.get("count") for node in nodes] == [10, 20, 10, 0]


def test_a_graph_made_on_demand_follows_the_physics_from_its_first_step(app):
    app.play()
    app.update(1)
    count = counter(tick="isaacsim.core.nodes.OnPhysicsStep", pipeline_stage="pipelineStageOnDemand")
    app.update(2)
    assert count.get("count") == 8


@pytest.mark.parametrize("stage", ["pre_render", "post_render"])
def test_graphs_of_the_renderer_are_not_evaluated_by_hand(app, stage):
    counter(pipeline_stage=stage)
    Controller.evaluate_sync()
    with pytest.raises(OmniGraphError, match=f"is of the {stage} stage"):
        Controller.evaluate_sync("/World/G")


def test_the_setting_decides_whether_triggers_interrupt(app):
    _, nodes, _, _ = Controller.edit(
        {"graph_path": "/World/G", "evaluator_name": "execution"},
        {
            K.CREATE_NODES: [("tick", "omni.graph.action.OnPlaybackTick"), ("wait", "omni.graph.action.Countdown")],
            K.CONNECT: ("tick.outputs:tick", "wait.inputs:execIn"),
        },
    )
    app.play()
    app.update(18)
    assert nodes[1].fired["finished"] == 3, "at u = 5, 11 and 17"
    app.settings.set(INTERRUPTS, False)
    app.update(18)
    assert nodes[1].fired["finished"] == 3, "every trigger starts it anew"
    assert Controller.create_graph("/World/New").interrupts


def test_interrupts_may_be_set_from_the_start():
    with App(settings={INTERRUPTS: False}):
        assert counter().graph.interrupts


def test_prims_are_made_with_their_attributes_after_the_whole_edit_was_checked(app):
    graph, _, prims, _ = Controller.edit(
        "/World/G",
        {
            K.CREATE_PRIMS: [
                ("/World/Box", {"size": ("double", 2.0), "myVector": ("double[3]", (1, 2, 3))}, "Cube"),
                ("/World/Empty", "Xform"),
                "/World/Plain",
            ]
        },
    )
    assert [(str(prim.GetPath()), prim.GetTypeName()) for prim in prims] == [
        ("/World/Box", "Cube"),
        ("/World/Empty", "Xform"),
        ("/World/Plain", ""),
    ]
    assert prims[0].GetAttribute("size").Get() == 2.0
    assert tuple(prims[0].GetAttribute("myVector").Get()) == (1, 2, 3)
    assert Controller.prim("/World/Box") == prims[0]
    wrong = {
        K.CREATE_PRIMS: [
            ("/World/Other", "Xform"),
            ("/World/Box", "Cube"),
            ("no path", "Cube"),
            ("/World/Bad", {"size": ("doubel", 1.0)}),
            ("/World/Worse", {"size": ("double", "big")}),
        ]
    }
    with pytest.raises(OmniGraphError) as caught:
        Controller.edit(graph, wrong)
    lines = str(caught.value).splitlines()
    assert "prim /World/Box already exists" in lines[0]
    assert '"no path" is not an absolute prim path' in lines[1]
    assert 'no attribute type "doubel"; did you mean "double' in lines[2]
    assert "prim /World/Worse: size: expected a number (double), got 'big'" in lines[3]
    assert not app.stage.GetPrimAtPath("/World/Other")


def test_a_graph_runs_once_for_each_prim_that_has_it(app):
    count = counter()
    Controller.create_variable("/World/G", "speed", "double", 1.0)
    for name, speed in (("R1", None), ("R2", 3.0)):
        prim = app.stage.DefinePrim(f"/World/{name}", "Xform")
        prim.CreateRelationship("omniGraphs").AddTarget("/World/G")
        if speed is not None:
            from pxr import Sdf

            prim.CreateAttribute("graph:variable:speed", Sdf.ValueTypeNames.Double).Set(speed)
    app.play()
    app.update(4)
    graph = count.graph
    assert {prim: one.nodes["count"].get("count") for prim, one in graph.instances.items()} == {
        "/World/R1": 4,
        "/World/R2": 4,
    }
    speed = Controller.variable("speed", graph)
    assert (speed.get("/World/R1"), speed.get("/World/R2")) == (1.0, 3.0)
    speed.set(2.0, "/World/R1")
    assert (speed.get("/World/R1"), speed.get("/World/R2")) == (2.0, 3.0)


def test_a_failing_node_of_a_new_graph_stops_the_run(app):
    Controller.edit(
        "/World/G",
        {
            K.CREATE_NODES: ("divide", "omni.graph.nodes.Divide"),
            K.SET_VALUES: [("divide.inputs:a", 1.0, "double"), ("divide.inputs:b", 0.0, "double")],
        },
    )
    with pytest.raises(RunError, match="/World/G/divide"):
        app.update(1)


def test_two_apps_have_graphs_of_their_own(app):
    count = counter()
    with App() as other:
        assert counter().graph is other.graphs["/World/G"]
        assert Controller(app=app).graph("/World/G") is count.graph
    assert Controller.graph("/World/G") is count.graph
