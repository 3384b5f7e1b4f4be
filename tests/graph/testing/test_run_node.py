"""`run_node`: the kit that node tests stand on."""

from __future__ import annotations

import numpy as np
import pytest

from graph import Attribute, ComputeError, UserError, node_type
from graph.testing import run_node


@pytest.fixture
def run(library):
    return lambda name, **options: run_node(name, registry=library, **options)


def test_pulses_are_update_indices_and_so_are_firings(run):
    trace = run("test.Wait", inputs={"updates": 3}, pulses={"execIn": [1]}, updates=6)
    assert trace.fired("tick") == [2, 3, 4]
    assert trace.fired("finished") == [4]
    assert trace.computes == 4


def test_values_are_those_after_each_update(run):
    trace = run("test.Count", pulses={"execIn": [0, 2, 2]}, updates=4)
    assert trace.values("count") == [1, 1, 3, 3]
    assert trace.values("state:count") == [1, 1, 3, 3]
    assert trace.value("count") == 3
    assert trace.fired("execOut") == [0, 2, 2]


def test_a_pulse_after_the_last_update_is_refused(run):
    with pytest.raises(UserError, match="pulses: execIn: update 7 comes after the last one, 1; give more updates"):
        run("test.Count", pulses={"execIn": [0, 7]}, updates=2)


def test_event_nodes_need_no_pulses_and_data_nodes_no_evaluator(run):
    assert run("test.Tick", updates=3).fired("tick") == [0, 1, 2]
    assert run("test.Inc", inputs={"a": 41}).value("y") == 42.0


def test_the_order_of_firing_is_kept(run):
    trace = run("test.Sequence", pulses={"execIn": [0]}, outputs=["output1", "output0"])
    assert trace.fires == [(0, "output0"), (0, "output1")]


def test_inputs_may_change_with_every_update(run):
    assert run("test.Inc", inputs={"a": lambda update: update * 10}, updates=3).values("y") == [1.0, 11.0, 21.0]


def test_open_inputs_take_a_typed_value_or_what_it_looks_like(run):
    typed = {"type": "float[3]", "value": [1, 2, 3]}
    trace = run("test.Sum", inputs={"a": typed, "b": typed})
    assert trace.value("sum").tolist() == [2, 4, 6]
    assert trace.value("sum").dtype == np.float32
    assert run("test.Sum", inputs={"a": 1, "b": 2, "c": 3}).value("sum") == 6


def test_values_are_as_a_reader_gets_them(run, library):
    @node_type("test.Pair", outputs={"v": Attribute("double[]", "")}, registry=library)
    def pair(db):
        db.outputs.v = (1, 2)

    assert run("test.Pair").value("v").tolist() == [1.0, 2.0]


def test_connected_inputs_count_as_connected_and_get_their_values_all_the_same(run, library):
    @node_type(
        "test.Asks",
        inputs={"a": Attribute("double", "")},
        outputs={"known": Attribute("bool", ""), "y": Attribute("double", ""), "read": Attribute("bool", "")},
        registry=library,
    )
    def asks(db):
        db.outputs.known = db.connected("a")
        db.outputs.read = db.consumed("y")
        db.outputs.y = db.inputs.a

    trace = run(
        "test.Asks", inputs={"a": lambda update: update + 1}, connect={"a": "double"}, consumed=["known"], updates=2
    )
    assert (trace.value("known"), trace.value("read"), trace.values("y")) == (True, False, [1.0, 2.0])


def test_it_behaves_as_playing_by_default(run, library):
    @node_type("test.Plays", outputs={"playing": Attribute("bool", ""), "t": Attribute("double", "")}, registry=library)
    def plays(db):
        db.outputs.playing = db.context.is_playing
        db.outputs.t = db.context.time

    trace = run("test.Plays", updates=2, loop_hz=10)
    assert (trace.values("playing"), trace.values("t")) == ([True, True], [0.1, 0.2])
    trace = run("test.Plays", updates=3, loop_hz=10, playing=lambda update: update != 1)
    assert (trace.values("playing"), trace.values("t")) == ([True, False, True], [0.1, 0.1, 0.2])


def test_warnings_are_on_the_trace(run, library):
    @node_type("test.Warns", registry=library)
    def warns(db):
        db.warn("low-battery", "20 % left")

    (warned,) = run("test.Warns", updates=3).warnings
    assert (warned.code, warned.where, warned.message, warned.count) == ("low-battery", "/test/node", "20 % left", 3)


def test_an_output_of_the_wrong_kind_fails_the_test(run, library):
    @node_type("test.Wrong", outputs={"n": Attribute("int", "")}, registry=library)
    def wrong(db):
        db.outputs.n = "seven"

    with pytest.raises(AssertionError, match=r"test.Wrong wrote a wrong value to outputs:n in update 0"):
        run("test.Wrong", consumed=[])


def test_variables_and_interrupts(run, library):
    @node_type("test.Reads", outputs={"gain": Attribute("double", "")}, registry=library)
    def reads(db):
        db.outputs.gain = db.variables["gain"]

    assert run("test.Reads", variables={"gain": ("double", 2)}).value("gain") == 2.0
    restarted = run("test.Wait", pulses={"execIn": [0, 1]}, updates=6, interrupts=True)
    assert restarted.fired("finished") == [3]


def test_mistakes_in_the_test_are_reported(run):
    with pytest.raises(UserError, match=r'no node type "test.Wiat"; did you mean "test.Wait"'):
        run("test.Wiat")
    with pytest.raises(UserError, match=r'has no input "update"; did you mean "updates"'):
        run("test.Wait", inputs={"update": 1})
    with pytest.raises(UserError, match=r'^pulses: test.Wait has no input "execInn"; did you mean "execIn"\?$'):
        run("test.Wait", pulses={"execInn": [0]})
    with pytest.raises(
        UserError, match=r'^pulses: "updates" of test.Wait is not an execution input; set it by inputs$'
    ):
        run("test.Wait", pulses={"updates": [0]})
    with pytest.raises(UserError, match=r"^pulses: execIn: updates are numbered 0, 1, 2 ...; -1 is not one of them$"):
        run("test.Wait", pulses={"execIn": [0, -1]})
    with pytest.raises(UserError, match=r"^pulses: execIn: 'int' object is not iterable$"):
        run("test.Wait", pulses={"execIn": 3})
    for updates in (-1, 2.5, True):
        with pytest.raises(UserError, match=rf"^updates: expected a whole number from 0, got {updates}$"):
            run("test.Wait", updates=updates)
    trace = run("test.Count", pulses={"execIn": [0]})
    with pytest.raises(KeyError, match=r"is not an execution output"):
        trace.fired("count")
    with pytest.raises(KeyError, match=r'has no attribute "outputs:execuot"'):
        trace.fired("execuot")
    with pytest.raises(KeyError, match=r"is an execution attribute"):
        trace.values("execOut")
    with pytest.raises(ComputeError, match=r"stop it"):
        run("test.Fail", inputs={"message": "stop it"}, pulses={"execIn": [0]})


class _App:
    """As much of an App as a context follows."""

    def __init__(self):
        from fractions import Fraction

        self.timeline = self.simulation = self
        self.delta = Fraction(1, 50)
        self.loop_rate = Fraction(50)
        self.loop_time = self.current_time = self.monotonic_time = Fraction(0)
        self.time_codes_per_second = Fraction(60)
        self.update_index = 0
        self.subscribers = {}
        self.playing = False

    def is_playing(self):
        return self.playing

    def is_stopped(self):
        return not self.playing

    def play(self):
        self.playing = True

    def on(self, phase, callback):
        self.subscribers[phase] = callback
        return lambda: self.subscribers.pop(phase)

    def update(self):
        self.loop_time += self.delta
        self.current_time += self.delta
        self.monotonic_time += self.delta
        self.subscribers["simulation_graphs"]()
        self.update_index += 1


def test_in_an_app_it_plays_follows_its_time_and_leaves_no_subscriber(run, library):
    @node_type("test.InApp", outputs={"t": Attribute("double", ""), "d": Attribute("double", "")}, registry=library)
    def in_app(db):
        assert db.app.playing
        db.outputs.t = db.context.time
        db.outputs.d = db.context.delta_seconds

    app = _App()
    trace = run("test.InApp", updates=3, app=app)
    assert trace.values("t") == [0.02, 0.04, 0.06]
    assert trace.values("d") == [0.02, 0.02, 0.02]
    assert app.subscribers == {}


def test_added_outputs_are_named_short_or_in_full():
    for names in (["output1", "output2"], ["outputs:output0", "outputs:output1", "outputs:output2"]):
        trace = run_node("Multigate", pulses={"execIn": range(4)}, outputs=names, updates=4)
        assert [trace.fired(f"output{one}") for one in range(3)] == [[0, 3], [1], [2]]


def test_consumed_outputs_are_named_short_or_in_full():
    for name in ("count", "outputs:count"):
        trace = run_node("Counter", pulses={"execIn": [0]}, consumed=[name])
        assert trace.node.consumed("count")
