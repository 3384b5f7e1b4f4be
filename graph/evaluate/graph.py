"""A compiled graph: its nodes, and the evaluation that its evaluator type stands for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, Protocol

from graph.context import Context
from graph.db import Database, NodeError
from graph.declaration import Compute
from graph.errors import Mark
from graph.spec import Evaluator, PipelineStage
from graph.suggest import did_you_mean
from graph.variables import Variables

from .errors import ComputeError
from .node import Node
from .wire import Copy

Activation = tuple[Node, str]
"""A node and the execution input that is triggered."""


class EvaluatorProtocol(Protocol):
    """One way to evaluate a graph: `run` once, `reset` at a stop, hear of sleeping nodes and of changed ones."""

    def run(self, activations: Sequence[Activation]) -> None:
        """Evaluates the graph once."""

    def reset(self) -> None:
        """Forgets what it kept between evaluations."""

    def sleeps(self, db: Database) -> None:
        """Hears that a node fell asleep."""

    def wakes(self, db: Database) -> None:
        """Hears that a node ended its sleep."""

    def touched(self, node: Node) -> None:
        """Hears that a value of a node was set from outside."""


class Graph:
    """One graph, ready to run. Made by `graph.plan.compile_graphs`.

    on_error: "stop" (a failing node ends the run) or "continue" (it is warned of and treated as having nothing to do).
    step_limit: how many nodes one walk may compute without coming to an end (loops made by `fire_and_return` count
    each pass for itself); beyond it the walk is taken for a runaway.
    interrupts: whether a trigger that reaches a sleeping node starts it anew instead of being ignored.
    """

    def __init__(
        self, path: str, evaluator: Evaluator, pipeline_stage: PipelineStage, variables: Variables, mark: Mark | None
    ) -> None:
        self.path = path
        self.evaluator = evaluator
        self.pipeline_stage = pipeline_stage
        self.variables = variables
        self.mark = mark
        self.nodes: dict[str, Node] = {}
        self.context = Context()
        self.on_error: Literal["stop", "continue"] = "stop"
        self.step_limit = 1_000_000
        self.interrupts = False
        self.evaluations = 0
        self.notes: tuple[tuple[str, str, str], ...] = ()
        """Warnings of the compiler (code, where, message); given to the context at the first evaluation."""
        self.starts: list[Copy] = []
        """Copies along every data connection that begins or ends in this graph."""
        self._told = False
        self._evaluator: EvaluatorProtocol | None = None
        self._running = False

    def __repr__(self) -> str:
        return f"<{self.evaluator} graph {self.path}, {len(self.nodes)} nodes>"

    def node(self, name: str) -> Node:
        """The node of that name or path. Raises KeyError with the nearest name."""
        name = name.removeprefix(f"{self.path}/")
        try:
            return self.nodes[name]
        except KeyError:
            raise KeyError(f'graph {self.path} has no node "{name}"{did_you_mean(name, self.nodes)}') from None

    def evaluate(self, context: Context, activations: Sequence[tuple[Node | str, str]] = ()) -> None:
        """Evaluates once. Execution graphs: sleeping nodes, then events, then `activations` in the given order.

        Raises ComputeError when a node fails and RunawayError when a walk does not end; a graph that is asked to
        evaluate itself from within one of its own nodes raises RuntimeError.
        """
        if self._running:
            raise RuntimeError(f"graph {self.path} is being evaluated already; a node cannot evaluate its own graph")
        if self._evaluator is None:
            self._evaluator = _evaluator_of(self)
        self.context = context
        if not self._told:
            self._told = True
            for code, where, message in self.notes:
                context.warn(code, where, message)
        self.evaluations += 1
        self._running = True
        try:
            self._evaluator.run([(self._of(node), name) for node, name in activations] if activations else ())
        finally:
            self._running = False

    def observe(self, wrap: Callable[[Node, Compute], Compute]) -> None:
        """Puts `wrap(node, compute)` in the place of every node's compute, for tools that measure or trace.

        Raises RuntimeError during an evaluation.
        """
        if self._running:
            raise RuntimeError(f"graph {self.path} is being evaluated; observe it before or after")
        for node in self.nodes.values():
            if node.db._compute is not None:
                node.db._compute = wrap(node, node.db._compute)
        for node in self.nodes.values():
            for wire in node.db._wires.values():
                wire.renew()
        if self.evaluator == "push":
            self._evaluator = None  # its plan holds the functions; it keeps nothing else

    def reset(self) -> None:
        """What a timeline stop does: values as authored, fresh memory, everybody awake. Compute counts go on."""
        self.variables.reset()
        for node in self.nodes.values():
            node.reset()
        for copy in self.starts:
            copy()
        if self._evaluator is not None:
            self._evaluator.reset()

    def close(self) -> None:
        """Releases what the nodes hold; calling it twice is harmless."""
        for node in self.nodes.values():
            node.release()

    def _of(self, node: Node | str) -> Node:
        return self.node(node) if isinstance(node, str) else node

    # -- for nodes and evaluators ------------------------------------------------------------------------------------

    def sleeps(self, db: Database) -> None:
        """A node of this graph fell asleep."""
        if self._evaluator is not None:
            self._evaluator.sleeps(db)

    def wakes(self, db: Database) -> None:
        """A node of this graph ended its sleep."""
        if self._evaluator is not None:
            self._evaluator.wakes(db)

    def touched(self, node: Node) -> None:
        """A value of this node was set from outside."""
        if self._evaluator is not None:
            self._evaluator.touched(node)

    def failed(self, db: Database, error: Exception) -> None:
        """Deals with an exception of this node's compute by `on_error`. Raises ComputeError for "stop"."""
        db._enabled.clear()
        text = str(error) if isinstance(error, NodeError) else f"{type(error).__name__}: {error}"
        message = " ".join(text.split())
        if self.on_error == "stop":
            raise ComputeError(db._node, self.context.update, message) from error
        self.context.warn("compute-failed", db.path, message)


def by_path(graphs: Sequence[Graph]) -> Mapping[str, Graph]:
    """The graphs by path, in their order."""
    return {graph.path: graph for graph in graphs}


def _evaluator_of(graph: Graph) -> EvaluatorProtocol:
    from .dirty import DirtyPushEvaluator
    from .execution import ExecutionEvaluator
    from .push import PushEvaluator

    if graph.evaluator == "execution":
        return ExecutionEvaluator(graph)
    return PushEvaluator(graph) if graph.evaluator == "push" else DirtyPushEvaluator(graph)
