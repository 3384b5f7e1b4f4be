"""One call that makes or changes a graph: argument forms, return values, all or nothing."""

import pytest

from graph import Controller, OmniGraphError, OmniGraphValueError, UserError
from graph.isaac.og import Compound, TypedValue
from graph.node.declaration import Attribute
from graph.node.decorator import declare
from nodes.catalog import renames
from tests.support.costs import within

K = Controller.Keys
ACTION = {"graph_path": "/World/G", "evaluator_name": "execution"}


def made(control, commands=None, spec=ACTION):
    return control.edit(spec, commands or {})


def test_an_edit_returns_graph_nodes_prims_and_names(control):
    graph, nodes, prims, names = made(control, {K.CREATE_NODES: [("tick", "test.Tick"), ("step", "test.Step")]})
    assert graph.path == "/World/G"
    assert graph.evaluator == "execution"
    assert [node.path for node in nodes] == ["/World/G/tick", "/World/G/step"]
    assert prims == []
    assert names == {"tick": nodes[0], "step": nodes[1]}


def test_a_path_makes_a_push_graph_and_later_edits_that_one(control):
    graph = control.edit("/World/G")[0]
    assert (graph.evaluator, graph.pipeline_stage) == ("push", "simulation")
    again = control.edit("/World/G", {K.CREATE_NODES: ("a", "test.Inc")})[0]
    assert again is graph
    assert control.edit(graph, {K.CREATE_NODES: ("b", "test.Inc")})[0] is graph
    assert list(graph.nodes) == ["a", "b"]


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"evaluator_name": "dirty_push"}, ("dirty_push", "simulation", "automatic")),
        ({"pipeline_stage": "pipelineStageOnDemand"}, ("push", "on_demand", "automatic")),
        (
            {"pipeline_stage": Controller.GraphPipelineStage.GRAPH_PIPELINE_STAGE_POSTRENDER},
            ("push", "post_render", "automatic"),
        ),
        ({"evaluation_mode": "Standalone", "fc_backing_type": 1}, ("push", "simulation", "standalone")),
    ],
)
def test_a_dict_says_how_the_graph_is_evaluated(control, settings, expected):
    graph = control.edit({"graph_path": "/G", **settings})[0]
    assert (graph.evaluator, graph.pipeline_stage, graph.spec.evaluation_mode) == expected


def test_the_order_of_the_keys_means_nothing(control):
    graph, *_ = made(
        control,
        {
            K.SET_VALUES: [("a.inputs:value", 2.0)],
            K.CONNECT: [("a.inputs:value", "inc.inputs:a"), ("tick.outputs:tick", "record.inputs:execIn")],
            K.CREATE_NODES: [
                ("a", "test.Constant"),
                ("inc", "test.Inc"),
                ("tick", "test.Tick"),
                ("record", "test.Record"),
            ],
        },
    )
    control.connect("/World/G/inc.outputs:y", "/World/G/record.inputs:value")
    control.evaluate_sync(graph)
    assert graph.nodes["record"].db.memory == [3.0]


class Path:
    """Stands for an Sdf.Path: its text is the path."""

    def __init__(self, text):
        self.text = text

    def __str__(self):
        return self.text


@pytest.mark.parametrize("form", ["short", "absolute", "pair", "names", "attribute", "path"])
def test_an_attribute_may_be_named_in_many_ways(control, form):
    graph, nodes, _, _ = made(control, {K.CREATE_NODES: [("a", "test.Constant"), ("b", "test.Inc")]})
    source, target = {
        "short": ("a.inputs:value", "b.inputs:a"),
        "absolute": ("/World/G/a.inputs:value", "/World/G/b.inputs:a"),
        "pair": (("inputs:value", nodes[0]), ("inputs:a", "b")),
        "names": (("inputs:value", "a"), ("inputs:a", "b")),
        "attribute": (nodes[0].get_attribute("inputs:value"), nodes[1].get_attribute("a")),
        "path": (Path("/World/G/a.inputs:value"), Path("/World/G/b.inputs:a")),
    }[form]
    control.edit(graph, {K.CONNECT: (source, target), K.SET_VALUES: (source, 5.0)})
    assert nodes[1].get("a") == 5.0
    control.edit(graph, {K.DISCONNECT: (source, target)})
    assert nodes[1].get("a") == 0.0
    assert not nodes[1].connected("a")


def test_connecting_what_is_connected_changes_nothing(control):
    graph, *_ = made(control, {K.CREATE_NODES: [("a", "test.Constant"), ("b", "test.Inc")]})
    for _ in range(2):
        control.edit(graph, {K.CONNECT: [("a.inputs:value", "b.inputs:a"), ("a.value", "b.a")]})
    assert len(graph.spec.connections) == 1


def test_everything_wrong_with_an_edit_is_reported_at_once(control):
    edit = {
        K.CREATE_NODES: [("sum", "test.Sum"), ("bad", "test.Smu"), ("inc", "test.Inc")],
        K.SET_VALUES: [("inc.inputs:x", 1), ("bad.inputs:a", 1)],
        K.CONNECT: [("gone.outputs:x", "sum.inputs:a"), ("sum.outputs:y", "sum.inputs:b")],
    }
    with pytest.raises(OmniGraphError) as caught:
        control.edit("/World/G", edit)
    assert sorted(str(one).split(": ")[0] for one in caught.value.problems) == [
        "/World/G CONNECT[0]",
        "/World/G CONNECT[1]",
        "/World/G CREATE_NODES[1]",
        "/World/G SET_VALUES[0]",
    ]


def test_values_may_carry_their_type(control):
    _, nodes, _, _ = made(
        control,
        {
            K.CREATE_NODES: [("one", "test.Sum"), ("two", "test.Sum"), ("three", "test.Sum")],
            K.SET_VALUES: [
                ("one.inputs:a", TypedValue(1, "uint64")),
                ("two.inputs:a", {"type": "float", "value": 1}),
                ("three.inputs:a", 1, "half"),
            ],
        },
    )
    assert [node.get_attribute("inputs:a").get_type_name() for node in nodes] == ["uint64", "float", "half"]
    assert nodes[0].get("a") == 1


def test_open_inputs_may_wait_for_a_later_edit_and_say_so_when_computed(control):
    graph, nodes, _, _ = control.edit("/World/G", {K.CREATE_NODES: ("sum", "test.Sum")})
    with pytest.raises(Exception, match=r"/World/G/sum .Sum. failed in update 0: input b is not set"):
        control.evaluate_sync(graph)
    control.edit(graph, {K.SET_VALUES: [("sum.inputs:a", 1), ("sum.inputs:b", 2)]})
    control.evaluate_sync(graph)
    assert nodes[0].get("sum") == 3


def test_variables_and_attributes_are_made(control):
    graph, nodes, _, _ = made(
        control,
        {
            K.CREATE_VARIABLES: [("speed", "double", 2.5), ("name", "token")],
            K.CREATE_NODES: ("step", "test.Step"),
            K.CREATE_ATTRIBUTES: [("step.inputs:gain", "double"), ("step.outputs:done", "bool")],
            K.SET_VALUES: ("step.inputs:gain", 3),
        },
    )
    assert dict(graph.variables) == {"speed": 2.5, "name": ""}
    speed = control.variable("speed", graph)
    speed.set(4)
    assert control.get(speed) == 4.0
    assert nodes[0].get("inputs:gain") == 3.0
    assert nodes[0].get_attribute("outputs:done").get_type_name() == "bool"
    assert control.create_attribute(nodes[0], "extra", "int[]").get().tolist() == []


def test_deleting_a_node_takes_its_connections_along(control):
    graph, *_ = made(
        control,
        {
            K.CREATE_NODES: [("a", "test.Constant"), ("b", "test.Inc"), ("c", "test.Inc")],
            K.CONNECT: [("a.inputs:value", "b.inputs:a"), ("b.outputs:y", "c.inputs:a")],
        },
    )
    control.edit(graph, {K.DELETE_NODES: "b"})
    assert list(graph.nodes) == ["a", "c"]
    assert graph.spec.connections == ()
    assert control.delete_node("/World/G/nobody", ignore_if_missing=True) is False
    assert control.delete_node("/World/G/c")
    assert list(graph.nodes) == ["a"]


def test_a_compound_is_flattened_and_its_ports_stand_for_what_is_inside(control):
    inner = {
        K.CREATE_NODES: [("one", "test.Inc"), ("two", "test.Inc")],
        K.CONNECT: ("one.outputs:y", "two.inputs:a"),
        K.PROMOTE_ATTRIBUTES: [("one.inputs:a", "inputs:number"), ("two.outputs:y", "result")],
    }
    graph, nodes, _, names = control.edit(
        "/World/G",
        {
            K.CREATE_NODES: [("twice", inner), ("c", "test.Constant"), ("last", "test.Inc")],
            K.CONNECT: [("c.inputs:value", "twice.inputs:number"), ("twice.outputs:result", "last.inputs:a")],
            K.SET_VALUES: ("c.inputs:value", 10.0),
        },
    )
    assert isinstance(names["twice"], Compound)
    assert [node.path for node in nodes] == [
        "/World/G/twice",
        "/World/G/twice/Subgraph/one",
        "/World/G/twice/Subgraph/two",
        "/World/G/c",
        "/World/G/last",
    ]
    control.evaluate_sync(graph)
    assert control.get("/World/G/last.outputs:y") == 13.0
    assert control.get("/World/G/twice.outputs:result") == 12.0
    control.edit(graph, {K.DISCONNECT: ("c.inputs:value", "twice.inputs:number")})
    control.edit(graph, {K.SET_VALUES: ("twice.inputs:number", 1.0)})
    control.evaluate_sync(graph)
    assert control.get("/World/G/last.outputs:y") == 4.0
    control.edit(graph, {K.DELETE_NODES: ["twice"]})
    assert list(graph.nodes) == ["c", "last"]


def test_compounds_nest(control):
    deep = {K.CREATE_NODES: ("inc", "test.Inc"), K.PROMOTE_ATTRIBUTES: [("inc.inputs:a", "a"), ("inc.outputs:y", "y")]}
    outer = {K.CREATE_NODES: ("deep", deep), K.PROMOTE_ATTRIBUTES: [("deep.inputs:a", "a"), ("deep.outputs:y", "y")]}
    control.edit("/G", {K.CREATE_NODES: [("outer", outer)], K.SET_VALUES: [("outer.inputs:a", 7.0)]})
    control.evaluate_sync()
    assert control.get(("outputs:y", "/G/outer")) == 8.0


def test_graphs_exchange_data_by_absolute_paths(control):
    control.edit("/A", {K.CREATE_NODES: ("c", "test.Constant"), K.SET_VALUES: ("c.inputs:value", 4.0)})
    control.edit("/B", {K.CREATE_NODES: ("inc", "test.Inc"), K.CONNECT: ("/A/c.inputs:value", "inc.inputs:a")})
    control.evaluate_sync()
    assert control.get("/B/inc.outputs:y") == 5.0
    control.set("/A/c.inputs:value", 5.0)
    control.edit("/A", {K.CREATE_NODES: ("d", "test.Constant")})
    control.evaluate_sync()
    assert control.get("/B/inc.outputs:y") == 6.0
    control.edit("/A", {K.DELETE_NODES: "c"})
    assert not control.node("/B/inc").connected("a")


MISTAKES = [
    ({K.CREATE_NODES: ("a", "test.Stepp")}, r'node "a": no node type "test.Stepp"; did you mean "test.Step"\?'),
    ({K.CREATE_NODES: ("tick", "test.Tick")}, r'node "tick" already exists in graph /World/G; choose another name'),
    ({K.CREATE_NODES: ("/Other/a", "test.Tick")}, "node /Other/a does not lie below the graph /World/G"),
    ({K.CONNECT: ("tick.outputs:tik", "step.inputs:execIn")}, r'\(Tick\) has no output "tik"; did you mean "tick"\?'),
    ({K.CONNECT: ("tack.outputs:tick", "step.inputs:execIn")}, r'"tack" is not a legal node; .* did you mean "tick"\?'),
    ({K.CONNECT: ("tick.outputs:tick", "inc.inputs:a")}, r"tick.outputs:tick \(execution\) cannot feed inc.inputs:a"),
    ({K.CONNECT: ("tick", "inc.inputs:a")}, "'tick' is not a legal attribute; write node.inputs:name or a path"),
    ({K.DISCONNECT: ("tick.outputs:tick", "step.inputs:execIn")}, "step.inputs:execIn are not connected"),
    ({K.DELETE_NODES: "nobody"}, '"nobody" is not a legal node'),
    ({K.SET_VALUES: ("inc.inputs:b", 1.0)}, r'node "inc" \(Inc\) has no input "b"'),
    ({K.CREATE_VARIABLES: ("v", "doubel")}, r'no attribute type "doubel"; did you mean "double"\?'),
    ({K.CREATE_ATTRIBUTES: ("inc.inputs:a", "double")}, "inc.inputs:a already exists"),
    ({K.CREATE_PRIMS: ("/World/Box", "Cube")}, "prim /World/Box needs a stage; edit the graphs of an App"),
    ({K.PROMOTE_ATTRIBUTES: ("inc.inputs:a", "x")}, "PROMOTE_ATTRIBUTES stands inside the dict of a compound"),
    ({"create_node": []}, r'"create_node" is not a key of an edit; did you mean "create_nodes"\?'),
    ({K.CREATE_NODES: [("only_a_name",)]}, "is not an entry of CREATE_NODES"),
]


@pytest.mark.parametrize(("commands", "message"), MISTAKES, ids=[text[:40] for _, text in MISTAKES])
def test_a_mistake_is_reported_and_nothing_changes(control, commands, message):
    graph, *_ = made(control, {K.CREATE_NODES: [("tick", "test.Tick"), ("step", "test.Step"), ("inc", "test.Inc")]})
    before, nodes = graph.spec, dict(graph.nodes)
    good = {K.CREATE_NODES: [("new", "test.Inc")]}
    combined = {key: [*good.get(key, []), *(v if isinstance(v, list) else [v])] for key, v in commands.items()}
    with pytest.raises(OmniGraphError, match=message) as caught:
        control.edit(graph, {**good, **combined})
    assert isinstance(caught.value, UserError)
    assert graph.spec is before
    assert graph.nodes == nodes


def test_all_mistakes_of_an_edit_are_reported_with_their_places(control):
    with pytest.raises(OmniGraphError) as caught:
        made(
            control,
            {
                K.CREATE_NODES: [("a", "test.Nope"), ("b", "test.Inc")],
                K.CONNECT: [("a.outputs:y", "b.inputs:a"), ("c.outputs:y", "b.inputs:a")],
            },
        )
    lines = str(caught.value).splitlines()
    assert lines[0].startswith('/World/G CREATE_NODES[0]: node "a": no node type "test.Nope"')
    assert lines[1].startswith('/World/G CONNECT[1]: "c" is not a legal node')
    assert len(lines) == 2, "what follows from another mistake is not told"
    assert control.graphs.graphs == {}


def test_wrong_values_are_an_error_of_their_own(control):
    graph, nodes, _, _ = made(control, {K.CREATE_NODES: ("loop", "test.Loop")})
    with pytest.raises(
        OmniGraphValueError, match=r"SET_VALUES\[0\]: .*times: expected a whole number \(int\), got 'x'"
    ):
        control.edit(graph, {K.SET_VALUES: ("loop.inputs:times", "x")})
    with pytest.raises(OmniGraphValueError, match=r"/World/G/loop.inputs:times: expected a whole number"):
        control.set("/World/G/loop.inputs:times", 0.5)
    with pytest.raises(ValueError, match="is an output"):
        control.set(nodes[0].get_attribute("index"), 1)


def test_a_dict_for_a_graph_that_exists_is_a_mistake(control):
    made(control)
    with pytest.raises(OmniGraphError, match="graph /World/G already exists; give its path instead of a dict"):
        made(control)
    with pytest.raises(
        OmniGraphError, match="graph /H: evaluator_name: 'pusch' is not one of execution, push, dirty_push"
    ):
        control.edit({"graph_path": "/H", "evaluator_name": "pusch"})
    with pytest.raises(OmniGraphError, match='"no path" is not a legal graph'):
        control.edit("no path")


def test_a_hundred_thousand_nodes_come_by_one_edit(control):
    count = 100_000
    with within(10):
        graph, nodes, _, _ = control.edit(
            "/World/Big",
            {
                K.CREATE_NODES: [(f"n{i}", "test.Inc") for i in range(count)],
                K.CONNECT: [(f"n{i}.outputs:y", f"n{i + 1}.inputs:a") for i in range(count - 1)],
            },
        )
    control.evaluate_sync(graph)
    assert nodes[-1].get("y") == count


def test_attributes_of_older_releases_are_renamed_or_left_out_with_one_warning_each(control, monkeypatch):
    monkeypatch.setitem(renames.RENAMED, "test.Inc", {"inputs:old": "inputs:a", "inputs:gone": ""})
    told = []
    control.graphs.context.warn = lambda *warning: told.append(warning)

    graph, (_, inc), _, _ = control.edit(
        "/World/G",
        {
            K.CREATE_NODES: [("source", "test.Inc"), ("inc", "test.Inc")],
            K.SET_VALUES: [("inc.inputs:gone", True), ("source.inputs:old", 4)],
            K.CONNECT: [("source.outputs:y", "inc.inputs:old")],
        },
    )

    assert [(code, where) for code, where, _ in told] == [
        ("attribute-renamed", "/World/G/inc"),
        ("attribute-removed", "/World/G/inc"),
        ("attribute-renamed", "/World/G/source"),
    ]
    control.evaluate_sync(graph)
    assert control.get(inc.get_attribute("outputs:y")) == 6


def test_zero_and_one_are_false_and_true_where_an_attribute_is_a_bool(control, library):
    declare("test.Flag", "", inputs={"on": Attribute("bool", "")}, registry=library)

    _, (node,), _, _ = made(control, {K.CREATE_NODES: ("flag", "test.Flag"), K.SET_VALUES: ("flag.inputs:on", 1)})

    assert control.get(node.get_attribute("inputs:on")) is True
    with pytest.raises(OmniGraphValueError, match="on: expected true or false, got 2"):
        control.edit("/World/G", {K.SET_VALUES: ("flag.inputs:on", 2)})
