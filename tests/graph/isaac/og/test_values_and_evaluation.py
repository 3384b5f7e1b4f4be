"""Looking up, reading, writing and evaluating."""

import asyncio

import pytest

from graph import Controller, OmniGraphError
from graph.isaac.og import get_graph_by_path, get_node_by_path, get_registered_nodes

K = Controller.Keys


@pytest.fixture
def control(control):
    control.edit("/World/G", {K.CREATE_NODES: [("c", "test.Constant"), ("inc", "test.Inc")]})
    control.connect("/World/G/c.inputs:value", "/World/G/inc.inputs:a")
    return control


def test_nodes_attributes_and_graphs_are_found_by_all_their_names(control):
    graph = control.graph("/World/G")
    inc = control.node("/World/G/inc")
    assert control.node("inc", graph) is control.node(("inc", "/World/G")) is control.node(inc) is inc
    attribute = control.attribute("/World/G/inc.inputs:a")
    assert attribute == control.attribute("inputs:a", inc) == control.attribute(("inputs:a", "/World/G/inc"))
    assert attribute == control.attribute("a", "inc", graph) == inc.get_attribute("a")
    assert (attribute.get_name(), attribute.get_path(), attribute.get_type_name(), attribute.get_port_type()) == (
        "inputs:a",
        "/World/G/inc.inputs:a",
        "double",
        "inputs",
    )
    assert attribute.get_node() is inc
    assert attribute.is_connected()
    assert [one.get_name() for one in inc.get_attributes()] == ["inputs:a", "outputs:y"]
    assert inc.get_attribute_exists("outputs:y")
    assert not inc.get_attribute_exists("z")
    assert (inc.get_prim_path(), inc.get_type_name(), inc.get_graph()) == ("/World/G/inc", "test.Inc", graph)
    assert graph.get_nodes() == [control.node("/World/G/c"), inc]
    assert graph.get_node("/World/G/inc") is inc
    assert (graph.get_path_to_graph(), graph.get_evaluator_name(), graph.get_pipeline_stage()) == (
        "/World/G",
        "push",
        "simulation",
    )


@pytest.mark.parametrize(
    ("look_up", "message"),
    [
        (lambda c: c.graph("/World/H"), 'there is no graph "/World/H"; did you mean "/World/G"?'),
        (lambda c: c.node("/World/G/ink"), 'is not a legal node; .* did you mean "/World/G/inc"'),
        (lambda c: c.node("inc"), "is not a legal node; no node has that path; write its path, or name the graph"),
        (lambda c: c.attribute("/World/G/inc.inputs:b"), '"inputs:b" is not a legal attribute: .* has no attribute'),
        (lambda c: c.variable("v", "/World/G"), 'graph /World/G has no variable "v"'),
        (lambda c: c.get(), "name an attribute"),
        (lambda c: c.prim("/World"), "there is no prim /World; there is no stage"),
        (lambda c: c.evaluate_sync("/World/H"), "there is no graph"),
        (lambda c: c.delete_graph("/World/H"), "there is no graph"),
    ],
)
def test_what_is_not_there_is_reported(control, look_up, message):
    with pytest.raises(OmniGraphError, match=message.replace("?", r"\?")):
        look_up(control)


def test_values_are_set_for_now_and_for_every_start(control):
    graph = control.graph("/World/G")
    control.set("/World/G/c.inputs:value", 3)
    control.evaluate_sync()
    assert control.get("/World/G/inc.outputs:y") == 4.0
    Controller(control.attribute("/World/G/c.inputs:value"), graphs=control.graphs).set(7)
    assert Controller(control.attribute("/World/G/c.inputs:value"), graphs=control.graphs).get() == 7.0
    graph.reset()
    control.edit(graph, {K.CREATE_NODES: ("other", "test.Inc")})
    control.evaluate_sync(graph)
    assert control.get("/World/G/inc.outputs:y") == 8.0
    with pytest.raises(OmniGraphError, match="inputs:a is connected; set its source"):
        control.set("/World/G/inc.inputs:a", 1.0)


def test_an_open_attribute_takes_the_type_of_what_it_is_set_to(control):
    control.create_node("/World/G/sum", "test.Sum")
    control.set(("inputs:a", "/World/G/sum"), [1, 2, 3])
    assert control.attribute("/World/G/sum.inputs:a").get_type_name() == "int[3]"


def test_everything_means_the_graphs_of_the_simulation_stage(control):
    for stage in ("on_demand", "pre_render", "post_render"):
        control.edit({"graph_path": f"/World/{stage}", "pipeline_stage": stage}, {K.CREATE_NODES: ("inc", "test.Inc")})
    control.evaluate_sync()
    assert [control.node(f"/World/{one}/inc").computes for one in ("G", "on_demand", "pre_render", "post_render")] == [
        1,
        0,
        0,
        0,
    ]
    control.evaluate_sync(["/World/G", "/World/on_demand"])
    assert [control.node(f"/World/{one}/inc").computes for one in ("G", "on_demand")] == [2, 1]
    for stage in ("pre_render", "post_render"):
        with pytest.raises(OmniGraphError, match=f"graph /World/{stage} is of the {stage} stage; the renderer"):
            control.evaluate_sync(f"/World/{stage}")
    control.graph("/World/pre_render").change_pipeline_stage("simulation")
    control.evaluate_sync()
    assert control.node("/World/pre_render/inc").computes == 1
    with pytest.raises(ValueError, match='"render" is not a pipeline stage'):
        control.graph("/World/G").change_pipeline_stage("render")


def test_evaluate_can_be_awaited(control):
    asyncio.run(control.evaluate("/World/G"))
    assert control.node("/World/G/inc").get_compute_count() == 1


def test_without_a_world_each_evaluation_is_an_update_of_its_own(control):
    control.evaluate_sync()
    control.evaluate_sync()
    assert control.graphs.context.update == 1
    assert float(control.graphs.context.exact_time) == pytest.approx(2 / 60)


def test_a_requested_compute_is_done_once_in_the_next_evaluation(control):
    graph, nodes, _, _ = control.edit(
        {"graph_path": "/A", "evaluator_name": "execution"}, {K.CREATE_NODES: [("step", "test.Step")]}
    )
    nodes[0].request_compute()
    nodes[0].request_compute()
    control.evaluate_sync(graph)
    control.evaluate_sync(graph)
    assert nodes[0].computes == 1


def test_the_class_itself_works_on_the_graphs_of_the_process():
    graph = Controller.edit("/Process", {K.CREATE_NODES: [("c", "omni.graph.nodes.ConstantInt")]})[0]
    try:
        Controller.set(("inputs:value", "/Process/c"), 5)
        assert Controller.get("/Process/c.inputs:value") == 5
        assert get_graph_by_path("/Process") is graph
        assert get_graph_by_path("/Nowhere", None) is None
        assert get_node_by_path("/Process/c") is graph.nodes["c"]
        assert "omni.graph.action.Branch" in get_registered_nodes()
        old = Controller.create_node("/Process/time", "omni.isaac.core_nodes.IsaacReadSimulationTime")
        assert old.type.id == "isaacsim.core.nodes.IsaacReadSimulationTime"
    finally:
        Controller.delete_graph("/Process")
    assert get_graph_by_path("/Process", None) is None


def test_a_graph_of_another_set_is_not_edited(control, library):
    with pytest.raises(OmniGraphError, match="is not among these graphs"):
        Controller(registry=library).edit(control.graph("/World/G"), {})
