import pytest
from pxr import UsdGeom

from graph import ComputeError
from graph.testing import run_node


@pytest.fixture
def scene(stage):
    UsdGeom.Xform.Define(stage, "/World/Empty")
    UsdGeom.Cube.Define(stage, "/World/Group/Box")
    return stage


def test_a_prim_is_switched_off(world, scene):
    trace = run_node("SetPrimActive", inputs={"primTarget": "/World/Empty"}, pulses={"execIn": [0]}, app=world())
    assert not scene.GetPrimAtPath("/World/Empty").IsActive()
    assert trace.fired("execOut") == [0]


def test_what_sensors_look_at_cannot_be_switched_while_playing(world, scene):
    app = world()
    for path in ("/World/Group", "/World/Group/Box"):
        with pytest.raises(ComputeError, match=f"{path} cannot be switched while the timeline plays"):
            run_node("SetPrimActive", inputs={"primTarget": path}, pulses={"execIn": [0]}, app=app)
    assert scene.GetPrimAtPath("/World/Group/Box").IsActive()


def test_it_can_where_the_app_compiles_edits_in_place(world, scene):
    app = world()
    app.when_playing = "recompile"
    run_node("SetPrimActive", inputs={"primTarget": "/World/Group"}, pulses={"execIn": [0]}, app=app, updates=2)
    assert "/World/Group/Box" not in {one.path for one in app.geometry()}


def test_a_prim_that_is_as_wanted_is_left_alone(world, scene):
    inputs = {"primTarget": "/World/Group/Box", "active": True}
    assert run_node("SetPrimActive", inputs=inputs, pulses={"execIn": [0]}, app=world()).fired("execOut") == [0]


def test_a_missing_prim_is_warned_of(world, scene):
    trace = run_node("SetPrimActive", inputs={"primTarget": "/World/No"}, pulses={"execIn": [0]}, app=world())
    assert (trace.fired("execOut"), [one.code for one in trace.warnings]) == ([], ["prim-missing"])


def test_a_relationship_gets_a_target_once(world, scene):
    inputs = {"path": "/World/Empty", "name": "friends", "target": "/World/Group"}
    trace = run_node("AddPrimRelationship", inputs=inputs, pulses={"execIn": [0, 1]}, updates=2, app=world())
    targets = scene.GetPrimAtPath("/World/Empty").GetRelationship("friends").GetTargets()
    assert [str(one) for one in targets] == ["/World/Group"]
    assert trace.values("isSuccessful") == [True, True]


def test_a_relationship_of_no_prim_is_not_successful(world, scene):
    inputs = {"path": "/World/No", "name": "friends", "target": "/World/Group"}
    trace = run_node("AddPrimRelationship", inputs=inputs, pulses={"execIn": [0]}, app=world())
    assert trace.value("isSuccessful") is False
    with pytest.raises(ComputeError, match='input target is "Group", which is not an absolute path'):
        run_node("AddPrimRelationship", inputs=inputs | {"target": "Group"}, pulses={"execIn": [0]}, app=world())


def test_each_target_has_its_pass():
    trace = run_node("ForEachTarget", inputs={"targets": ["/A", "/B", "/C"]}, pulses={"execIn": [1]}, updates=2)
    assert trace.fired("loopBody") == [1, 1, 1]
    assert trace.fired("finished") == [1]
    assert (trace.value("arrayIndex"), trace.value("target")) == (2, ["/C"])


def test_no_targets_only_finish():
    trace = run_node("ForEachTarget", pulses={"execIn": [0]})
    assert (trace.fired("loopBody"), trace.fired("finished")) == ([], [0])


def test_exit_ends_the_run_after_its_update(world, stage):
    app = world()
    run_node("ExitApplication", pulses={"execIn": [1]}, updates=2, app=app)
    assert app.exit_requested
    index = app.update_index
    app.update(5)
    assert app.update_index == index + 1


def test_a_run_that_exits_reports_and_ends_well(tmp_path, capsys):
    from graph.cli.main import main

    (tmp_path / "exit.yaml").write_text(
        "tickgraph: 1\n"
        "graphs:\n"
        "  /World/Graph:\n"
        "    nodes:\n"
        "      tick: OnPlaybackTick\n"
        "      wait: {type: Countdown, inputs: {duration: 3}}\n"
        "      exit: ExitApplication\n"
        "    connections:\n"
        "      - tick.tick -> wait.execIn\n"
        "      - wait.finished -> exit.execIn\n"
    )
    import json

    assert main(["run", str(tmp_path / "exit.yaml"), "--updates", "60", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["updates"] == 4
