import math

import pytest

from graph import ComputeError, Context, compile_graphs
from graph.node import registry
from graph.node.context import WarningLog
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec
from graph.testing import run_node


def countdown(updates, start=(0,), **inputs):
    return run_node("omni.graph.action.Countdown", inputs=inputs, pulses={"execIn": start}, updates=updates)


def test_a_countdown_of_10_by_3_ticks_at_3_6_9_and_finishes_at_10():
    trace = countdown(12, duration=10, period=3)
    assert trace.fired("tick") == [3, 6, 9]
    assert trace.fired("finished") == [10]
    assert trace.values("tickValue") == [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 10]
    assert trace.values("alpha") == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1])
    assert trace.values("count") == [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, -1, -1]


def test_the_default_countdown_ticks_five_times_and_the_last_tick_comes_before_finished():
    trace = countdown(7)
    assert trace.fires == [(1, "tick"), (2, "tick"), (3, "tick"), (4, "tick"), (5, "tick"), (5, "finished")]


def test_a_countdown_fed_by_every_update_finishes_in_updates_5_11_17():
    assert countdown(20, start=range(20)).fired("finished") == [5, 11, 17]


def test_a_countdown_starts_over_where_interrupts_are_on():
    trace = run_node("Countdown", inputs={"duration": 3}, pulses={"execIn": [0, 2]}, updates=8, interrupts=True)
    assert trace.fired("finished") == [5]


def test_a_countdown_of_0_finishes_in_the_next_update_without_a_tick():
    trace = countdown(3, duration=0)
    assert trace.fires == [(1, "finished")]
    assert trace.values("alpha") == [0, 1, 1]
    assert trace.values("tickValue") == [0, 0, 0]


@pytest.mark.parametrize(("inputs", "message"), [({"duration": -1}, "duration is -1"), ({"period": 0}, "period is 0")])
def test_a_countdown_refuses_what_it_cannot_count(inputs, message):
    with pytest.raises(ComputeError, match=message):
        countdown(1, **inputs)


def test_a_stop_ends_a_running_countdown():
    def stop_at_3(update, node):
        if update == 3:
            node.graph.reset()

    trace = run_node("Countdown", inputs={"duration": 5}, pulses={"execIn": [0, 4]}, updates=12, on_update=stop_at_3)
    assert trace.fired("finished") == [9]
    assert trace.values("count")[3] == -1


def test_a_delay_of_10_s_over_updates_of_7_s_finishes_in_the_second():
    trace = run_node("Delay", inputs={"duration": 10}, pulses={"execIn": [0]}, updates=4, loop_hz="1/7")
    assert trace.fired("finished") == [2]


@pytest.mark.parametrize("hz", [24, 29.97, 30, 60, 90, 120])
def test_a_delay_adds_updates_up_exactly(hz):
    whole = round(100 * hz)
    trace = run_node("Delay", inputs={"duration": 100.0}, pulses={"execIn": [0]}, updates=whole + 2, loop_hz=hz)
    assert trace.fired("finished") == [whole]


def test_a_delay_of_0_finishes_in_the_next_update():
    assert run_node("Delay", pulses={"execIn": [0]}, updates=3).fired("finished") == [1]


def test_a_trigger_of_a_sleeping_delay_is_ignored():
    trace = run_node("Delay", inputs={"duration": 0.1}, pulses={"execIn": range(14)}, updates=14)
    assert trace.fired("finished") == [6, 13]


def test_latent_types_are_version_2():
    assert [registry.get(name).version for name in ("Countdown", "Delay")] == [2, 2]


@pytest.mark.parametrize("value", [math.inf, -math.inf, math.nan])
@pytest.mark.parametrize(("kind", "start"), [("Delay", "execIn"), ("Timer", "play")])
def test_a_wait_without_a_finite_duration_fails_when_it_is_started(kind, start, value):
    message = rf"failed in update 0: input duration is {value} s; give it a finite number of seconds$"
    with pytest.raises(ComputeError, match=message):
        run_node(kind, inputs={"duration": value}, pulses={start: [0]})


def wait_in_a_loop(*links):
    nodes = {
        "impulse": ("OnImpulseEvent", {}),
        "wait": ("Countdown", {"duration": 2}),
        "send": ("SendCustomEvent", {"eventName": "again"}),
        "on": ("OnCustomEvent", {"eventName": "again"}),
    }
    made = tuple(NodeSpec(name, *entry) for name, entry in nodes.items())
    wires = tuple(ConnectionSpec(*one.split(" -> ")) for one in ("impulse.execOut -> wait.execIn", *links))
    graph = compile_graphs([GraphSpec("/G", made, wires)])[0]
    graph.node("impulse").set("state:enableImpulse", True)
    context = Context.standalone()
    context.warn = WarningLog()
    finished = []
    for update in range(9):
        context.advance()
        graph.evaluate(context)
        if graph.node("wait").fired["finished"] > len(finished):
            finished.append(update)
    return finished, [(one.code, one.where, one.message) for one in context.warn]


def test_a_wait_that_leads_back_to_itself_ends_with_a_warning():
    finished, warnings = wait_in_a_loop("wait.finished -> wait.execIn")
    assert finished == [2]
    assert [one[:2] for one in warnings] == [("trigger-ignored", "/G/wait")]
    assert "lead it through SendCustomEvent and OnCustomEvent" in warnings[0][2]


def test_a_wait_goes_round_through_a_custom_event_as_the_warning_says():
    finished, warnings = wait_in_a_loop("wait.finished -> send.execIn", "on.execOut -> wait.execIn")
    assert (finished, warnings) == ([2, 5, 8], [])


def test_a_wait_fed_by_every_update_is_not_warned_of():
    assert countdown(20, start=range(20)).warnings == []


def test_a_countdown_that_starts_itself_again_goes_on_where_interrupts_are_on(tmp_path):
    from graph.sim import App

    (tmp_path / "g.yaml").write_text(
        "tickgraph: 1\nsettings: {/ext/omni.graph.action/disableInterrupts: false}\n"
        "graphs:\n  /G:\n    nodes:\n      begin: OnLoaded\n"
        "      wait: {type: Countdown, inputs: {duration: 2}}\n      count: Counter\n"
        "    connections: [begin.execOut -> wait.execIn, 'wait.finished -> [wait.execIn, count.execIn]']\n"
    )
    with App.from_file(tmp_path / "g.yaml") as app:
        app.play()
        counts = []
        for _ in range(9):
            app.update()
            counts.append(app.graphs["/G"].nodes["count"].get("count"))
    assert counts == [0, 0, 1, 1, 2, 2, 3, 3, 4]  # fires in updates 2, 4, 6 and 8
