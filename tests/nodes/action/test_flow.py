import pytest

from graph.testing import run_node


@pytest.mark.parametrize(("condition", "way"), [(True, "execTrue"), (False, "execFalse")])
def test_branch_goes_one_way(condition, way):
    trace = run_node("Branch", inputs={"condition": condition}, pulses={"execIn": [0, 2]}, updates=3)
    assert trace.fires == [(0, way), (2, way)]


def test_a_closed_gate_opens_and_closes_by_toggle():
    trace = run_node("Gate", inputs={"startClosed": True}, pulses={"enter": [0, 2, 3, 5], "toggle": [1, 4]}, updates=6)
    assert trace.fired("exit") == [2, 3]
    assert trace.computes == 6


def test_a_gate_starts_open_by_default():
    assert run_node("Gate", pulses={"enter": [0, 2], "toggle": [1]}, updates=3).fired("exit") == [0]


def test_a_stop_puts_a_gate_back():
    def stop_at_2(update, node):
        if update == 2:
            node.graph.reset()

    trace = run_node("Gate", pulses={"toggle": [0], "enter": [1, 2]}, updates=3, on_update=stop_at_2)
    assert trace.fired("exit") == [2]


def test_once_tells_the_first_activation_from_the_later_ones():
    trace = run_node("Once", pulses={"execIn": [0, 1, 2, 4, 5], "reset": [3]}, updates=6)
    assert trace.fires == [(0, "once"), (1, "after"), (2, "after"), (4, "once"), (5, "after")]


def test_a_counter_counts_and_its_reset_fires_nothing():
    trace = run_node("Counter", pulses={"execIn": [0, 1, 1, 3], "reset": [2]}, updates=4)
    assert trace.fired("execOut") == [0, 1, 1, 3]
    assert trace.values("count") == [1, 3, 0, 1]
    assert trace.values("state:count") == [1, 3, 0, 1]


def test_flip_flop_alternates():
    trace = run_node("FlipFlop", pulses={"execIn": range(3)}, updates=3)
    assert trace.fires == [(0, "a"), (1, "b"), (2, "a")]
    assert trace.values("isA") == [True, False, True]


def test_multisequence_follows_its_outputs_in_numeric_order():
    trace = run_node("Multisequence", pulses={"execIn": [0, 1]}, updates=2, outputs=["output10", "output1", "output2"])
    once = ["output0", "output1", "output2", "output10"]
    assert [name for _, name in trace.fires] == once * 2


def test_multigate_takes_its_outputs_in_turn_and_reset_fires_nothing():
    trace = run_node(
        "Multigate",
        pulses={"execIn": [0, 1, 2, 3, 4, 6], "reset": [5]},
        updates=7,
        outputs=["output1", "output2"],
    )
    turns = ["output0", "output1", "output2", "output0", "output1", "output0"]
    assert trace.fires == list(zip([0, 1, 2, 3, 4, 6], turns, strict=True))


def test_switch_token_follows_the_output_of_the_equal_branch():
    words = ["left", "right", "up", "left"]
    trace = run_node(
        "SwitchToken",
        inputs={"branch00": "left", "branch01": "right", "branch02": "left", "value": lambda update: words[update]},
        outputs=["output00", "output01", "output02"],
        pulses={"execIn": range(4)},
        updates=4,
    )
    assert trace.fires == [(0, "output00"), (1, "output01"), (3, "output00")]


def test_switch_token_without_the_output_follows_nothing():
    trace = run_node("SwitchToken", inputs={"branch00": "left", "value": "left"}, pulses={"execIn": [0]}, updates=1)
    assert trace.fires == []
