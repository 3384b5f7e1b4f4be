import pytest

from graph import ComputeError
from graph.testing import run_node


def test_the_clocks_of_an_update():
    trace = run_node("ReadTime", updates=3, loop_hz=10)
    assert trace.values("deltaSeconds") == [0.1] * 3
    assert trace.values("time") == [0.1, 0.2, 0.3]
    assert trace.values("timeSinceStart") == [0.1, 0.2, 0.3]
    assert trace.values("absoluteSimTime") == [0.1, 0.2, 0.3]
    assert trace.values("frame") == [6, 12, 18]
    assert trace.values("isPlaying") == [True] * 3


def test_the_timeline_stands_while_it_does_not_play():
    trace = run_node("ReadTime", updates=2, loop_hz=10, playing=False)
    assert trace.values("time") == [0, 0]
    assert trace.values("timeSinceStart") == [0.1, 0.2]
    assert trace.values("isPlaying") == [False] * 2


def test_a_timer_runs_its_value_from_start_to_end():
    inputs = {"duration": 0.4, "startValue": 10, "endValue": 20}
    trace = run_node("Timer", inputs=inputs, pulses={"play": [1]}, updates=7, loop_hz=10)
    assert trace.values("value") == pytest.approx([0, 10, 12.5, 15, 17.5, 20, 20])
    assert trace.fired("updated") == [2, 3, 4, 5]
    assert trace.fired("finished") == [5]


def test_a_running_timer_ignores_play_and_runs_again_later():
    trace = run_node("Timer", inputs={"duration": 0.2}, pulses={"play": [0, 1, 4]}, updates=8, loop_hz=10)
    assert trace.fired("finished") == [2, 6]


def test_a_timer_without_duration_finishes_in_the_next_update():
    trace = run_node("Timer", inputs={"duration": 0}, pulses={"play": [0]}, updates=3)
    assert (trace.fired("finished"), trace.values("value")) == ([1], [0, 1, 1])
    with pytest.raises(ComputeError, match=r"input duration is -1\.0; give it 0 or more seconds"):
        run_node("Timer", inputs={"duration": -1}, pulses={"play": [0]}, updates=2)
