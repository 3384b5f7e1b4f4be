"""Data nodes of open types between two plain numbers, against the same operator written by hand."""

import operator
from collections.abc import Callable, Iterable

from measure import Row, ratio, seconds

from graph import Graph, compile_graphs
from graph.spec.file_spec import GraphSpec, NodeSpec

TITLE = "nodes: arithmetic and comparison of two numbers"
NODES = 1_000
OPERATIONS: dict[str, Callable[[float, float], object]] = {
    "Add": operator.add,
    "Multiply": operator.mul,
    "Subtract": operator.sub,
    "Divide": operator.truediv,
    "Compare": operator.gt,
}


def graph_of(kind: str) -> Graph:
    """A push graph of many such nodes that nothing connects."""
    number = {"type": "double", "value": 2.5}
    nodes = tuple(
        NodeSpec(f"n{index}", f"omni.graph.nodes.{kind}", {"a": number, "b": number}) for index in range(NODES)
    )
    return compile_graphs([GraphSpec("/bench", nodes, evaluator="push")])[0]


class _Thing:
    __slots__ = ("a", "b", "result")

    def __init__(self) -> None:
        self.a = self.b = self.result = 2.5


def by_hand(operation: Callable[[float, float], object]) -> Callable[[], None]:
    """The same work as a list of calls."""

    def call(thing: _Thing) -> None:
        thing.result = operation(thing.a, thing.b)  # type: ignore[assignment]

    things = [_Thing() for _ in range(NODES)]

    def run() -> None:
        for thing in things:
            call(thing)

    return run


def measure(quick: bool) -> Iterable[Row]:
    """One row a node type, and what a node costs."""
    rounds = 1 if quick else 25
    for kind, operation in OPERATIONS.items():
        graph = graph_of(kind)

        def evaluate(graph: Graph = graph) -> None:
            graph.evaluate(graph.context)

        yield Row(f"{kind} against a plain call", ratio(evaluate, by_hand(operation), rounds), 4.0)
        cost = min(seconds(evaluate) for _ in range(rounds)) / NODES
        yield Row(f"{kind}, one node", cost * 1e6, 0.5, "us")
