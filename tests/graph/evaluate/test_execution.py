"""The walk of action graphs: order, data pulled on demand, loops, and how it ends."""

from __future__ import annotations

import math

import pytest

from graph import Attribute, ComputeError, Context, compile_graphs, node_type
from graph.evaluate import RunawayError
from graph.node.registry import Registry
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec
from tests.support.evaluations import run


def test_the_first_wire_is_followed_to_its_end_before_the_next(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "a": "test.Step", "b": "test.Step", "behind_a": "test.Step"},
        ["tick.tick -> a.execIn", "tick.tick -> b.execIn", "a.execOut -> behind_a.execIn"],
    )
    run(graph, playing)
    assert journal == ["tick", "a", "behind_a", "b"]


def test_fan_out_follows_the_order_of_the_connections_not_of_the_nodes(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "a": "test.Step", "b": "test.Step", "c": "test.Step"},
        ["tick.tick -> c.execIn", "tick.tick -> a.execIn", "tick.tick -> b.execIn"],
    )
    run(graph, playing)
    assert journal == ["tick", "c", "a", "b"]


def test_several_fired_outputs_are_followed_in_the_order_of_firing(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "seq": "test.Sequence", "a": "test.Step", "b": "test.Step", "c": "test.Step"},
        [
            "tick.tick -> seq.execIn",
            "seq.output10 -> c.execIn",
            "seq.output0 -> a.execIn",
            "seq.output2 -> b.execIn",
        ],
    )
    run(graph, playing)
    assert journal == ["tick", "seq", "a", "b", "c"]


def test_every_arrival_at_an_execution_input_computes_the_node_again(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "a": "test.Step", "b": "test.Step", "join": "test.Count"},
        [
            "tick.tick -> a.execIn",
            "tick.tick -> b.execIn",
            "a.execOut -> join.execIn",
            "b.execOut -> join.execIn",
        ],
    )
    run(graph, playing)
    assert graph.node("join").get("outputs:count") == 2


def test_event_nodes_fire_in_file_order_each_walk_finished_before_the_next(build, journal, playing):
    graph = build(
        {"late": "test.Tick", "a": "test.Step", "early": "test.Tick", "b": "test.Step"},
        ["late.tick -> a.execIn", "early.tick -> b.execIn"],
    )
    run(graph, playing)
    assert journal == ["late", "a", "early", "b"]


def test_nothing_runs_without_an_event(build, journal, playing):
    graph = build({"a": "test.Step", "add": "test.Inc"})
    run(graph, playing)
    assert journal == []


def test_data_nodes_compute_before_the_node_that_reads_them_and_only_then(build, journal, playing):
    graph = build(
        {
            "tick": "test.Tick",
            "inner": ("test.Inc", {"a": 40}),
            "outer": "test.Inc",
            "idle": "test.Inc",
            "r": "test.Record",
        },
        ["tick.tick -> r.execIn", "inner.y -> outer.a", "outer.y -> r.value", "outer.y -> idle.a"],
    )
    run(graph, playing)
    assert journal == ["tick", "inner", "outer", "r"]
    assert graph.node("r").db.memory == [42.0]


def test_a_data_node_read_along_two_ways_computes_once_for_each_activation(build, journal, playing):
    graph = build(
        {
            "tick": "test.Tick",
            "base": "test.Inc",
            "left": "test.Inc",
            "right": "test.Inc",
            "sum": "test.Sum",
            "r": "test.Record",
        },
        [
            "tick.tick -> r.execIn",
            "base.y -> left.a",
            "base.y -> right.a",
            "left.y -> sum.a",
            "right.y -> sum.b",
            "sum.sum -> r.value",
        ],
    )
    run(graph, playing)
    assert journal == ["tick", "base", "left", "right", "sum", "r"]
    assert graph.node("r").db.memory == [4.0]


def test_a_node_with_execution_is_never_computed_on_demand_its_last_values_are_read(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "reader": "test.Record", "writer": "test.Count"},
        ["tick.tick -> reader.execIn", "tick.tick -> writer.execIn", "writer.count -> reader.value"],
    )
    run(graph, playing, 3)
    # One tick late, because the reader comes first in the file.
    assert graph.node("reader").db.memory == [0.0, 1.0, 2.0]


def test_a_node_with_nothing_to_do_ends_its_walk_and_keeps_its_outputs(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "never": "test.Never", "behind": "test.Step"},
        ["tick.tick -> never.execIn", "never.execOut -> behind.execIn"],
    )
    run(graph, playing)
    assert journal == ["tick", "never"]
    assert graph.node("never").fired == {"execOut": 0}


def test_a_loop_walks_its_body_to_the_end_in_each_pass_and_pulls_data_again(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "loop": "test.Loop", "inc": "test.Inc", "r": "test.Record", "done": "test.Step"},
        [
            "tick.tick -> loop.execIn",
            "loop.body -> r.execIn",
            "loop.finished -> done.execIn",
            "loop.index -> inc.a",
            "inc.y -> r.value",
        ],
    )
    run(graph, playing)
    assert journal == ["tick", "inc", "r", "inc", "r", "inc", "r", "done"]
    assert graph.node("r").db.memory == [1.0, 2.0, 3.0]


def test_loops_nest(build, playing):
    graph = build(
        {
            "tick": "test.Tick",
            "outer": ("test.Loop", {"times": 4}),
            "inner": ("test.Loop", {"times": 5}),
            "n": "test.Count",
        },
        ["tick.tick -> outer.execIn", "outer.body -> inner.execIn", "inner.body -> n.execIn"],
    )
    run(graph, playing)
    assert graph.node("n").get("outputs:count") == 20


def test_a_zero_length_loop_only_finishes(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "loop": ("test.Loop", {"times": 0}), "body": "test.Step", "done": "test.Step"},
        ["tick.tick -> loop.execIn", "loop.body -> body.execIn", "loop.finished -> done.execIn"],
    )
    run(graph, playing)
    assert journal == ["tick", "done"]


def test_activations_start_at_the_given_input_after_the_events(build, journal, playing):
    graph = build({"a": "test.Step", "tick": "test.Tick", "b": "test.Step"}, ["a.execOut -> b.execIn"])
    graph.evaluate(playing, [("b", "execIn"), (graph.node("a"), "execIn")])
    assert journal == ["tick", "b", "a", "b"]


def test_an_execution_loop_without_a_latent_node_ends_with_the_nodes_that_go_round(build, playing):
    graph = build(
        {"tick": "test.Tick", "a": "test.Step", "b": "test.Step", "c": "test.Step"},
        ["tick.tick -> a.execIn", "a.execOut -> b.execIn", "b.execOut -> c.execIn", "c.execOut -> b.execIn"],
    )
    graph.step_limit = 1000
    with pytest.raises(RunawayError, match=r"goes round without end \((b -> c -> b|c -> b -> c)\): 1000 steps"):
        run(graph, playing)


def test_a_runaway_names_the_way_that_goes_on_in_the_next_update(build, playing):
    graph = build({"tick": "test.Tick", "a": "test.Step"}, ["tick.tick -> a.execIn", "a.execOut -> a.execIn"])
    graph.step_limit = 1000
    hint = r"lead the loop through SendCustomEvent and OnCustomEvent, which go on in the next update, or use ForLoop"
    with pytest.raises(RunawayError, match=hint):
        run(graph, playing)


def test_a_loop_of_too_many_passes_is_named_and_nothing_goes_round(build, playing):
    graph = build(
        {"tick": "test.Tick", "loop": ("test.Loop", {"times": 5000}), "n": "test.Count"},
        ["tick.tick -> loop.execIn", "loop.body -> n.execIn"],
    )
    graph.step_limit = 1000
    with pytest.raises(RunawayError, match="loop loop makes more than 1000 passes in update 0; give it fewer"):
        run(graph, playing)


def test_a_loop_that_finishes_into_itself_is_a_runaway_too(build, playing):
    graph = build(
        {"tick": "test.Tick", "loop": "test.Loop"},
        ["tick.tick -> loop.execIn", "loop.finished -> loop.execIn"],
    )
    graph.step_limit = 1000
    with pytest.raises(RunawayError, match=r"loop -> loop"):
        run(graph, playing)


def test_a_loop_that_enters_itself_from_its_body_is_a_runaway_too(build, playing):
    graph = build({"tick": "test.Tick", "loop": "test.Loop"}, ["tick.tick -> loop.execIn", "loop.body -> loop.execIn"])
    graph.step_limit = 1000
    with pytest.raises(RunawayError, match=r"loop -> loop"):
        run(graph, playing)


def test_a_long_loop_is_not_a_runaway_for_what_its_body_does(build, playing):
    graph = build(
        {
            "tick": "test.Tick",
            "loop": ("test.Loop", {"times": 900}),
            "a": "test.Step",
            "b": "test.Step",
            "n": "test.Count",
        },
        ["tick.tick -> loop.execIn", "loop.body -> a.execIn", "a.execOut -> b.execIn", "b.execOut -> n.execIn"],
    )
    graph.step_limit = 1000
    run(graph, playing)
    assert graph.node("n").get("outputs:count") == 900


def test_a_chain_of_ten_thousand_nodes_needs_no_recursion(build, playing):
    count = 10_000
    nodes = {"tick": "test.Tick"} | {f"n{i}": "test.Step" for i in range(count)}
    links = ["tick.tick -> n0.execIn", *(f"n{i}.execOut -> n{i + 1}.execIn" for i in range(count - 1))]
    graph = build(nodes, links)
    run(graph, playing)
    assert graph.node(f"n{count - 1}").computes == 1


def test_a_chain_of_ten_thousand_data_nodes_is_pulled_without_recursion(build, playing):
    count = 10_000
    nodes = {"tick": "test.Tick", "r": "test.Record"} | {f"n{i}": "test.Inc" for i in range(count)}
    links = ["tick.tick -> r.execIn", f"n{count - 1}.y -> r.value"]
    links += [f"n{i}.y -> n{i + 1}.a" for i in reversed(range(count - 1))]
    graph = build(nodes, links)
    run(graph, playing)
    assert graph.node("r").db.memory == [10_000.0]


def test_firing_an_output_that_does_not_exist_names_the_nearest(build, library, playing):
    from graph import Attribute, node_type

    @node_type("test.Typo", outputs={"finished": Attribute("execution", "end")}, event=True, registry=library)
    def typo(db):
        db.fire("finishd")

    with pytest.raises(ComputeError, match=r'has no execution output "finishd"; did you mean "finished"'):
        run(build({"t": "test.Typo"}), playing)


def test_two_graphs_do_not_share_anything(build, playing):
    nodes, links = {"tick": "test.Tick", "n": "test.Count"}, ["tick.tick -> n.execIn"]
    one, two = build(nodes, links), build(nodes, links)
    run(one, playing, 3)
    run(two, playing)
    assert (one.node("n").computes, two.node("n").computes) == (3, 1)


def test_a_node_cannot_evaluate_its_own_graph(build, library):
    from graph import node_type

    @node_type("test.Self", event=True, registry=library)
    def evaluates_itself(db):
        db.node.graph.evaluate(db.context)

    with pytest.raises(ComputeError, match=r"being evaluated already"):
        build({"s": "test.Self"}).evaluate(Context.standalone())


@pytest.mark.parametrize("times", [0, -3])
def test_a_loop_of_no_pass_goes_straight_to_its_end(build, playing, journal, times):
    graph = build(
        {"tick": "test.Tick", "loop": ("test.Loop", {"times": times}), "body": "test.Step", "end": "test.Step"},
        ["tick.tick -> loop.execIn", "loop.body -> body.execIn", "loop.finished -> end.execIn"],
    )
    graph.evaluate(playing)
    assert journal.take() == ["tick", "end"]


def test_an_input_that_is_not_a_finite_number_is_named_where_python_gives_up():
    registry = Registry()

    @node_type("test.Sine", inputs={"x": Attribute("double[]", "angles")}, registry=registry)
    def sine(db):
        """Fails for infinite numbers."""
        math.sin(db.inputs.x[1])

    nodes = (NodeSpec("sine", "test.Sine", {"x": [1.0, math.inf]}),)
    [graph] = compile_graphs([GraphSpec("/G", nodes, evaluator="push")], registry)
    message = r"input x is \[1.0, inf\]; give it finite numbers \(ValueError: math domain error\)"
    with pytest.raises(ComputeError, match=message):
        graph.evaluate(Context.standalone())


def test_an_input_whose_source_gave_nothing_is_named_where_python_gives_up():
    registry = Registry()

    @node_type("test.Source", outputs={"y": Attribute("any", "nothing, ever")}, registry=registry)
    def source(db):
        """Leaves its output as it is."""

    @node_type("test.Half", inputs={"x": Attribute("any", "a number")}, registry=registry)
    def half(db):
        """Fails for a value that is not a number."""
        db.inputs.x / 2

    nodes = (NodeSpec("source", "test.Source"), NodeSpec("half", "test.Half"))
    spec = GraphSpec("/G", nodes, (ConnectionSpec("source.y", "half.x"),), evaluator="push")
    [graph] = compile_graphs([spec], registry)
    with pytest.raises(ComputeError, match=r"input x has no value; see what feeds it \(TypeError: unsupported"):
        graph.evaluate(Context.standalone())
