import pytest

from graph import ComputeError, UserError
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec
from graph.testing import run_graph
from tests.support.lidar_texts import LIDAR_AND_CLOCK

HELD_BACK = """\
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      wait: {type: Countdown, inputs: {duration: 5, period: 1}}
    connections: [tick.tick -> wait.execIn]
"""


@pytest.mark.parametrize("app", [False, True])
@pytest.mark.parametrize("by_file", [False, True])
def test_interrupts_are_as_the_settings_say_with_and_without_a_world(app, by_file):
    key = "/ext/omni.graph.action/disableInterrupts"
    text = HELD_BACK + (f"settings: {{{key}: false}}\n" if by_file else "")
    trace = run_graph(text, updates=20, app=app, settings={} if by_file else {key: False})
    assert trace.fired("wait.finished") == []


def test_a_text_runs_without_a_world():
    trace = run_graph(HELD_BACK, updates=20)
    assert trace.fired("wait.finished") == [5, 11, 17]
    assert trace.fired("tick.tick") == list(range(20))
    assert trace.values("wait.alpha")[:7] == pytest.approx([0, 0.2, 0.4, 0.6, 0.8, 1.0, 0.0])
    assert trace.value("tick.outputs:deltaSeconds") == 1 / 60
    assert (trace.updates, trace.computes("tick"), trace.in_world) == (20, 20, False)
    assert repr(trace) == "<GraphTrace updates=20 nodes=2 topics=0 sensors=0 warnings=0>"


def test_a_specification_of_one_graph_runs():
    nodes = (NodeSpec("a", "ConstantDouble", {"value": 2.0}), NodeSpec("double", "Multiply", {"b": 3.0}))
    spec = GraphSpec("/G", nodes, (ConnectionSpec("a.value", "double.a"),), evaluator="push")
    assert run_graph(spec).value("double.product") == 6.0


def test_a_file_runs_for_its_duration(tmp_path):
    file = tmp_path / "short.yaml"
    file.write_text(HELD_BACK + "duration: 0.25\nclock: {loop_hz: 30}\n")
    assert run_graph(file).updates == 8  # 7.5 updates, rounded up


def test_inputs_beat_the_file_and_may_change_from_update_to_update():
    assert run_graph(HELD_BACK, updates=7, inputs={"wait.duration": 2}).fired("wait.finished") == [2, 5]
    trace = run_graph(HELD_BACK, updates=12, inputs={"wait.duration": lambda update: 5 if update < 6 else 2})
    assert trace.fired("wait.finished") == [5, 8, 11]


def test_pulses_come_after_the_graphs_own_events():
    spec = GraphSpec("/G", (NodeSpec("wait", "Countdown", {"duration": 2, "period": 1}),))
    assert run_graph(spec, updates=9, pulses={"wait.execIn": [1, 2, 5]}).fired("wait.finished") == [3, 7]


def test_two_pulses_in_one_update_fire_twice():
    spec = GraphSpec("/G", (NodeSpec("gate", "Counter"),))
    trace = run_graph(spec, updates=3, pulses={"gate.execIn": [1, 1]})
    assert trace.fired("gate.execOut") == [1, 1]
    assert trace.values("gate.count") == [0, 2, 2]


def test_a_pulse_after_the_last_update_is_refused():
    spec = GraphSpec("/G", (NodeSpec("gate", "Counter"),))
    with pytest.raises(UserError, match="pulses: update 3 comes after the last one, 2; give more updates"):
        run_graph(spec, updates=3, pulses={"gate.execIn": [1, 3]})


def test_a_scene_makes_an_app_of_its_own():
    trace = run_graph(LIDAR_AND_CLOCK, updates=14)
    assert trace.in_world
    assert trace.frames == {"/World/Lidar": [5, 11]}
    assert [update for update, _ in trace.messages["/points"]] == [5, 11]
    assert [update for update, _ in trace.messages["/clock"]] == list(range(14))
    assert trace.messages["/points"][0][1].width > 0


def test_pulses_reach_graphs_in_a_world():
    text = LIDAR_AND_CLOCK.replace("- tick.tick -> [clock.execIn, product.execIn]", "- tick.tick -> product.execIn")
    trace = run_graph(text, updates=5, pulses={"clock.execIn": [1, 3]})
    assert [update for update, _ in trace.messages["/clock"]] == [1, 3]


def test_a_graph_that_nobody_evaluates_is_evaluated_for_its_pulses():
    text = LIDAR_AND_CLOCK + "  /World/Asked:\n    pipeline_stage: on_demand\n    nodes: {count: Counter}\n"
    trace = run_graph(text, updates=5, pulses={"count.execIn": [0, 3]})
    assert trace.fired("count.execOut") == [0, 3]


def test_an_app_can_be_asked_for_and_refused():
    nodes = (NodeSpec("tick", "OnPlaybackTick"), NodeSpec("clock", "ROS2PublishClock"))
    text = GraphSpec("/G", nodes, (ConnectionSpec("tick.tick", "clock.execIn"),))
    assert len(run_graph(text, updates=3, app=True).messages["/clock"]) == 3
    with pytest.raises(ComputeError, match="needs a world"):
        run_graph(text, updates=3, app=False)


def test_a_timeline_that_does_not_play_holds_its_events():
    assert run_graph(HELD_BACK, updates=4, playing=False).fired("tick.tick") == []
    playing = {1, 2}.__contains__
    assert run_graph(HELD_BACK, updates=4, playing=playing).fired("tick.tick") == [1, 2]
    assert run_graph(HELD_BACK, updates=4, playing=playing, app=True).fired("tick.tick") == [1, 2]


def test_only_what_is_recorded_has_values():
    trace = run_graph(HELD_BACK, updates=3, record=["wait.alpha"])
    assert trace.values("wait.alpha") == pytest.approx([0, 0.2, 0.4])
    with pytest.raises(KeyError, match="was not recorded"):
        trace.values("wait.duration")
    with pytest.raises(UserError, match='no attribute "alhpa"; did you mean "alpha"'):
        run_graph(HELD_BACK, record=["wait.alhpa"])


def test_recorded_arrays_stay_as_they_were():
    nodes = (NodeSpec("wheels", "DifferentialController", {"wheelRadius": 1.0, "wheelDistance": 2.0}),)
    speeds = {"wheels.linearVelocity": float}
    trace = run_graph(GraphSpec("/G", nodes), updates=3, inputs=speeds, pulses={"wheels.execIn": range(3)})
    assert [list(value) for value in trace.values("wheels.velocityCommand")] == [[0, 0], [1, 1], [2, 2]]


def test_a_failure_is_raised_or_kept_with_what_came_before():
    spec = GraphSpec("/G", (NodeSpec("wait", "Countdown", {"duration": 3, "period": 1}),))
    inputs = {"wait.duration": lambda update: 3 if update < 4 else -1}
    pulses = {"wait.execIn": [0, 5]}
    with pytest.raises(ComputeError, match="update 5"):
        run_graph(spec, updates=9, inputs=inputs, pulses=pulses)
    trace = run_graph(spec, updates=9, inputs=inputs, pulses=pulses, catch=True)
    assert isinstance(trace.error, ComputeError)
    assert (trace.updates, trace.fired("wait.finished")) == (5, [3])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"inputs": {"wiat.duration": 1}}, 'inputs: there is no node "wiat"; did you mean "wait"?'),
        ({"inputs": {"duration": 1}}, 'inputs: "duration" names no attribute; write node.attribute'),
        ({"inputs": {"wait.duraton": 1}}, '"duraton"; did you mean "duration"'),
        ({"inputs": {"wait.alpha": lambda u: u}}, "alpha"),
        ({"pulses": {"wait.duration": [0]}}, '"wait.duration" (omni.graph.action.Countdown) is not an execution input'),
        ({"pulses": {"wait.execOut": [0]}}, 'pulses: node /World/G/wait (Countdown) has no attribute "execOut"'),
        ({"pulses": {"/World/G/wiat.execIn": [0]}}, 'there is no node "/World/G/wiat"; did you mean "/World/G/wait"?'),
        ({"pulses": {"wait.execIn": [-1]}}, "pulses: updates are numbered 0, 1, 2 ...; -1 is not one of them"),
        ({"updates": -1}, "updates: expected a whole number from 0, got -1"),
        ({"inputs": {"wait.duration": "many"}}, "duration"),
        (
            {"inputs": {"wait.duration": lambda u: 3 if u < 2 else "many"}},
            "inputs: update 2: /World/G/wait.inputs:",
        ),
    ],
)
def test_wrong_references_are_reported(options, message):
    with pytest.raises(UserError) as caught:
        run_graph(HELD_BACK, **{"updates": 5, **options})
    assert message in str(caught.value)


def test_a_name_in_two_graphs_needs_its_path():
    text = HELD_BACK + HELD_BACK.partition("graphs:\n")[2].replace("/World/G", "/World/H")
    trace = run_graph(text, updates=2)
    assert trace.fired("/World/H/tick.tick") == [0, 1]
    with pytest.raises(KeyError, match="several graphs; write /World/G/tick or /World/H/tick"):
        trace.fired("tick.tick")


def test_firings_and_values_are_not_mixed_up():
    trace = run_graph(HELD_BACK, updates=2)
    with pytest.raises(KeyError, match="not an execution output"):
        trace.fired("wait.alpha")
    with pytest.raises(KeyError, match="ask when it fired"):
        trace.values("wait.finished")


def test_all_problems_of_a_text_are_reported():
    with pytest.raises(UserError) as caught:
        run_graph(HELD_BACK.replace("Countdown", "Cuontdown").replace("tick.tick ->", "tock.tick ->"))
    assert len(caught.value.problems) == 2


@pytest.mark.parametrize("app", [False, True])
def test_a_stop_sets_clocks_and_nodes_back(app):
    trace = run_graph(HELD_BACK, updates=12, stops=[4], app=app)
    assert trace.fired("wait.finished") == [9]
    times = trace.values("tick.time")
    assert times[3:6] == pytest.approx([4 / 60, 1 / 60, 2 / 60])
