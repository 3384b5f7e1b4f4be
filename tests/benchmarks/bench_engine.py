"""The evaluators against plain Python: the same work as a list of calls, and as a graph sorted in every update."""

from collections.abc import Callable, Iterable

from measure import Row, ratio, seconds

from graph import Attribute, Context, Graph, compile_graphs, node_type
from graph.node.registry import Registry
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec

TITLE = "engine: a chain of 1,000 nodes, each adding one"
CHAIN = 1_000
REGISTRY = Registry()
NUMBER_IN, NUMBER_OUT = {"a": Attribute("double", "a number")}, {"y": Attribute("double", "a + 1")}
EXECUTION_IN, EXECUTION_OUT = {"execIn": Attribute("execution", "runs")}, {"execOut": Attribute("execution", "follows")}


@node_type("bench.Add", inputs=NUMBER_IN, outputs=NUMBER_OUT, registry=REGISTRY)
def add(db) -> None:
    """One more."""
    db.outputs.y = db.inputs.a + 1


@node_type("bench.Step", inputs=EXECUTION_IN | NUMBER_IN, outputs=EXECUTION_OUT | NUMBER_OUT, registry=REGISTRY)
def step(db) -> None:
    """One more, then on."""
    db.outputs.y = db.inputs.a + 1
    db.fire("execOut")


@node_type("bench.Tick", outputs={"tick": Attribute("execution", "each time")}, event=True, registry=REGISTRY)
def tick(db) -> None:
    """Starts the walk."""
    db.fire("tick")


class _Object:
    """What the plain calls work on: an input, an output, and a list for the name that is fired."""

    __slots__ = ("a", "fire", "y")

    def __init__(self, fire: Callable[[str], None]) -> None:
        self.a = self.y = 0.0
        self.fire = fire


def _plain(thing: _Object) -> None:
    thing.y = thing.a + 1


def _plain_step(thing: _Object) -> None:
    thing.y = thing.a + 1
    thing.fire("execOut")


def plain_calls(function: Callable[[_Object], None]) -> Callable[[], None]:
    """The chain as people would write it by hand: call after call, each result handed on."""
    fired: list[str] = []
    things = [_Object(fired.append) for _ in range(CHAIN)]
    pairs = list(zip(things, [*things[1:], _Object(fired.append)], strict=True))

    def run() -> None:
        for thing, behind in pairs:
            function(thing)
            behind.a = thing.y
        fired.clear()

    return run


def chain(evaluator: str, count: int = CHAIN) -> GraphSpec:
    """`count` nodes in a row."""
    links = [ConnectionSpec(f"n{i}.y", f"n{i + 1}.a") for i in range(count - 1)]
    nodes = [NodeSpec(f"n{i}", "bench.Step" if evaluator == "execution" else "bench.Add") for i in range(count)]
    if evaluator == "execution":
        nodes.append(NodeSpec("tick", "bench.Tick"))
        links.append(ConnectionSpec("tick.tick", "n0.execIn"))
        links += [ConnectionSpec(f"n{i}.execOut", f"n{i + 1}.execIn") for i in range(count - 1)]
    return GraphSpec("/bench", tuple(nodes), tuple(links), evaluator)  # type: ignore[arg-type]


def compiled(spec: GraphSpec) -> Callable[[], None]:
    """One evaluation of the graph; the first one, which prepares it, is done."""
    graph, context = compile_graphs([spec], REGISTRY)[0], Context.standalone()
    graph.evaluate(context)
    return lambda: graph.evaluate(context)


def sorting_each_update(graph: Graph, order_of: Callable[[list[tuple[str, str]]], Iterable[str]]) -> Callable[[], None]:
    """What a graph library invites to: sort, then compute and look the sources up."""
    edges = [(f"n{i}", f"n{i + 1}") for i in range(CHAIN - 1)]

    def run() -> None:
        for name in order_of(edges):
            db = graph.nodes[name].db
            add(db)

    return run


def measure(quick: bool) -> Iterable[Row]:
    """Ratios to plain calls and to networkx, time a node, time to compile a large graph."""
    import networkx

    push, execution, lazy = (compiled(chain(evaluator)) for evaluator in ("push", "execution", "dirty_push"))
    rounds = 2 if quick else 200
    yield Row("push graph / plain calls that hand results on", ratio(push, plain_calls(_plain), rounds))
    yield Row("push graph / bare calls", ratio(push, _bare_calls(_plain), rounds), 5)
    yield Row("action graph / plain calls that hand results on", ratio(execution, plain_calls(_plain_step), rounds))
    yield Row("action graph / bare calls that note what fired", ratio(execution, _bare_calls(_plain_step), rounds), 5)
    yield Row("push graph, a node", min(seconds(push) for _ in range(rounds)) / CHAIN * 1e6, 0.3, "us")
    yield Row(
        "action graph, a node with a value handed on",
        min(seconds(execution) for _ in range(rounds)) / CHAIN * 1e6,
        0.3,
        "us",
    )
    yield Row(
        "lazy graph without a change, all 1,000 nodes", min(seconds(lazy) for _ in range(rounds)) * 1e6, None, "us"
    )

    graph = compile_graphs([chain("push")], REGISTRY)[0]
    naive = sorting_each_update(graph, lambda edges: networkx.lexicographical_topological_sort(networkx.DiGraph(edges)))
    yield Row("push graph / sorting with networkx in every update", ratio(push, naive, 5), 0.1)

    count = 1_000 if quick else 100_000
    spec = chain("execution", count)
    yield Row(
        f"compile {count:,} nodes with {2 * count:,} connections",
        seconds(lambda: compile_graphs([spec], REGISTRY)),
        10,
        "s",
    )
    walk = compiled(spec)
    yield Row(f"evaluate them, a node ({count:,} nodes)", seconds(walk) / count * 1e6, None, "us")


def _bare_calls(function: Callable[[_Object], None]) -> Callable[[], None]:
    """The computes alone, in a loop: nothing is handed on."""
    fired: list[str] = []
    things = [_Object(fired.append) for _ in range(CHAIN)]

    def run() -> None:
        for thing in things:
            function(thing)
        fired.clear()

    return run
