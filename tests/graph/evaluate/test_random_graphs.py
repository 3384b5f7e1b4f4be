"""Promises over graphs that nobody thought of: order, laziness, and edits that equal a fresh compile."""

from contextlib import suppress

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graph import Attribute, ComputeError, Context, Controller, OmniGraphError, compile_graphs, node_type
from graph.evaluate import RunawayError
from graph.node.decorator import declare
from graph.node.registry import Registry
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec
from nodes.data.like_inputs import same_type
from nodes.data.promotion import array_of_first, promoted

K = Controller.Keys
LIBRARY = Registry()
ORDER: list[str] = []
FEW = settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow])


@node_type(
    "random.Mix",
    inputs={"a": Attribute("double", "one"), "b": Attribute("double", "two"), "own": Attribute("double", "own value")},
    outputs={"y": Attribute("double", "a mix")},
    registry=LIBRARY,
)
def mix(db):
    """Mixes its inputs so that no two orders give the same."""
    ORDER.append(db.node.name)
    db.outputs.y = db.inputs.a * 0.5 + db.inputs.b * 0.25 + db.inputs.own


@node_type(
    "random.Step",
    inputs={"execIn": Attribute("execution", "runs"), "a": Attribute("double", "in")},
    outputs={
        "one": Attribute("execution", "first"),
        "two": Attribute("execution", "second"),
        "y": Attribute("double", "a + 1"),
    },
    registry=LIBRARY,
)
def step(db):
    """Goes on both ways."""
    ORDER.append(db.node.name)
    db.outputs.y = db.inputs.a + 1
    db.fire("one")
    db.fire("two")


@node_type("random.Tick", outputs={"tick": Attribute("execution", "starts")}, event=True, registry=LIBRARY)
def tick(db):
    """Starts."""
    db.fire("tick")


@st.composite
def data_graphs(draw, most=8):
    """Nodes in random file order; every input has at most one source, of a node that is earlier in a hidden order."""
    count = draw(st.integers(1, most))
    hidden = draw(st.permutations(range(count)))
    edges = {}
    for position, node in enumerate(hidden):
        for port in "ab":
            source = draw(st.sampled_from([None, *hidden[:position]]))
            if source is not None:
                edges[f"n{node}", port] = f"n{source}"
    values = {f"n{i}": draw(st.integers(-5, 5)) for i in range(count)}
    return [f"n{i}" for i in range(count)], edges, values


def spec_of(nodes, edges, values, evaluator, path="/R"):
    made = [NodeSpec(name, "random.Mix", {"own": values[name]}) for name in nodes]
    links = [ConnectionSpec(f"{source}.y", f"{node}.{port}") for (node, port), source in edges.items()]
    return GraphSpec(path, tuple(made), tuple(links), evaluator)


def outputs(graph):
    return {name: node.get("outputs:y") for name, node in graph.nodes.items() if "y" in node.names["outputs"]}


def by_hand(nodes, edges, values):
    """The values by recursion, straight from the definition."""
    done = {}

    def value(node):
        if node not in done:
            a, b = (value(edges[node, port]) if (node, port) in edges else 0.0 for port in "ab")
            done[node] = a * 0.5 + b * 0.25 + values[node]
        return done[node]

    return {node: value(node) for node in nodes}


@FEW
@given(data_graphs())
def test_a_push_graph_computes_each_node_once_behind_its_sources_in_file_order(drawn):
    nodes, edges, values = drawn
    graph = compile_graphs([spec_of(nodes, edges, values, "push")], LIBRARY)[0]
    ORDER.clear()
    graph.evaluate(Context.standalone())
    expected, waiting = [], list(nodes)
    while waiting:
        ready = next(n for n in waiting if not any(edges.get((n, port)) in waiting for port in "ab"))
        waiting.remove(ready)
        expected.append(ready)
    assert expected == ORDER
    assert outputs(graph) == by_hand(nodes, edges, values)


@FEW
@given(data_graphs(), st.lists(st.tuples(st.integers(0, 11), st.integers(-5, 5)), max_size=6))
def test_a_lazy_graph_gives_what_a_push_graph_gives(drawn, sets):
    nodes, edges, values = drawn
    lazy, push = (compile_graphs([spec_of(nodes, edges, values, one)], LIBRARY)[0] for one in ("dirty_push", "push"))
    context = Context.standalone()
    for index, value in [(None, None), *sets]:
        if index is not None:
            for graph in (lazy, push):
                graph.nodes[nodes[index % len(nodes)]].set("own", value)
        lazy.evaluate(context)
        push.evaluate(context)
        assert outputs(lazy) == outputs(push)
    ORDER.clear()
    lazy.evaluate(context)
    assert ORDER == []


@FEW
@given(st.sampled_from(["push", "dirty_push"]), data_graphs(), data_graphs(), st.data())
def test_edits_end_where_a_fresh_compile_begins(evaluator, before, after, data):
    """From any graph to any other by a few edits, evaluated in between or not: the same nodes, links, values."""
    nodes, edges, values = before
    wanted, new_edges, new_values = after
    control = Controller(registry=LIBRARY)
    graph = control.edit({"graph_path": "/R", "evaluator_name": evaluator})[0]
    control.edit(
        graph,
        {
            K.CREATE_NODES: [(name, "random.Mix") for name in nodes],
            K.CONNECT: [(f"{s}.outputs:y", f"{n}.inputs:{p}") for (n, p), s in edges.items()],
            K.SET_VALUES: [(f"{name}.inputs:own", values[name]) for name in nodes],
        },
    )
    if data.draw(st.booleans()):
        control.evaluate_sync(graph)
    control.edit(
        graph,
        {
            K.DISCONNECT: [
                (f"{s}.outputs:y", f"{n}.inputs:{p}") for (n, p), s in edges.items() if n in wanted and s in wanted
            ],
            K.DELETE_NODES: [name for name in nodes if name not in wanted],
        },
    )
    if data.draw(st.booleans()):
        control.evaluate_sync(graph)
    control.edit(
        graph,
        {
            K.CREATE_NODES: [(name, "random.Mix") for name in wanted if name not in nodes],
            K.CONNECT: [(f"{s}.outputs:y", f"{n}.inputs:{p}") for (n, p), s in new_edges.items()],
            K.SET_VALUES: [(f"{name}.inputs:own", new_values[name]) for name in wanted],
        },
    )
    control.evaluate_sync(graph)
    assert outputs(graph) == by_hand(wanted, new_edges, new_values)
    fresh = compile_graphs([graph.spec], LIBRARY)[0]
    graph.reset()
    for one in (graph, fresh):
        ORDER.clear()
        one.evaluate(Context.standalone())
        order = list(ORDER)
        assert outputs(one) == by_hand(wanted, new_edges, new_values)
    assert anatomy(fresh) == anatomy(graph)
    assert sorted(order) == sorted(wanted)


def anatomy(graph):
    """All that compiling decides, by node: order of computing, types, values to start with, who feeds whom and how."""
    graph.settle()
    order = sorted(graph.nodes.values(), key=lambda node: node.rank)
    assert [one.index for one in graph.nodes.values()] == sorted(one.index for one in graph.nodes.values())
    return {
        node.name: (
            order.index(node),
            dict(node.types),
            {full: repr(node.initial(full)) for full in node.types if not node.attribute(full).is_execution},
            [(full, node.connected(full)) for full in node.types],
            [one.name for one in node.sources],
            [one.name for one in node.readers],
            [(full, node.wires_into(full[7:])) for full in node.types if full.startswith("inputs:")],
        )
        for node in graph.nodes.values()
    }


@node_type(
    "random.Sum",
    inputs={"a": Attribute("numerics", "one"), "b": Attribute("numerics", "two")},
    outputs={"sum": Attribute("numerics", "their sum")},
    resolve=promoted("sum"),
    registry=LIBRARY,
)
def add_up(db):
    """Adds what comes."""
    ORDER.append(db.node.name)
    db.outputs.sum = db.inputs.a + db.inputs.b


@node_type(
    "random.Same",
    inputs={"value": Attribute("any", "anything")},
    outputs={"same": Attribute("any", "the same")},
    resolve=same_type("value", "same"),
    registry=LIBRARY,
)
def same(db):
    """Passes on what comes."""
    ORDER.append(db.node.name)
    db.outputs.same = db.inputs.value


@node_type(
    "random.First",
    inputs={
        "input0": Attribute("any", "one"),
        "input1": Attribute("any", "two"),
        "arrayType": Attribute("token", "", default="auto"),
    },
    outputs={"array": Attribute("any", "both")},
    resolve=array_of_first,
    registry=LIBRARY,
)
def first(db):
    """Makes an array of the type that it knows first."""
    ORDER.append(db.node.name)


declare("random.Whole", "a whole number", inputs={"value": Attribute("int", "it", output_only=True)}, registry=LIBRARY)
declare("random.Real", "a number", inputs={"value": Attribute("double", "it", output_only=True)}, registry=LIBRARY)

TYPE_OF = {
    "n0": "random.Mix", "n1": "random.Sum", "n2": "random.Whole", "n3": "random.Step", "n4": "random.Sum",
    "n5": "random.Tick", "n6": "random.Same", "n7": "random.Real", "n8": "random.Sum", "n9": "random.First",
}  # fmt: skip
NAMES = list(TYPE_OF)
ENDS = {
    "random.Mix": ["outputs:y", "inputs:own", "inputs:a"],
    "random.Step": ["outputs:one", "outputs:two", "outputs:y", "inputs:a"],
    "random.Tick": ["outputs:tick"],
    "random.Sum": ["outputs:sum", "outputs:sum", "inputs:a"],
    "random.Same": ["outputs:same"],
    "random.First": ["outputs:array"],
    "random.Whole": ["inputs:value"],
    "random.Real": ["inputs:value"],
}
STARTS = {
    "random.Mix": ["a", "b", "own"],
    "random.Step": ["execIn", "a"],
    "random.Tick": ["execIn"],
    "random.Sum": ["a", "b"],
    "random.Same": ["value"],
    "random.First": ["input0", "input1"],
    "random.Whole": ["value"],
    "random.Real": ["value"],
}
OPEN = ("random.Sum", "random.Same", "random.First")
VALUES = [0, 3, 9, 2.5, {"type": "float", "value": 1.0}, [1.0, 2.0]]


@st.composite
def single_edits(draw):
    """One call of the Controller: the method and what it takes."""
    kind = draw(st.sampled_from(["create_node", "connect", "connect", "set", "edit", "disconnect", "delete_node"]))
    one, other = draw(st.sampled_from(NAMES)), draw(st.sampled_from(NAMES))
    into = f"/R/{other}.inputs:{draw(st.sampled_from(STARTS[TYPE_OF[other]]))}"
    if kind == "create_node":
        return kind, (f"/R/{one}", TYPE_OF[one])
    if kind == "delete_node":
        return kind, (f"/R/{one}",)
    if kind in ("connect", "disconnect"):
        return kind, (f"/R/{one}.{draw(st.sampled_from(ENDS[TYPE_OF[one]]))}", into)
    value = draw(st.sampled_from(VALUES))
    # A value that is set keeps the type that an open attribute has; an edited value settles it again.
    settled = TYPE_OF[other] not in OPEN
    return (kind, (into, value)) if kind == "set" and settled else ("edit", ("/R", {K.SET_VALUES: [(into, value)]}))


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from(["push", "dirty_push", "execution"]),
    st.booleans(),
    st.lists(st.one_of(single_edits(), st.just(("evaluate_sync", ("/R",)))), max_size=30),
)
def test_single_edits_leave_what_a_fresh_compile_makes(evaluator, all_there, calls):
    """Whether an edit was made in place or by compiling, done or refused: the graph is that of its spec."""
    control = Controller(registry=LIBRARY)
    graph = control.edit({"graph_path": "/R", "evaluator_name": evaluator})[0]
    if all_there:
        control.edit(graph, {K.CREATE_NODES: list(TYPE_OF.items())})
    graph.step_limit = 50
    for method, arguments in calls:
        before = anatomy(graph), graph.spec, dict(graph.written)
        try:
            getattr(control, method)(*arguments)
        except OmniGraphError:
            assert (anatomy(graph), graph.spec, graph.written) == before
        except (ComputeError, RunawayError):
            assert method == "evaluate_sync"
    spec = control.graphs.current_spec("/R")
    fresh = compile_graphs([spec], LIBRARY)[0]
    assert anatomy(fresh) == anatomy(graph)
    graph.reset()
    seen = []
    for one in (graph, fresh):
        ORDER.clear()
        one.step_limit = 50
        for _ in range(2):
            with suppress(ComputeError, RunawayError):  # wires may lead round, open inputs are not set
                one.evaluate(Context.standalone())
        seen.append((list(ORDER), outputs(one)))
    assert seen[0] == seen[1]


def outcome(control, method, arguments):
    """What a call says: "" if it is done."""
    try:
        getattr(control, method)(*arguments)
    except (OmniGraphError, ComputeError, RunawayError) as error:
        return str(error)
    return ""


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from(["push", "dirty_push", "execution"]),
    st.lists(st.one_of(single_edits(), st.just(("evaluate_sync", ("/R",)))), min_size=8, max_size=30),
)
def test_edits_that_wait_are_refused_as_those_compiled_at_once_and_end_in_the_same_graph(evaluator, calls):
    controls = [Controller(registry=LIBRARY) for _ in range(2)]
    graphs = [control.edit({"graph_path": "/R", "evaluator_name": evaluator})[0] for control in controls]
    for graph in graphs:
        graph.step_limit = 50
    for method, arguments in calls:
        waiting, at_once = (outcome(control, method, arguments) for control in controls)
        assert waiting == at_once
        graphs[1].settle()
    assert anatomy(graphs[0]) == anatomy(graphs[1])
    assert anatomy(graphs[0]) == anatomy(compile_graphs([controls[0].graphs.current_spec("/R")], LIBRARY)[0])


@st.composite
def trees(draw, most=15):
    """Execution trees: each node hangs on an output of an earlier one; the connections come in random order."""
    count = draw(st.integers(1, most))
    parents = [draw(st.tuples(st.integers(0, i - 1), st.sampled_from(["one", "two"]))) for i in range(1, count)]
    links = [("tick.tick", "n0")] + [(f"n{p}.{out}", f"n{i}") for i, (p, out) in enumerate(parents, 1)]
    return count, draw(st.permutations(links))


@FEW
@given(trees())
def test_an_action_graph_walks_depth_first_in_connection_order(drawn):
    count, links = drawn
    nodes = [NodeSpec("tick", "random.Tick"), *(NodeSpec(f"n{i}", "random.Step") for i in range(count))]
    connections = [ConnectionSpec(source, f"{target}.execIn") for source, target in links]
    graph = compile_graphs([GraphSpec("/R", tuple(nodes), tuple(connections))], LIBRARY)[0]
    ORDER.clear()
    graph.evaluate(Context.standalone())
    walked = []

    def walk(node):
        walked.append(node)
        for output in ("one", "two"):
            for source, target in links:
                if source == f"{node}.{output}":
                    walk(target)

    walk("n0")
    assert walked == ORDER
