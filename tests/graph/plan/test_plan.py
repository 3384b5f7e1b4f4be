"""Compiling: what names mean, how open types are settled, and every mistake with its place."""

from __future__ import annotations

import pytest

from graph import UserError, compile_graphs
from graph.plan.order import cycles, dependency_order
from tests.support.costs import within


def problems(library, *specs):
    with pytest.raises(UserError) as caught:
        compile_graphs(specs, library)
    return [str(problem) for problem in caught.value.problems]


# -- what the short forms mean ---------------------------------------------------------------------------------------


def test_a_name_without_prefix_is_an_output_on_the_left_and_an_input_on_the_right(build, playing):
    graph = build({"a": ("test.Inc", {"a": 1}), "b": "test.Inc"}, ["a.y -> b.a"], "push")
    graph.evaluate(playing)
    assert graph.node("b").get("y") == 3.0


def test_a_constant_feeds_from_its_input_without_computing(build):
    graph = build({"c": ("test.Constant", {"value": 7}), "b": "test.Inc"}, ["c.value -> b.a"])
    assert graph.node("b").get("a") == 7.0


def test_any_input_may_pass_its_value_on(build, playing):
    graph = build(
        {"c": ("test.Constant", {"value": 7}), "b": "test.Inc", "d": "test.Inc", "e": "test.Inc"},
        ["d.a -> e.a", "b.inputs:a -> d.a", "c.value -> b.a"],
    )
    assert [graph.node(name).get("a") for name in "bde"] == [7.0, 7.0, 7.0]
    graph.node("c").set("value", 8)
    assert [graph.node(name).get("a") for name in "bde"] == [8.0, 8.0, 8.0]


def test_state_is_a_source_where_there_is_no_output_of_that_name(build, playing):
    graph = build(
        {"tick": "test.Tick", "n": "test.Loop", "r": "test.Record"},
        ["tick.tick -> n.execIn", "n.finished -> r.execIn", "n.pass -> r.value"],
    )
    graph.evaluate(playing)
    assert graph.node("r").db.memory == [3.0]


@pytest.mark.parametrize("source", ["/World/A/a.outputs:y", "/World/A.a.outputs:y", "/World/A/a.y"])
def test_an_absolute_path_reaches_another_graph(library, make_spec, playing, source):
    one = make_spec({"a": ("test.Inc", {"a": 1})}, (), "push", path="/World/A")
    two = make_spec({"b": "test.Inc"}, [f"{source} -> b.a"], "push", path="/World/B")
    graphs = compile_graphs([one, two], library)
    for graph in graphs:
        graph.evaluate(playing)
    assert graphs[1].node("b").get("y") == 3.0


def test_values_cross_graphs_and_survive_a_stop_of_either(library, make_spec, playing):
    one = make_spec({"c": ("test.Constant", {"value": 5})}, path="/A")
    two = make_spec({"b": "test.Inc"}, ["/A/c.value -> b.a"], "push", path="/B")
    graphs = compile_graphs([one, two], library)
    for graph in graphs:
        graph.reset()
    graphs[1].evaluate(playing)
    assert graphs[1].node("b").get("y") == 6.0


@pytest.mark.parametrize("reader_first", [True, False])
def test_a_stop_takes_back_what_crossed_graphs_in_whatever_order_they_stop(library, make_spec, playing, reader_first):
    one = make_spec({"a": ("test.Inc", {"a": 1})}, (), "push", path="/A")
    two = make_spec({"b": "test.Inc"}, ["/A/a.y -> b.a"], "push", path="/B")
    graphs = compile_graphs([one, two], library)
    graphs[0].evaluate(playing)
    assert graphs[1].node("b").get("a") == 2.0
    for graph in reversed(graphs) if reader_first else graphs:
        graph.reset()
    assert graphs[1].node("b").get("a") == 0.0


def test_a_data_node_of_another_action_graph_is_pulled(library, make_spec, playing):
    one = make_spec({"a": ("test.Inc", {"a": 1})}, path="/A")
    two = make_spec({"t": "test.Tick", "r": "test.Record"}, ["t.tick -> r.execIn", "/A/a.y -> r.value"], path="/B")
    graphs = compile_graphs([one, two], library)
    graphs[1].evaluate(playing)
    assert graphs[1].node("r").db.memory == [2.0]


# -- open types ------------------------------------------------------------------------------------------------------


def settled(graph, *names):
    return [str(graph.node(name.partition(".")[0]).types[name.partition(".")[2]]) for name in names]


def test_open_types_take_the_type_of_what_feeds_them_and_spread_it(build):
    graph = build(
        {"v": "test.Vector", "one": "test.Sum", "two": "test.Sum", "show": "test.Show"},
        ["two.sum -> show.value", "one.sum -> two.a", "v.value -> two.b", "v.value -> one.a", "v.value -> one.b"],
    )
    assert settled(graph, "one.outputs:sum", "two.inputs:a", "show.inputs:value") == ["double[3]"] * 3


def test_a_written_value_follows_its_sibling_else_its_own_kind(build, playing):
    graph = build(
        {
            "c": ("test.Constant", {"value": 2}),
            "mixed": ("test.Sum", {"b": 1}),
            "alone": ("test.Sum", {"a": 1, "b": 2}),
            "named": ("test.Sum", {"a": {"type": "half", "value": 1}, "b": 2}),
        },
        ["c.value -> mixed.a"],
        "push",
    )
    assert settled(graph, "mixed.inputs:b", "alone.outputs:sum", "named.inputs:a") == ["double", "int", "half"]
    graph.evaluate(playing)
    assert graph.node("mixed").get("sum") == 3.0


def test_dynamic_inputs_are_there_when_written_or_connected(build, playing):
    graph = build(
        {"c": ("test.Constant", {"value": 2}), "s": ("test.Sum", {"a": 1.0, "b": 10.0, "c": 100.0})},
        ["c.value -> s.d"],
        "push",
    )
    graph.evaluate(playing)
    assert graph.node("s").get("sum") == 113.0


def test_ends_that_cannot_meet_are_both_named_with_their_types(library, make_spec):
    nodes = {"v": "test.Vector", "w": "test.Word", "inc": "test.Inc", "s": "test.Sum", "i2": "test.Inc"}
    links = ["v.value -> inc.a", "w.value -> s.a", "v.value -> s.b", "s.sum -> i2.a"]
    found = problems(library, make_spec(nodes, links))
    ends = "v.inputs:value (double[3]) cannot feed inc.inputs:a (double)"
    assert found[0] == f"g.yaml:101:1: {ends}; take a component with BreakVector3"
    ends = "w.inputs:value (token) cannot feed s.inputs:a (numerics)"
    assert found[1] == f"g.yaml:102:1: {ends}; give it a number, a matrix, a tuple of numbers or an array of numbers"


def test_an_open_input_that_nobody_sets_is_reported(library, make_spec):
    assert problems(library, make_spec({"s": ("test.Sum", {"a": 1})})) == [
        'g.yaml:1:1: node "s": input b is not set. Give it a value or connect it.'
    ]


# -- mistakes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("nodes", "links", "message"),
    [
        ({"a": "test.Inx"}, [], '1:1: node "a": no node type "test.Inx"; did you mean "test.Inc"?'),
        ({"a": "inc"}, [], '1:1: node "a": no node type "inc"; did you mean "Inc"?'),
        ({"a": ("Inc", {"b": 1})}, [], '1:1: node "a" (Inc) has no input "b"'),
        ({"a": ("Wait", {"update": 1})}, [], '1:1: node "a" (Wait) has no input "update"; did you mean "updates"?'),
        ({"a": ("Inc", {"y": 1})}, [], '1:1: node "a" (Inc) has no input "y"; it is an output'),
        (
            {"a": ("Inc", {"outputs:y": 1})},
            [],
            '1:1: node "a": outputs:y is an output; only inputs and state can be set',
        ),
        ({"a": ("Inc", {"a": "x"})}, [], "1:1: node \"a\": a: expected a number (double), got 'x'"),
        ({"a": ("Inc", {"a": 1, "inputs:a": 2})}, [], '1:1: node "a": inputs:a is set twice; keep one'),
        ({"a": ("Step", {"execIn": True})}, [], '1:1: node "a": execIn: execution attributes hold no value'),
        ({"a.b": "Inc"}, [], '1:1: "a.b" is not a node name; use letters, digits and underscores'),
        ({"a": "Inc"}, ["a -> a.a"], '101:1: "a" is not an end of a connection; write node.attribute'),
        ({"abc": "Inc"}, ["abd.y -> abc.a"], '101:1: no node "abd" in graph /World/G; did you mean "abc"?'),
        ({"a": "Inc"}, ["/World/H/a.y -> a.a"], '101:1: no node "/World/H/a"; did you mean "/World/G/a"?'),
        (
            {"a": "Wait"},
            ["a.finishd -> a.execIn"],
            '101:1: node "a" (Wait) has no output "finishd"; did you mean "finished"?',
        ),
        ({"a": "Inc", "b": "Inc"}, ["a.y -> b.y"], '101:1: node "b" (Inc) has no input "y"; it is an output'),
        (
            {"a": "Inc", "b": "Inc"},
            ["a.y -> b.outputs:y"],
            "101:1: b.outputs:y is an output; a connection ends at an input",
        ),
        (
            {"a": "Inc", "b": "Step"},
            ["a.y -> b.execIn"],
            "101:1: a.outputs:y (double) cannot feed b.inputs:execIn (execution): execution and data do not mix",
        ),
        (
            {"a": "Step", "b": "Step"},
            ["a.inputs:execIn -> b.execIn"],
            "101:1: a.inputs:execIn is an execution input; execution starts at an output",
        ),
        (
            {"a": "Inc", "c": "Constant"},
            ["a.y -> c.value"],
            "101:1: c.inputs:value is only a source; connect from it, not to it",
        ),
        (
            {"a": "Inc", "b": "Inc", "c": "Inc"},
            ["a.y -> c.a", "b.y -> c.a"],
            "102:1: c.inputs:a has two sources, a.outputs:y (at g.yaml:101:1) and b.outputs:y; a data input takes one",
        ),
        (
            {"a": "Step", "b": "Step"},
            ["a.execOut -> b.execIn", "a.execOut -> b.execIn"],
            "102:1: a.outputs:execOut -> b.inputs:execIn is written twice; remove one",
        ),
        (
            {"a": "Inc", "b": "Inc", "c": "Inc"},
            ["a.y -> b.a", "b.y -> c.a", "c.y -> a.a"],
            "103:1: data goes round in a cycle: a.outputs:y -> b.inputs:a, b.outputs:y -> c.inputs:a, "
            "c.outputs:y -> a.inputs:a. Remove one of these connections, or pass the value on by a variable",
        ),
        (
            {"a": "Inc"},
            ["a.y -> a.a"],
            "101:1: data goes round in a cycle: a.outputs:y -> a.inputs:a. Remove",
        ),
        (
            {"a": "Inc", "b": "Inc"},
            ["a.a -> b.a", "b.a -> a.a"],
            "data goes round in a cycle: ",
        ),
    ],
)
def test_each_mistake_has_its_message(library, make_spec, nodes, links, message):
    found = problems(library, make_spec(nodes, links))
    assert len(found) == 1
    assert message in found[0]


def test_execution_does_not_cross_graphs(library, make_spec):
    one = make_spec({"t": "Tick"}, path="/A")
    two = make_spec({"s": "Step"}, ["/A/t.tick -> s.execIn"], path="/B")
    assert problems(library, one, two) == [
        "g.yaml:101:1: /A/t.outputs:tick cannot start /B/s.inputs:execIn: execution does not cross graphs; "
        "send a custom event"
    ]


def test_a_name_that_is_taken_is_reported_for_graphs_and_variables(library, make_spec):
    one = make_spec({"a": "Inc"}, path="/A", variables={"gain": ("duble", 1), "n": ("int", "x")})
    assert problems(library, one, make_spec({}, path="/A")) == [
        'variable "gain": no attribute type "duble"; did you mean "double"?',
        "variable \"n\": expected a whole number (int), got 'x'",
        "graph /A is written twice; rename or merge one",
    ]


def test_all_mistakes_of_all_graphs_come_together_in_file_order(library, make_spec):
    one = make_spec({"a": ("Inc", {"a": "x"}), "b": "Nope"}, ["b.y -> a.a", "c.y -> a.a"], path="/A")
    two = make_spec({"a": ("Inc", {"q": 1})}, path="/B", file="h.yaml")
    found = problems(library, one, two)
    assert [line.partition(": ")[0] for line in found] == ["g.yaml:1:1", "g.yaml:2:1", "g.yaml:102:1", "h.yaml:1:1"]


def test_bounds_and_choices_are_held_against_what_is_written(library, make_spec):
    from graph import Attribute, declare

    declare(
        "test.Bounded",
        "Bounds.",
        inputs={
            "n": Attribute("int", "n", default=1, minimum=1, maximum=9),
            "kind": Attribute("token", "kind", default="", allowed_tokens=("laser_scan", "point_cloud")),
            "fixed": Attribute("token", "literal", default="", literal_only=True),
        },
        registry=library,
    )
    nodes = {
        "low": ("Bounded", {"n": 0}),
        "high": ("Bounded", {"n": 10}),
        "kind": ("Bounded", {"kind": "cloud"}),
        "fine": ("Bounded", {"n": 9, "kind": ""}),
        "w": "Word",
    }
    assert problems(library, make_spec(nodes, ["w.value -> fine.fixed"])) == [
        'g.yaml:1:1: node "low": n: 0 is below the minimum 1',
        'g.yaml:2:1: node "high": n: 10 is above the maximum 9',
        'g.yaml:3:1: node "kind": kind: \'cloud\' is not one of "laser_scan", "point_cloud"; '
        'did you mean "point_cloud"?',
        "g.yaml:101:1: fine.inputs:fixed cannot be connected; write its value under inputs",
    ]


def test_a_constant_that_does_not_fit_its_reader_is_reported(library, make_spec):
    nodes = {"c": ("Constant", {"value": 1e20}), "w": "Wait"}
    assert problems(library, make_spec(nodes, ["c.value -> w.updates"])) == [
        "g.yaml:101:1: c.inputs:value cannot feed w.inputs:updates: 1e+20 does not fit int (-2147483648 to 2147483647)"
    ]


def test_deprecated_attributes_work_and_warn_once(library, make_spec, playing):
    from graph import Attribute, declare

    old = {
        "old": Attribute("int", "old", default=0, deprecated="use new"),
        "older": Attribute("int", "older", default=0, deprecated="use new", warns_itself=True),
    }
    declare("test.Old", "Old.", inputs=old, registry=library)
    graph = compile_graphs([make_spec({"o": ("Old", {"old": 1, "older": 1})})], library)[0]
    graph.evaluate(playing)
    graph.evaluate(playing)
    assert [(w.code, w.where, w.message, w.count) for w in playing.warn] == [
        ("deprecated-attribute", "/World/G/o", "inputs:old is deprecated: use new", 1)
    ]


# -- order -----------------------------------------------------------------------------------------------------------


def test_order_is_file_order_where_dependencies_leave_a_choice():
    assert dependency_order(5, [[], [0], [], [2], []]) == [1, 0, 3, 2, 4]


def test_cycles_are_distinguished_and_what_lies_behind_them_is_left_out():
    readers = [[1], [2], [0, 3], [4], [], [6], [5]]
    assert dependency_order(7, readers) == []
    assert cycles(7, readers, most=9) == [[0, 1, 2], [5, 6]]
    assert cycles(7, readers, most=1) == [[0, 1, 2]]


def test_a_hundred_thousand_nodes_are_ordered_without_recursion():
    count = 100_000
    readers = [[node - 1] if node else [] for node in range(count)]
    assert dependency_order(count, readers) == list(range(count))[::-1]


def test_a_thousand_mistakes_are_reported_without_delay(library, make_spec):
    nodes = {f"node{i}": f"test.Inx{i}" if i % 2 else "test.Inc" for i in range(1000)}
    found = problems(library, make_spec(nodes, [f"nose{i}.y -> node{i}.a" for i in range(1000)]))
    assert len(found) == 1500


def test_only_the_first_unknown_types_have_a_suggestion(library, make_spec):
    told = problems(library, make_spec({f"n{i}": f"test.Inc{i % 30}x" for i in range(60)}))
    assert [line.endswith('; did you mean "test.Inc"?') for line in told] == ([True] * 20 + [False] * 10) * 2
    assert told[25].endswith('node "n25": no node type "test.Inc25x"; --skip-unknown runs the rest of the file')


def test_thousands_of_unknown_types_are_found_in_little_time(make_spec):
    spec = make_spec({f"n{i}": f"omni.graph.nodes.Ad{i}" for i in range(4_000)})
    compile_graphs([make_spec({"a": "omni.graph.nodes.ConstantDouble"})])  # the shipped types are there
    with within(0.8), pytest.raises(UserError) as caught:
        compile_graphs([spec])
    assert len(caught.value.problems) == 4_000
