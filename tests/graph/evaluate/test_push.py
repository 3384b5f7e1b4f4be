"""Push and lazy graphs: what computes, in which order, and what does not."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graph import Attribute, ComputeError, Context, compile_graphs, node_type
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec

CHAIN = {"c": "test.Inc", "b": "test.Inc", "a": ("test.Inc", {"a": 1}), "alone": "test.Inc"}
LINKS = ["a.y -> b.a", "b.y -> c.a"]


def test_every_node_computes_once_upstream_first_then_file_order(build, journal, playing):
    graph = build(CHAIN, LINKS, "push")
    graph.evaluate(playing)
    assert journal.take() == ["a", "b", "c", "alone"]
    assert graph.node("c").get("y") == 4.0
    graph.evaluate(playing)
    assert journal.take() == ["a", "b", "c", "alone"]


def test_a_push_graph_does_not_follow_execution(build, journal, playing):
    graph = build({"t": "test.Tick", "n": "test.Count"}, ["t.tick -> n.execIn"], "push")
    graph.evaluate(playing)
    assert journal == ["t", "n"]
    assert graph.node("t").fired == {"tick": 1}


def test_a_lazy_graph_computes_all_at_first_and_then_only_what_changed(build, journal, playing):
    graph = build(CHAIN, LINKS, "dirty_push")
    graph.evaluate(playing)
    assert journal.take() == ["a", "b", "c", "alone"]
    graph.evaluate(playing)
    assert journal.take() == []
    graph.node("b").graph.node("a").set("a", 5)
    graph.evaluate(playing)
    assert journal.take() == ["a", "b", "c"]
    assert graph.node("c").get("y") == 8.0


def test_a_lazy_graph_stops_where_a_value_stays_the_same(build, library, journal, playing):
    @node_type(
        "test.Sign", inputs={"a": Attribute("double", "")}, outputs={"y": Attribute("double", "")}, registry=library
    )
    def sign(db):
        journal.append(db.node.name)
        db.outputs.y = 1.0 if db.inputs.a > 0 else -1.0

    graph = build(
        {"a": ("test.Inc", {"a": 3}), "s": "test.Sign", "z": "test.Inc"}, ["a.y -> s.a", "s.y -> z.a"], "dirty_push"
    )
    graph.evaluate(playing)
    journal.clear()
    graph.node("a").set("a", 4)
    graph.evaluate(playing)
    assert journal == ["a", "s"]


def test_a_lazy_graph_always_computes_nodes_that_read_more_than_their_inputs(build, library, journal, playing):
    @node_type("test.Clock", outputs={"t": Attribute("double", "")}, volatile=True, registry=library)
    def clock(db):
        db.outputs.t = db.context.time

    graph = build({"clock": "test.Clock", "b": "test.Inc", "idle": "test.Inc"}, ["clock.t -> b.a"], "dirty_push")
    for expected in (1 / 60, 2 / 60):
        playing.advance()
        graph.evaluate(playing)
        assert graph.node("b").get("y") == 1 + expected
    assert graph.node("idle").computes == 1


def test_a_lazy_graph_hears_of_values_from_another_graph(library, make_spec, journal, playing):
    one = make_spec({"a": ("test.Inc", {"a": 1})}, (), "push", path="/A")
    two = make_spec({"b": "test.Inc"}, ["/A/a.y -> b.a"], "dirty_push", path="/B")
    first, second = compile_graphs([one, two], library)
    for value in (1, 2):
        first.node("a").set("a", value)
        first.evaluate(playing)
        second.evaluate(playing)
        assert second.node("b").get("y") == value + 2


def test_a_lazy_graph_starts_over_after_a_stop(build, journal, playing):
    graph = build(CHAIN, LINKS, "dirty_push")
    graph.evaluate(playing)
    journal.clear()
    graph.reset()
    graph.evaluate(playing)
    assert journal == ["a", "b", "c", "alone"]


@pytest.mark.parametrize("evaluator", ["push", "dirty_push"])
def test_a_failing_node_stops_the_run_or_is_warned_of(build, playing, evaluator):
    nodes = {"f": ("test.Fail", {"message": "no wheels"}), "b": "test.Inc"}
    graph = build(nodes, [], evaluator)
    with pytest.raises(ComputeError, match=r"g.yaml:1:1: node /World/G/f \(Fail\) failed in update -1: no wheels"):
        graph.evaluate(playing)
    graph = build(nodes, [], evaluator)
    graph.on_error = "continue"
    graph.evaluate(playing)
    assert graph.node("b").get("y") == 1.0
    assert [(w.code, w.where, w.message) for w in playing.warn] == [("compute-failed", "/World/G/f", "no wheels")]


@st.composite
def acyclic(draw):
    """A graph of Sum-like nodes: names in any file order, each with up to two sources of a lower rank."""
    count = draw(st.integers(1, 12))
    order = draw(st.permutations(range(count)))
    links = []
    for rank in range(1, count):
        for side in "ab":
            source = draw(st.none() | st.integers(0, rank - 1))
            if source is not None:
                links.append((source, rank, side))
    return count, order, draw(st.permutations(links)), [draw(st.integers(-5, 5)) for _ in range(count)]


@given(acyclic(), st.sampled_from(["push", "dirty_push", "execution"]))
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_all_evaluators_give_what_the_formula_gives(library, graph, evaluator):
    count, order, links, constants = graph
    if "test.Add" not in library:
        numbers = {name: Attribute("double", name, default=0.0) for name in ("a", "b", "c")}

        @node_type("test.Add", inputs=numbers, outputs={"sum": Attribute("double", "")}, registry=library)
        def add(db):
            db.outputs.sum = db.inputs.a + 2 * db.inputs.b + db.inputs.c

    nodes = [NodeSpec(f"n{rank}", "test.Add", {"c": constants[rank]}) for rank in order]
    connections = [ConnectionSpec(f"n{source}.sum", f"n{target}.{side}") for source, target, side in links]
    if evaluator == "execution":
        nodes += [NodeSpec("tick", "test.Tick"), *(NodeSpec(f"r{rank}", "test.Record") for rank in range(count))]
        for rank in range(count):
            connections += [
                ConnectionSpec("tick.tick", f"r{rank}.execIn"),
                ConnectionSpec(f"n{rank}.sum", f"r{rank}.value"),
            ]
    made = compile_graphs([GraphSpec("/G", tuple(nodes), tuple(connections), evaluator)], library)[0]
    made.evaluate(Context.standalone())
    expected = [float(one) for one in constants]
    for rank in range(count):
        for source, target, side in links:
            if target == rank:
                expected[rank] += expected[source] * (1 if side == "a" else 2)
    assert [made.node(f"n{rank}").get("sum") for rank in range(count)] == expected


def test_setting_the_value_that_is_there_is_no_change_to_a_lazy_graph(build, journal, playing):
    graph = build({"a": ("test.Inc", {"a": 3}), "b": "test.Inc"}, ["a.y -> b.a"], "dirty_push")
    graph.evaluate(playing)
    journal.clear()
    graph.node("a").set("a", 3)
    graph.evaluate(playing)
    assert journal.take() == []
    graph.node("a").request_compute()
    graph.evaluate(playing)
    assert journal.take()[0] == "a"
    graph.node("a").set("a", 4)
    graph.evaluate(playing)
    assert journal.take() == ["a", "b"]
