"""A compiled graph: its nodes, and the evaluation that its evaluator type stands for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Protocol, get_args

from graph.base.suggest import did_you_mean
from graph.node.context import Context
from graph.node.database import STARTED, Database, LackError
from graph.node.declaration import Compute
from graph.node.variables import Variables
from graph.spec.file_spec import Evaluator, GraphSpec, PipelineStage

from .causes import cause_of
from .errors import ComputeError
from .instances import with_target
from .node import Node
from .omnigraph_names import FamiliarGraph
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


class Graph(FamiliarGraph):
    """One graph, ready to run. Made by `graph.plan.compile_graphs`.

    on_error: "stop" (a failing node ends the run) or "continue" (it is warned of and treated as having nothing to do).
    step_limit: how many nodes one walk may compute without coming to an end (loops made by `fire_and_return` count
    each pass for itself); beyond it the walk is taken for a runaway.
    interrupts: whether a trigger that reaches a sleeping node starts it anew instead of being ignored.
    """

    def __init__(self, spec: GraphSpec, variables: Variables, target: str = "") -> None:
        self.spec = spec
        """What it was compiled from; values set since stand in `written`."""
        self.path = spec.path
        self.evaluator: Evaluator = spec.evaluator
        self.pipeline_stage: PipelineStage = spec.pipeline_stage
        self.variables = variables
        self.mark = spec.mark
        self.nodes: dict[str, Node] = {}
        self.ranks = 0
        """More than any of its nodes' ranks."""
        self.reorder: Callable[[], None] | None = None
        """Brings the ranks up to date, where edits left them in an order that does but is not that of the file."""
        self.context = Context()
        self.on_error: Literal["stop", "continue"] = "stop"
        self.excuses_lacks = spec.saved
        """Whether a node that lacks what the file should have given it is only warned of."""
        self.step_limit = 1_000_000
        self.interrupts = False
        self.evaluations = 0
        self.notes: tuple[tuple[str, str, str], ...] = ()
        """Warnings of the compiler (code, where, message); given to the context at the first evaluation."""
        self.starts: dict[Copy, None] = {}
        """Copies along every data connection that begins or ends in this graph."""
        self.linked: set[str] = set()
        """Paths of the graphs that it exchanges data with."""
        self.written: dict[tuple[str, str], Any] = {}
        """Values set since it was compiled, by node name and full attribute name."""
        self.target = target or spec.path
        """The prim that `_OMNI_GRAPH_TARGET` stands for: the one that has this instance, else the graph itself."""
        self.instances: dict[str, Graph] = {}
        """The graph once more for each prim that has it, with values and memory of its own."""
        self._wraps: list[Callable[[Node, Compute], Compute]] = []
        self._idle: list[Callable[[], None]] = []
        self._requested: dict[Node, None] = {}
        self._told = False
        self.evaluator_state: EvaluatorProtocol | None = None
        """What evaluates it; made at the first evaluation."""
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

    def to_networkx(self) -> Any:
        """This graph as a `networkx.MultiDiGraph`, for analyses of your own; see `graph.evaluate.links.to_networkx`."""
        from .links import to_networkx

        return to_networkx([self])

    def evaluate(self, context: Context, activations: Sequence[tuple[Node | str, str]] = ()) -> None:
        """Evaluates once. Execution graphs: sleeping nodes, then events, then `activations` in the given order.

        A graph that prims have is evaluated once for each of them, in their order, and not by itself. What its nodes
        edit takes effect when the evaluation has ended. Raises ComputeError when a node fails and RunawayError when a
        walk does not end; a graph that is asked to evaluate itself from within one of its own nodes raises
        RuntimeError.
        """
        if self._running:
            raise RuntimeError(f"graph {self.path} is being evaluated already; a node cannot evaluate its own graph")
        self.context = context
        if not self._told:
            self._told = True
            for code, where, message in self.notes:
                context.warn(code, where, message)
        self.evaluations += 1
        self._running = True
        try:
            if self.runs_in_instances:
                self._evaluate_instances(context, activations)
            else:
                if self.evaluator_state is None:
                    self.evaluator_state = _evaluator_of(self)
                started = [(self._of(node), name) for node, name in activations] if activations else []
                if self._requested:
                    started += self._take_requested()
                self.evaluator_state.run(started)
        finally:
            self._running = False
            if self._idle:
                self._now_idle()

    def settle_order(self) -> None:
        """Brings the ranks up to date."""
        reorder, self.reorder = self.reorder, None
        if reorder is not None:
            reorder()

    def request(self, node: Node) -> None:
        """Has a node compute in the next evaluation: after the events and activations; at most once."""
        self._requested[node] = None

    def _take_requested(self) -> list[tuple[Node, Any]]:
        requested, self._requested = self._requested, {}
        present = [node for node in requested if self.nodes.get(node.name) is node]
        # Events compute anyway, in lazy and push graphs everybody does.
        if self.evaluator == "execution":
            return [(node, STARTED) for node in present if node.type.event is None and node.type.compute is not None]
        for node in present:
            self.touched(node)
        return []

    @property
    def running(self) -> bool:
        """Whether it is being evaluated."""
        return self._running

    @property
    def runs_in_instances(self) -> bool:
        """Whether it is evaluated for the prims that have it instead of once by itself."""
        mode = self.spec.evaluation_mode
        return mode == "instanced" or (mode == "automatic" and bool(self.instances))

    def instance(self, prim: str) -> Graph:
        """The graph as this prim has it. Raises KeyError with the nearest prim."""
        try:
            return self.instances[prim]
        except KeyError:
            near = did_you_mean(prim, self.instances)
            raise KeyError(f"graph {self.path} has no instance on {prim}{near}") from None

    def change_pipeline_stage(self, stage: PipelineStage) -> None:
        """Makes it be evaluated in another stage from the next update on."""
        if stage not in get_args(PipelineStage):
            known = ", ".join(get_args(PipelineStage))
            raise ValueError(
                f'"{stage}" is not a pipeline stage{did_you_mean(stage, get_args(PipelineStage))} ({known})'
            )
        self.pipeline_stage = stage

    def when_idle(self, action: Callable[[], None]) -> None:
        """Calls `action` once the present evaluation has ended; at once if there is none."""
        if self._running:
            self._idle.append(action)
        else:
            action()

    def resolved(self, value: Any) -> Any:
        """The value with `_OMNI_GRAPH_TARGET` replaced by the prim that has this instance."""
        return with_target(value, self.target)

    def _evaluate_instances(self, context: Context, activations: Sequence[tuple[Node | str, str]]) -> None:
        by_name = [(node if isinstance(node, str) else node.name, name) for node, name in activations]
        for instance in self.instances.values():
            instance.on_error, instance.interrupts = self.on_error, self.interrupts
            instance.excuses_lacks = self.excuses_lacks
            instance.step_limit, instance.pipeline_stage = self.step_limit, self.pipeline_stage
            instance.evaluate(context, by_name)

    def _now_idle(self) -> None:
        waiting, self._idle = self._idle, []
        for action in waiting:
            action()

    def observe(self, wrap: Callable[[Node, Compute], Compute]) -> None:
        """Puts `wrap(node, compute)` in the place of every node's compute, for tools that measure or trace.

        Raises RuntimeError during an evaluation.
        """
        if self._running:
            raise RuntimeError(f"graph {self.path} is being evaluated; observe it before or after")
        self._wraps.append(wrap)
        self._wrap((wrap,))
        if self.evaluator == "push":
            self.evaluator_state = None  # its plan holds the functions; it keeps nothing else
        for instance in self.instances.values():
            instance.observe(wrap)

    @property
    def observed(self) -> bool:
        """Whether anything was put in the place of its nodes' computes."""
        return bool(self._wraps)

    def observe_as(self, other: Graph) -> None:
        """Has its computes observed like those of another graph."""
        for wrap in other._wraps:
            self.observe(wrap)

    def take(self, fresh: Graph) -> None:
        """Becomes what an edit made of the graph; nodes, variables and instances are dealt with by `adopt`."""
        if fresh.spec.pipeline_stage != self.spec.pipeline_stage:
            self.pipeline_stage = fresh.pipeline_stage
        self.spec, self.evaluator, self.mark = fresh.spec, fresh.evaluator, fresh.mark
        self.starts, self.linked, self.written, self.ranks = fresh.starts, fresh.linked, {}, fresh.ranks
        self.reorder = None
        told = set(self.notes) if self._told else set()
        self.notes = tuple(note for note in fresh.notes if note not in told)
        self._told = False
        self._wrap(self._wraps)

    def add(self, nodes: Mapping[str, Node], starts: Mapping[Copy, None]) -> None:
        """Takes in new nodes, which come behind all others, and the copies among them."""
        for node in nodes.values():
            node.graph = self
        self.nodes.update(nodes)
        self.ranks += len(nodes)
        self.starts.update(starts)

    def _wrap(self, wraps: Sequence[Callable[[Node, Compute], Compute]]) -> None:
        for wrap in wraps:
            for node in self.nodes.values():
                if node.db._compute is not None:
                    node.db._compute = wrap(node, node.db._compute)
        for node in self.nodes.values():
            for wire in node.db._wires.values():
                wire.renew()

    def reset(self) -> None:
        """What a timeline stop does: values as authored, fresh memory, everybody awake. Compute counts go on."""
        for instance in self.instances.values():
            instance.reset()
        self.variables.reset()
        for node in self.nodes.values():
            node.reset()
        for copy in self.starts:
            copy()
        if self.evaluator_state is not None:
            self.evaluator_state.reset()

    def close(self) -> None:
        """Releases what the nodes hold; calling it twice is harmless."""
        for instance in self.instances.values():
            instance.close()
        for node in self.nodes.values():
            node.release()

    def _of(self, node: Node | str) -> Node:
        return self.node(node) if isinstance(node, str) else node

    # -- for nodes and evaluators ------------------------------------------------------------------------------------

    def sleeps(self, db: Database) -> None:
        """A node of this graph fell asleep."""
        if self.evaluator_state is not None:
            self.evaluator_state.sleeps(db)

    def wakes(self, db: Database) -> None:
        """A node of this graph ended its sleep."""
        if self.evaluator_state is not None:
            self.evaluator_state.wakes(db)

    def touched(self, node: Node) -> None:
        """A value of this node was set from outside."""
        if self.evaluator_state is not None:
            self.evaluator_state.touched(node)

    def failed(self, db: Database, error: Exception) -> None:
        """Deals with an exception of this node's compute by `on_error`. Raises ComputeError for "stop".

        What a node of a saved scene lacks is only warned of, unless somebody asked to stop at errors.
        """
        db._enabled.clear()
        message = cause_of(db, error)
        if isinstance(error, LackError) and self.excuses_lacks:
            self.context.warn("input-not-set", db.path, message)
            return
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

    graph.settle_order()
    if graph.evaluator == "execution":
        return ExecutionEvaluator(graph)
    return PushEvaluator(graph) if graph.evaluator == "push" else DirtyPushEvaluator(graph)
