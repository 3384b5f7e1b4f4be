"""What an edit leaves as it was, and when it takes effect."""

import pytest

from graph import Attribute, ComputeError, Controller, OmniGraphError, node_type
from tests.support.evaluations import watch

K = Controller.Keys
ACTION = {"graph_path": "/World/G", "evaluator_name": "execution"}


@pytest.fixture
def scripted(library, control):
    """Registers test.Script, a node that runs what `scripted` is set to."""
    script = {}

    @node_type(
        "test.Script",
        inputs={"execIn": Attribute("execution", "runs")},
        outputs={"execOut": Attribute("execution", "follows")},
        registry=library,
    )
    def run(db):
        """Runs a script once."""
        action = script.pop("action", None)
        if action is not None:
            action(db)
        db.fire("execOut")

    return script


def test_memory_state_outputs_and_counts_stay(control):
    graph, nodes, _, _ = control.edit(
        ACTION,
        {
            K.CREATE_NODES: [("tick", "test.Tick"), ("count", "test.Count"), ("record", "test.Record")],
            K.CONNECT: [
                ("tick.outputs:tick", "count.inputs:execIn"),
                ("count.outputs:execOut", "record.inputs:execIn"),
            ],
        },
    )
    for _ in range(3):
        control.evaluate_sync(graph)
    control.edit(graph, {K.CONNECT: ("count.outputs:count", "record.inputs:value")})
    assert graph.nodes["count"] is nodes[1]
    assert nodes[1].get("outputs:count") == nodes[1].get("state:count") == 3
    assert nodes[2].get("value") == 3.0, "a new connection brings the present value"
    control.evaluate_sync(graph)
    assert nodes[2].db.memory == [0.0, 0.0, 0.0, 4.0]
    assert nodes[1].computes == 4
    assert nodes[1].fired["execOut"] == 4


def test_who_sleeps_sleeps_on(control):
    graph, nodes, _, _ = control.edit(
        ACTION,
        {
            K.CREATE_NODES: [("tick", "test.Tick"), ("wait", "test.Wait")],
            K.CONNECT: ("tick.outputs:tick", "wait.inputs:execIn"),
        },
    )
    control.evaluate_sync(graph)
    control.edit(
        graph, {K.CREATE_NODES: ("step", "test.Step"), K.CONNECT: ("wait.outputs:finished", "step.inputs:execIn")}
    )
    assert nodes[1].db.asleep
    control.evaluate_sync(graph)
    assert graph.nodes["step"].computes == 0
    control.evaluate_sync(graph)
    assert graph.nodes["step"].computes == 1


def test_a_node_that_is_made_again_under_the_same_name_is_a_new_one(control):
    graph, nodes, _, _ = control.edit(ACTION, {K.CREATE_NODES: [("n", "test.Count")]})
    control.edit(graph, {K.DELETE_NODES: "n", K.CREATE_NODES: [("n", "test.Step")]})
    assert graph.nodes["n"] is not nodes[0]
    assert graph.nodes["n"].type.id == "test.Step"


def test_variables_that_stay_keep_their_values(control):
    graph, *_ = control.edit(ACTION, {K.CREATE_VARIABLES: [("v", "double", 1.0)]})
    control.variable("v", graph).set(5.0)
    control.create_variable(graph, "w", "int", 2)
    assert dict(graph.variables) == {"v": 5.0, "w": 2}
    graph.reset()
    assert dict(graph.variables) == {"v": 1.0, "w": 2}


def test_a_lazy_graph_computes_only_what_an_edit_concerns(control, journal):
    graph, *_ = control.edit(
        {"graph_path": "/L", "evaluator_name": "dirty_push"},
        {
            K.CREATE_NODES: [("c", "test.Constant"), *((name, "test.Inc") for name in ("a", "b", "x", "y"))],
            K.CONNECT: [("c.inputs:value", "a.inputs:a"), ("a.outputs:y", "b.inputs:a"), ("x.outputs:y", "y.inputs:a")],
        },
    )
    control.evaluate_sync(graph)
    journal.clear()
    control.edit(graph, {K.CONNECT: ("a.outputs:y", "x.inputs:a")})
    control.evaluate_sync(graph)
    assert journal.take() == ["x", "y"]
    control.evaluate_sync(graph)
    assert journal.take() == []
    control.edit(graph, {K.SET_VALUES: ("c.inputs:value", 5.0)})
    control.evaluate_sync(graph)
    assert sorted(journal.take()) == ["a", "b", "x", "y"]
    assert control.get("/L/y.outputs:y") == 8.0


def test_an_edit_from_inside_a_compute_counts_when_the_evaluation_has_ended(control, scripted, journal):
    graph, *_ = control.edit(
        ACTION,
        {
            K.CREATE_NODES: [("tick", "test.Tick"), ("script", "test.Script"), ("old", "test.Step")],
            K.CONNECT: [("tick.outputs:tick", "script.inputs:execIn"), ("script.outputs:execOut", "old.inputs:execIn")],
        },
    )
    seen = {}

    def action(db):
        commands = {K.CREATE_NODES: ("new", "test.Step"), K.CONNECT: ("script.outputs:execOut", "new.inputs:execIn")}
        seen["graph"], seen["nodes"], _, _ = control.edit(graph, commands)
        # A second edit builds on the first, which has not taken effect yet.
        control.edit(graph, {K.DELETE_NODES: "old"})
        control.edit(graph, {K.CREATE_NODES: ("inc", "test.Inc"), K.SET_VALUES: ("inc.inputs:a", 1.0)})
        seen["during"] = list(graph.nodes)

    scripted["action"] = action
    control.evaluate_sync(graph)
    assert journal.take() == ["tick", "old"]
    assert seen["during"] == ["tick", "script", "old"]
    assert list(graph.nodes) == ["tick", "script", "new", "inc"]
    assert graph.nodes["new"] is seen["nodes"][0]
    assert graph.nodes["inc"].get("a") == 1.0
    control.evaluate_sync(graph)
    assert journal.take() == ["tick", "new"]


def test_a_wrong_edit_from_inside_a_compute_raises_there(control, scripted):
    graph, *_ = control.edit(
        ACTION,
        {
            K.CREATE_NODES: [("tick", "test.Tick"), ("script", "test.Script")],
            K.CONNECT: ("tick.outputs:tick", "script.inputs:execIn"),
        },
    )
    caught = []

    def action(db):
        try:
            control.edit(graph, {K.CREATE_NODES: ("x", "test.Nope")})
        except OmniGraphError as error:
            caught.append(error)

    scripted["action"] = action
    control.evaluate_sync(graph)
    assert len(caught) == 1
    assert list(graph.nodes) == ["tick", "script"]


def test_values_set_from_inside_a_compute_count_at_once_and_survive_an_edit(control, scripted):
    graph, *_ = control.edit(
        ACTION,
        {
            K.CREATE_NODES: [("tick", "test.Tick"), ("script", "test.Script"), ("record", "test.Record")],
            K.CONNECT: [
                ("tick.outputs:tick", "script.inputs:execIn"),
                ("script.outputs:execOut", "record.inputs:execIn"),
            ],
        },
    )

    def action(db):
        control.set("/World/G/record.inputs:value", 1.0)
        control.edit(graph, {K.CREATE_NODES: ("more", "test.Step")})
        control.set("/World/G/record.inputs:value", 2.0)

    scripted["action"] = action
    control.evaluate_sync(graph)
    control.evaluate_sync(graph)
    assert graph.nodes["record"].db.memory == [2.0, 2.0]
    assert "more" in graph.nodes


def test_a_node_may_evaluate_another_graph_but_not_its_own(control, scripted):
    other, *_ = control.edit({"graph_path": "/B", "pipeline_stage": "on_demand"}, {K.CREATE_NODES: ("i", "test.Inc")})
    graph, *_ = control.edit(
        ACTION,
        {
            K.CREATE_NODES: [("tick", "test.Tick"), ("script", "test.Script")],
            K.CONNECT: ("tick.outputs:tick", "script.inputs:execIn"),
        },
    )
    scripted["action"] = lambda db: other.evaluate(db.context)
    control.evaluate_sync(graph)
    assert other.nodes["i"].computes == 1
    scripted["action"] = lambda db: graph.evaluate(db.context)
    with pytest.raises(ComputeError, match="is being evaluated already; a node cannot evaluate its own graph"):
        control.evaluate_sync(graph)


def test_observers_see_new_nodes_too(control):
    graph, *_ = control.edit("/P", {K.CREATE_NODES: ("a", "test.Inc")})
    seen = watch(graph)
    control.edit(graph, {K.CREATE_NODES: ("b", "test.Inc")})
    control.evaluate_sync(graph)
    assert seen == ["a", "b"]
