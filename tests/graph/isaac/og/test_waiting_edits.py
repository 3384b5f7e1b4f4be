"""Edits that wait: checked at once, compiled at the next evaluation or read."""

import pytest

from graph import Attribute, Controller, OmniGraphError, OmniGraphValueError, node_type
from graph.editing import graph_set

K = Controller.Keys
SUM = "omni.graph.nodes.Add"


@pytest.fixture
def compiled(monkeypatch):
    """The paths of the graphs that edits compile, in order."""
    paths = []
    original = graph_set.compile_graphs

    def noted(specs, *others):
        paths.extend(spec.path for spec in specs)
        return original(specs, *others)

    monkeypatch.setattr(graph_set, "compile_graphs", noted)
    return paths


@pytest.fixture
def control():
    return Controller(graphs=graph_set.GraphSet())


def chain(control, length, value):
    """1 + value + value ...: a constant and `length` sums, each made, set and connected by an edit of its own."""
    graph, *_ = control.edit("/G", {K.CREATE_NODES: ("n0", "omni.graph.nodes.ConstantDouble")})
    control.edit(graph, {K.SET_VALUES: ("n0.inputs:value", 1.0)})
    for i in range(1, length + 1):
        control.create_node(f"/G/n{i}", SUM)
        control.edit(graph, {K.SET_VALUES: (f"n{i}.inputs:b", value)})
        source = f"/G/n{i - 1}.outputs:sum" if i > 1 else "/G/n0.inputs:value"
        control.connect(source, f"/G/n{i}.inputs:a")
    return graph


@pytest.mark.parametrize("value", [2.0, {"type": "double", "value": 2.0}])
def test_a_graph_is_compiled_once_for_all_edits_before_an_evaluation(control, compiled, value):
    graph = chain(control, 20, value)
    compiled.clear()
    control.evaluate_sync(graph)
    assert compiled == ["/G"]
    assert control.get("/G/n20.outputs:sum") == 1 + 20 * 2
    control.evaluate_sync(graph)
    assert compiled == ["/G"]


def test_a_wrong_edit_is_refused_at_once_and_leaves_those_that_wait(control, compiled):
    graph = chain(control, 3, 2.0)
    control.create_node("/G/text", "omni.graph.nodes.ConstantToken")
    for source, message in [
        ("/G/text.inputs:value", r"n4.inputs:a"),
        ("/G/n4.outputs:sum", "data goes round in a cycle"),
        ("/G/n9.outputs:sum", "not a legal node"),
    ]:
        if graph.members.get("n4") is None:
            control.create_node("/G/n4", SUM)
            control.connect("/G/n3.outputs:sum", "/G/n4.inputs:b")
        with pytest.raises(OmniGraphError, match=message):
            control.connect(source, "/G/n4.inputs:a")
    control.set("/G/n4.inputs:a", 10.0)
    control.evaluate_sync(graph)
    assert control.get("/G/n4.outputs:sum") == 10 + 1 + 3 * 2


def test_reading_what_the_compiler_decides_compiles_the_edits(control, compiled):
    graph = chain(control, 2, 2.0)
    node = graph.members["n2"]
    before = len(compiled)
    assert [one.name for one in node.sources] == ["n1"]
    assert node.connected("inputs:a")
    assert len(compiled) == before + 1
    assert str(node.types["outputs:sum"]) == "double"


def test_a_removed_node_is_gone_at_once_and_its_reader_gets_its_own_value_back(control):
    graph = chain(control, 3, 2.0)
    control.edit(graph, {K.SET_VALUES: ("n3.inputs:b", 5.0)})
    control.evaluate_sync(graph)
    control.delete_node("/G/n3")
    assert "n3" not in graph.members
    with pytest.raises(OmniGraphError, match="not a legal node"):
        control.get("/G/n3.outputs:sum")
    control.delete_node("/G/n1")
    control.edit(graph, {K.SET_VALUES: ("n2.inputs:a", 100.0)})
    control.evaluate_sync(graph)
    assert control.get("/G/n2.outputs:sum") == 102


def test_a_connected_input_is_not_set_while_its_connection_waits(control):
    chain(control, 2, 2.0)
    with pytest.raises(OmniGraphValueError, match="is connected; set its source"):
        control.set("/G/n2.inputs:a", 7.0)


def test_a_graph_is_closed_with_edits_that_wait_and_releases_what_its_nodes_hold(library):
    released = []

    @node_type(
        "test.Keeper",
        outputs={"y": Attribute("double", "a number")},
        release=lambda db: released.append(db.node.name),
        registry=library,
    )
    def keep(db):
        """Holds something."""
        db.outputs.y = 1.0

    control = Controller(registry=library)
    graph, *_ = control.edit("/G", {K.CREATE_NODES: [("one", "test.Keeper"), ("two", "test.Inc")]})
    control.evaluate_sync(graph)
    control.connect("/G/one.outputs:y", "/G/two.inputs:a")
    graph.close()
    assert released == ["one"]


def test_a_stop_of_the_timeline_sees_the_edits_that_wait(control):
    graph = chain(control, 1, 2.0)
    graph.reset()
    assert graph.nodes["n1"].get("inputs:a") == 1.0
