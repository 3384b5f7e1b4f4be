"""What a node keeps, what a stop takes back, and what it may see of the world."""

from __future__ import annotations

import numpy as np
import pytest

from graph import Attribute, ComputeError, Context, declare, node_type
from graph.node.context import WarningLog
from graph.sim.warnings import WarningList
from tests.support.evaluations import run, watch


def test_a_stop_brings_back_values_memory_state_and_variables(build, library, playing):
    graph = build(
        {"tick": "test.Tick", "n": ("test.Count", {"state:count": 10}), "r": "test.Record"},
        ["tick.tick -> n.execIn", "n.execOut -> r.execIn", "n.count -> r.value"],
        variables={"gain": ("double", 2)},
    )
    run(graph, playing, 2)
    graph.variables["gain"] = 5
    assert graph.node("r").db.memory == [11.0, 12.0]
    graph.reset()
    assert graph.node("n").get("outputs:count") == 0
    assert graph.node("n").get("state:count") == 10
    assert graph.node("r").get("value") == 0.0
    assert graph.variables["gain"] == 2.0
    run(graph, playing)
    assert graph.node("r").db.memory == [11.0]
    assert graph.node("n").computes == 3


def test_values_set_from_outside_outlive_a_stop(build, playing):
    graph = build({"c": "test.Constant", "b": "test.Inc"}, ["c.value -> b.a"], "push")
    graph.node("c").set("value", 4)
    graph.reset()
    graph.evaluate(playing)
    assert graph.node("b").get("y") == 5.0


@pytest.mark.parametrize(
    ("node", "name", "value", "message"),
    [
        ("b", "a", 1, "/World/G/b.inputs:a is connected; set its source"),
        ("b", "y", 1, "/World/G/b.outputs:y is an output; set its source"),
        ("c", "value", "x", "/World/G/c.inputs:value: expected a number"),
    ],
)
def test_set_refuses_what_would_not_last(build, node, name, value, message):
    graph = build({"c": "test.Constant", "b": "test.Inc"}, ["c.value -> b.a"])
    with pytest.raises(ValueError, match=message):
        graph.node(node).set(name, value)


def test_unknown_names_suggest_the_nearest(build):
    graph = build({"count": "test.Count"})
    with pytest.raises(KeyError, match=r'graph /World/G has no node "cuont"; did you mean "count"'):
        graph.node("cuont")
    with pytest.raises(
        KeyError, match=r'node /World/G/count \(Count\) has no attribute "execout"; did you mean "execOut"'
    ):
        graph.node("count").get("execout")


def test_release_is_called_on_stop_and_close_once_for_each_use(build, library, playing):
    released = []

    @node_type(
        "test.Holder", event=True, memory=list, release=lambda db: released.append(list(db.memory)), registry=library
    )
    def holder(db):
        db.memory.append(db.context.update)

    graph = build({"h": "test.Holder"})
    graph.close()
    assert released == []
    run(graph, playing, 2)
    graph.reset()
    assert released == [[0, 1]]
    run(graph, playing)
    graph.close()
    graph.close()
    assert released == [[0, 1], [2]]


def test_prepare_pulls_the_inputs_and_is_released_too(build, library, journal, playing):
    seen, released = [], []

    @node_type(
        "test.Asks",
        inputs={"execIn": Attribute("execution", ""), "value": Attribute("double", "")},
        memory=list,
        prepare=lambda db: seen.append(db.inputs.value),
        release=lambda db: released.append(db.path),
        registry=library,
    )
    def asks(db):
        pass

    graph = build({"inc": ("test.Inc", {"a": 4}), "n": "test.Asks", "other": "test.Inc"}, ["inc.y -> n.value"])
    graph.node("n").prepare(playing)
    graph.node("other").prepare(playing)
    assert (seen, journal, graph.node("n").computes) == ([5.0], ["inc"], 0)
    graph.close()
    assert released == ["/World/G/n"]


def test_a_failing_node_names_itself_its_place_and_the_update_and_keeps_the_cause(build, playing):
    graph = build({"tick": "test.Tick", "f": "test.Fail"}, ["tick.tick -> f.execIn"])
    with pytest.raises(ComputeError) as caught:
        run(graph, playing)
    assert str(caught.value) == (
        "g.yaml:2:1: node /World/G/f (Fail) failed in update 0: ZeroDivisionError: division by zero"
    )
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    assert (caught.value.node.path, caught.value.update) == ("/World/G/f", 0)


def test_with_continue_a_failing_node_has_nothing_to_do_and_is_counted(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "f": "test.Fail", "behind": "test.Step", "next": "test.Step"},
        ["tick.tick -> f.execIn", "f.execOut -> behind.execIn", "tick.tick -> next.execIn"],
    )
    graph.on_error = "continue"
    run(graph, playing, 3)
    assert journal[:3] == ["tick", "f", "next"]
    (warned,) = playing.warn
    assert (warned.code, warned.where, warned.count) == ("compute-failed", "/World/G/f", 3)


def test_a_value_that_does_not_fit_its_reader_fails_the_node_that_wrote_it(build, library, playing):
    declare("test.Int", "An int.", inputs={"n": Attribute("int", "")}, registry=library)
    graph = build({"big": ("test.Inc", {"a": 1e20}), "i": "test.Int"}, ["big.y -> i.n"], "push")
    with pytest.raises(ComputeError, match=r"node /World/G/big .* does not fit int"):
        graph.evaluate(playing)


def test_a_node_that_needs_a_world_says_so(build, library, playing):
    @node_type("test.Worldly", event=True, registry=library)
    def worldly(db):
        db.outputs.x = db.app

    with pytest.raises(ComputeError, match=r"this node needs a world; run its graph in an App"):
        run(build({"w": "test.Worldly"}), playing)


def test_nodes_read_and_write_the_variables_of_their_graph(build, library, playing):
    @node_type("test.Doubles", event=True, registry=library)
    def doubles(db):
        db.variables["gain"] = db.variables["gain"] * 2

    graph = build({"d": "test.Doubles"}, variables={"gain": ("double", 1.5), "v": ("double[3]", None)})
    run(graph, playing, 2)
    assert graph.variables["gain"] == 6.0
    assert graph.variables["v"].tolist() == [0, 0, 0]
    with pytest.raises(KeyError, match=r'the graph has no variable "gian"; did you mean "gain"'):
        graph.variables["gian"]
    with pytest.raises(ValueError, match=r"expected a number"):
        graph.variables["gain"] = "x"


def test_variables_tell_who_watches(build):
    variables = build({}, variables={"gain": ("double", 1)}).variables
    told = []
    end = variables.watch(told.append)
    variables["gain"] = 2
    end()
    variables["gain"] = 3
    assert told == ["gain"]


def test_nodes_know_what_is_connected(build, library, playing):
    known = {}

    @node_type(
        "test.Knows",
        inputs={"a": Attribute("double", ""), "b": Attribute("double", "")},
        outputs={"tick": Attribute("execution", ""), "y": Attribute("double", ""), "z": Attribute("double", "")},
        event=True,
        registry=library,
    )
    def knows(db):
        known["connected"] = [name for name in ("a", "b", "tick") if db.connected(name)]
        known["consumed"] = [name for name in ("y", "z") if db.consumed(name)]
        known["types"] = (db.input_type("a"), db.output_type("y"))

    graph = build({"c": "test.Constant", "k": "test.Knows", "r": "test.Record"}, ["c.value -> k.a", "k.z -> r.value"])
    run(graph, playing)
    assert known == {"connected": ["a"], "consumed": ["z"], "types": ("double", "double")}


def test_readers_see_arrays_of_the_right_type_before_and_after_a_compute(build, library, playing):
    @node_type("test.Triple", outputs={"v": Attribute("float[3]", "")}, registry=library)
    def triple(db):
        db.outputs.v = (1, 2, 3)

    declare("test.Takes", "A vector.", inputs={"v": Attribute("vectorf[3]", "")}, registry=library)
    graph = build({"t": "test.Triple", "x": "test.Takes"}, ["t.v -> x.v"], "push")
    assert graph.node("x").get("v").tolist() == [0, 0, 0]
    graph.evaluate(playing)
    assert graph.node("x").get("v").dtype == np.float32
    assert graph.node("x").get("v").tolist() == [1, 2, 3]


def test_warnings_are_collected_once_for_each_code_and_place():
    log = WarningLog()
    for _ in range(3):
        log("slow", "/a", "too slow")
    log("slow", "/b", "too slow")
    assert [(w.code, w.where, w.count) for w in log] == [("slow", "/a", 3), ("slow", "/b", 1)]
    assert len(log) == 2


@pytest.mark.parametrize("kind", [WarningLog, WarningList])
def test_what_a_node_says_itself_is_one_warning_for_each_message_up_to_ten(kind):
    log = kind()
    say = getattr(log, "add", log)
    for _ in range(2):
        say("node-warning", "/a", "battery low")
        say("node-warning", "/a", "motor hot")
    assert [(one.message, one.count) for one in log] == [("battery low", 2), ("motor hot", 2)]
    for tick in range(100):  # 8 of them are listed, 92 are counted together
        say("node-warning", "/a", f"tick {tick}")
    assert [(one.message, one.count) for one in log][2:] == [*((f"tick {i}", 1) for i in range(8)), ("tick 8", 92)]


def test_a_compute_says_warnings_and_errors_that_are_collected_and_writes_to_the_log(build, library, playing, caplog):
    @node_type("test.Says", registry=library)
    def compute(db):
        """Says three things."""
        db.log_warning("battery low")
        db.log_error("motor hot")
        db.log_info("going on")

    caplog.set_level("INFO", "tickgraph")
    graph = build({"x": "test.Says"}, [], "push")
    run(graph, playing, 2)
    assert [(one.code, one.where, one.message, one.count) for one in playing.warn] == [
        ("node-warning", "/World/G/x", "battery low", 2),
        ("node-error", "/World/G/x", "motor hot", 2),
    ]
    assert caplog.messages == ["/World/G/x: going on"] * 2


def test_a_standalone_context_counts_exact_updates():
    context = Context.standalone(29.97)
    for _ in range(2997):
        context.advance()
    assert (context.time, context.update, context.is_playing) == (100.0, 2996, True)
    assert context.frame == 6000.0


@pytest.mark.parametrize("evaluator", ["execution", "push", "dirty_push"])
def test_tools_may_wrap_every_compute_even_after_the_first_evaluation(build, playing, evaluator):
    graph = build(
        {"c": "test.Constant", "t": "test.Tick", "s": "test.Record", "i": "test.Inc"},
        ["t.tick -> s.execIn", "c.value -> i.a", "i.y -> s.value"],
        evaluator,
    )
    run(graph, playing)
    seen = watch(graph)
    graph.node("c").set("value", 3)
    run(graph, playing)
    assert seen == ["t", "i", "s"]
    assert graph.node("s").db.memory == [1.0, 4.0]
