"""Where graphs, what is inside of them, and prims may be: one thing at one path."""

import pytest

from graph import Controller, OmniGraphError
from graph.isaac.og import Variable
from graph.sim import App

K = Controller.Keys


def with_a_compound(control):
    return control.edit("/World/G", {K.CREATE_NODES: [("twice", {K.CREATE_NODES: [("one", "test.Inc")]})]})[0]


def test_the_inside_of_a_compound_is_edited_by_its_path(control):
    graph = with_a_compound(control)

    found, nodes, _, names = control.edit(
        "/World/G/twice/Subgraph",
        {
            K.CREATE_NODES: [("two", "test.Inc")],
            K.CONNECT: [("one.outputs:y", "two.inputs:a")],
            K.PROMOTE_ATTRIBUTES: [("one.inputs:a", "number"), ("two.outputs:y", "result")],
        },
    )

    assert found is graph
    assert list(control.graphs.graphs) == ["/World/G"]
    assert [node.path for node in nodes] == ["/World/G/twice/Subgraph/two"]
    assert names == {"two": nodes[0]}
    control.set("/World/G/twice.inputs:number", 5.0)
    control.evaluate_sync(graph)
    assert control.get("/World/G/twice.outputs:result") == 7.0, "5, twice one more"
    with pytest.raises(OmniGraphError, match='node "twice/Subgraph/two" already exists'):
        control.edit(graph, {K.CREATE_NODES: [("twice/Subgraph/two", "test.Inc")]})


def test_no_graph_comes_to_be_where_a_compound_is(control):
    with_a_compound(control)
    with pytest.raises(OmniGraphError, match="there is a compound at /World/G/twice; edit /World/G/twice/Subgraph"):
        control.edit("/World/G/twice")
    with pytest.raises(OmniGraphError, match="is the inside of a compound; give its path instead of a dict"):
        control.edit({"graph_path": "/World/G/twice/Subgraph", "evaluator_name": "push"})
    assert list(control.graphs.graphs) == ["/World/G"]


def test_a_prim_and_a_graph_cannot_share_a_path():
    with App() as app:
        Controller.edit("/World/G", {K.CREATE_NODES: ("a", "omni.graph.nodes.ConstantDouble")})
        for path in ("/World/G", "/World/G/a"):
            with pytest.raises(OmniGraphError, match=f"there is a graph or a node at {path}; give the prim another"):
                Controller.edit("/World/G", {K.CREATE_PRIMS: (path, "Cube")})
            assert not app.stage.GetPrimAtPath(path)
        with pytest.raises(OmniGraphError, match="there is a graph or a node at /World/H"):
            Controller.edit("/World/H", {K.CREATE_PRIMS: ("/World/H", "Cube")})
        Controller.edit("/World/G", {K.CREATE_PRIMS: [("/World/Box", "Cube"), ("/World/Place", "Xform")]})
        with pytest.raises(OmniGraphError, match="/World/Box is a Cube on the stage; give the graph another path"):
            Controller.edit("/World/Box")
        assert Controller.edit("/World/Place")[0].path == "/World/Place"


def test_prims_that_the_world_sees_do_not_come_while_it_plays():
    with App() as app:
        graph = Controller.edit("/World/G")[0]
        app.play()
        app.update()
        with pytest.raises(OmniGraphError, match=r"prim /World/Box \(Cube\) cannot come while the world plays; stop"):
            Controller.edit(graph, {K.CREATE_PRIMS: [("/World/Place", "Xform"), ("/World/Box", "Cube")]})
        assert not app.stage.GetPrimAtPath("/World/Place"), "all or nothing"
        Controller.edit(graph, {K.CREATE_PRIMS: ("/World/Place", "Xform")})
        app.update()
        with app.edit(when_playing="recompile"):
            Controller.edit(graph, {K.CREATE_PRIMS: ("/World/Box", "Cube")})
        app.update()
        assert app.stage.GetPrimAtPath("/World/Box")


def test_prims_are_not_exposed_as_bundles():
    with App():
        for kind in ("AS_ATTRIBUTES", "AS_BUNDLE", "AS_WRITABLE"):
            exposed = (getattr(Controller.PrimExposureType, kind), "/World/Box", "box")
            with pytest.raises(OmniGraphError, match="bundles of prims are not modelled here; use ReadPrimAttribute"):
                Controller.edit("/World/G", {K.CREATE_PRIMS: ("/World/Box", "Cube"), K.EXPOSE_PRIMS: exposed})


def test_a_graph_lists_its_variables(control):
    graph = control.edit("/G", {K.CREATE_VARIABLES: [("speed", "double", 2.5), ("name", "token")]})[0]
    assert [(one.get_name(), one.get_type_name(), one.get()) for one in graph.get_variables()] == [
        ("speed", "double", 2.5),
        ("name", "token", ""),
    ]
    assert isinstance(graph.find_variable("speed"), Variable)
    assert graph.find_variable("sped") is None
