"""One graph on many prims: values, memory and variables of its own for each, and the token that means the prim."""

from dataclasses import replace

import pytest

from graph import Controller, UserError, compile_graphs
from graph.evaluate.instances import with_target

NODES = {
    "tick": "test.Tick",
    "count": "test.Count",
    "record": ("test.Record", {}),
    "word": ("test.Word", {"value": "_OMNI_GRAPH_TARGET/arm"}),
}
LINKS = ["tick.tick -> count.execIn"]


@pytest.fixture
def robots(make_spec, library):
    """Compiles the graph with instances on the given prims."""

    def make(instances, mode="automatic", **more):
        spec = make_spec(NODES, LINKS, variables={"speed": ("double", 1.0)}, **more)
        return compile_graphs([replace(spec, instances=instances, evaluation_mode=mode)], library)[0]

    return make


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("_OMNI_GRAPH_TARGET", "/W/R"),
        ("_OMNI_GRAPH_TARGET/arm", "/W/R/arm"),
        ("/World/G/_OMNI_GRAPH_TARGET/arm", "/W/R/arm"),
        (["_OMNI_GRAPH_TARGET", "/Else"], ["/W/R", "/Else"]),
        ({"type": "token", "value": "_OMNI_GRAPH_TARGET"}, {"type": "token", "value": "/W/R"}),
        ("MY_OMNI_GRAPH_TARGET", "MY_OMNI_GRAPH_TARGET"),
        (5, 5),
    ],
)
def test_the_token_means_the_prim(value, expected):
    assert with_target(value, "/W/R") == expected


def test_the_graph_runs_once_for_each_prim(robots, playing):
    graph = robots({"/W/R1": {}, "/W/R2": {"speed": 2.5}})
    for _ in range(3):
        graph.evaluate(playing)
    one, two = graph.instance("/W/R1"), graph.instance("/W/R2")
    assert [each.nodes["count"].get("state:count") for each in (one, two)] == [3, 3]
    assert [each.nodes["word"].get("value") for each in (one, two)] == ["/W/R1/arm", "/W/R2/arm"]
    assert [each.variables["speed"] for each in (one, two)] == [1.0, 2.5]
    assert graph.nodes["count"].computes == 6, "of the graph as a whole"
    assert graph.nodes["count"].fired == {"execOut": 6}
    two.variables["speed"] = 4.0
    assert one.variables["speed"] == 1.0
    graph.reset()
    assert [each.nodes["count"].get("state:count") for each in (one, two)] == [0, 0]
    assert two.variables["speed"] == 2.5


def test_a_graph_that_no_prim_has_is_its_own_target(robots, playing):
    graph = robots({})
    graph.evaluate(playing)
    assert graph.nodes["word"].get("value") == "/World/G/arm"
    assert graph.nodes["count"].computes == 1


@pytest.mark.parametrize(
    ("mode", "instances", "computes"),
    [
        ("automatic", {}, 1),
        ("automatic", {"/A": {}, "/B": {}}, 2),
        ("standalone", {"/A": {}, "/B": {}}, 1),
        ("instanced", {"/A": {}}, 1),
        ("instanced", {}, 0),
    ],
)
def test_the_evaluation_mode_says_whether_prims_count(robots, playing, mode, instances, computes):
    graph = robots(instances, mode)
    graph.evaluate(playing)
    assert graph.nodes["count"].computes == computes


def test_values_set_on_the_graph_reach_every_instance(robots):
    graph = robots({"/A": {}, "/B": {}})
    graph.nodes["word"].set("value", "_OMNI_GRAPH_TARGET/leg")
    assert [graph.instance(prim).nodes["word"].get("value") for prim in ("/A", "/B")] == ["/A/leg", "/B/leg"]
    with pytest.raises(KeyError, match="has no instance on /C"):
        graph.instance("/C")


def test_what_instances_cannot_have_is_reported(robots, library, make_spec):
    with pytest.raises(UserError, match='has no variable "sped", which /A sets; did you mean "speed"'):
        robots({"/A": {"sped": 1.0}})
    with pytest.raises(UserError, match="speed"):
        robots({"/A": {"speed": "fast"}})
    source = make_spec({"c": "test.Constant"}, path="/World/H")
    reader = make_spec({"inc": "test.Inc"}, ["/World/H/c.value -> inc.a"])
    with pytest.raises(UserError, match="is instanced on prims and exchanges data with /World/H"):
        compile_graphs([source, replace(reader, instances={"/A": {}})], library)


def test_an_edit_reaches_the_instances_and_keeps_their_memory(robots, library, playing):
    graph = robots({"/A": {}, "/B": {}})
    control = Controller(registry=library)
    control.graphs.graphs[graph.path] = graph
    graph.evaluate(playing)
    graph.instance("/A").nodes["count"].db.state.count = 10
    control.edit(graph, {control.Keys.CONNECT: ("count.outputs:execOut", "record.inputs:execIn")})
    graph.evaluate(playing)
    assert graph.instance("/A").nodes["count"].get("state:count") == 11
    assert graph.nodes["record"].computes == 2


def test_a_variable_of_an_instance_is_its_own(robots, library, playing):
    graph = robots({"/A": {"speed": 3.0}, "/B": {}})
    control = Controller(registry=library)
    control.graphs.graphs[graph.path] = graph
    one = control.variable((graph.instance("/A"), "speed"))
    assert (one.get(), control.variable((graph, "speed")).get()) == (3.0, 1.0)
    one.set(4.0)
    assert [graph.instance(prim).variables["speed"] for prim in ("/A", "/B")] == [4.0, 1.0]
