import pytest

from graph import Attribute, ComputeError, compile_graphs, node_type
from graph.node.context import Context
from graph.node.registry import DEFAULT, Registry
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec
from graph.testing import run_node


def test_a_loop_from_1_below_4_by_2_has_the_values_1_and_3_and_ends_at_5():
    trace = run_node("ForLoop", inputs={"start": 1, "stop": 4, "step": 2}, pulses={"execIn": [0]}, updates=1)
    assert trace.fires == [(0, "loopBody"), (0, "loopBody"), (0, "finished")]
    assert (trace.value("value"), trace.value("index"), trace.value("state:i")) == (5, 1, -1)


def test_a_loop_counts_down_with_a_negative_step():
    trace = run_node("ForLoop", inputs={"start": 3, "stop": 0, "step": -1}, pulses={"execIn": [0]}, updates=1)
    assert len(trace.fired("loopBody")) == 3
    assert trace.value("value") == 0


def test_a_loop_that_has_nothing_to_do_only_finishes():
    trace = run_node("ForLoop", inputs={"start": 2, "stop": 2}, pulses={"execIn": [0]}, updates=1)
    assert trace.fires == [(0, "finished")]


def test_a_loop_with_step_0_is_refused():
    with pytest.raises(ComputeError, match="step is 0"):
        run_node("ForLoop", inputs={"step": 0}, pulses={"execIn": [0]}, updates=1)


def test_each_element_gets_a_pass_and_the_last_values_stay():
    trace = run_node(
        "ForEach",
        inputs={"arrayIn": {"type": "double[]", "value": [1.5, 2.5, 3.5]}},
        pulses={"execIn": [0]},
        updates=1,
    )
    assert trace.fires == [(0, "loopBody")] * 3 + [(0, "finished")]
    assert (trace.value("arrayIndex"), trace.value("element")) == (2, 3.5)


def test_an_empty_array_only_finishes():
    trace = run_node("ForEach", inputs={"arrayIn": {"type": "int[]", "value": []}}, pulses={"execIn": [0]}, updates=1)
    assert trace.fires == [(0, "finished")]


@pytest.fixture
def looping():
    """A loop 0 ... 9 whose body notes (index, value) and breaks after value 2; finished is noted too."""
    seen = []
    registry = Registry()
    for name in ("omni.graph.action.ForLoop", "omni.graph.action.OnPlaybackTick", "omni.graph.action.Branch"):
        registry.add(DEFAULT.get(name))

    @node_type(
        "test.Note",
        inputs={
            "body": Attribute("execution", "a pass"),
            "done": Attribute("execution", "the end"),
            "index": Attribute("int", "index"),
            "value": Attribute("int", "value"),
        },
        outputs={"stop": Attribute("execution", "breaks")},
        registry=registry,
    )
    def note(db):
        """Notes passes."""
        seen.append(("done" if db.triggered("done") else "body", db.inputs.index, db.inputs.value))
        if db.triggered("body") and db.inputs.value == 2:
            db.fire("stop")

    spec = GraphSpec(
        "/World/Graph",
        (
            NodeSpec("tick", "OnPlaybackTick"),
            NodeSpec("loop", "ForLoop", {"stop": 10}),
            NodeSpec("note", "test.Note"),
        ),
        tuple(
            ConnectionSpec(source, target)
            for source, target in [
                ("tick.tick", "loop.execIn"),
                ("loop.loopBody", "note.body"),
                ("loop.finished", "note.done"),
                ("loop.index", "note.index"),
                ("loop.value", "note.value"),
                ("note.stop", "loop.breakLoop"),
            ]
        ),
    )
    return compile_graphs([spec], registry)[0], seen


def test_a_break_lets_the_body_finish_and_keeps_index_and_value(looping):
    graph, seen = looping
    context = Context.standalone()
    context.advance()
    graph.evaluate(context)
    assert seen == [("body", 0, 0), ("body", 1, 1), ("body", 2, 2), ("done", 2, 2)]


def test_a_loop_that_was_broken_runs_again_from_the_start(looping):
    graph, seen = looping
    context = Context.standalone()
    for _ in range(2):
        context.advance()
        graph.evaluate(context)
    assert seen[4:] == seen[:4]


def test_a_loop_of_more_passes_than_one_update_can_have_is_refused_at_once():
    with pytest.raises(ComputeError, match="make 2147483647 passes in one update; at most 1000000 are possible"):
        run_node("ForLoop", inputs={"stop": 2_147_483_647}, pulses={"execIn": [0]})


def test_a_loop_without_bound_may_end_by_its_break():
    nodes = (
        NodeSpec("tick", "OnTick"),
        NodeSpec("loop", "ForLoop", {"stop": 2_147_483_647}),
        NodeSpec("stop", "Compare", {"b": 4, "operation": "=="}),
        NodeSpec("branch", "Branch"),
    )
    links = (
        "tick.tick -> loop.execIn",
        "loop.loopBody -> branch.execIn",
        "loop.index -> stop.a",
        "stop.result -> branch.condition",
        "branch.execTrue -> loop.breakLoop",
    )
    graph = compile_graphs([GraphSpec("/G", nodes, tuple(ConnectionSpec(*one.split(" -> ")) for one in links))])[0]
    graph.evaluate(Context.standalone())
    assert graph.node("loop").get("index") == 4
