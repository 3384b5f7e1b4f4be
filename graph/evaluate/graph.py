"""A compiled graph: its nodes, and the evaluation by its evaluator."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, Protocol, get_args

from graph.base.suggest import did_you_mean
from graph.node.context import Context
from graph.node.database import STARTED, Database, LackError
from graph.node.declaration import Compute
from graph.node.variables import Variables
from graph.spec.file_spec import Evaluator, GraphSpec, PipelineStage

from .causes import cause_of
from .instances import with_target
from .node import ComputeError, Node, StaleNode
from .omnigraph_names import FamiliarGraph
from .wire import Copy

Excuses = Literal["nothing", "waiting", "lacks"]
"""Which missing inputs are warnings: none; connected ones whose source has no value yet; also those not in the file."""
Activation = tuple[Node, str]
"""A node and the execution input to trigger."""


class EvaluatorProtocol(Protocol):
    """One way to evaluate a graph; it is also notified of sleeping and of changed nodes."""

    def run(self, activations: Sequence[Activation]) -> None:
        """Evaluates the graph once."""

    def reset(self) -> None:
        """Drops what it kept between evaluations."""

    def sleeps(self, db: Database) -> None:
        """Called when a node falls asleep."""

    def wakes(self, db: Database) -> None:
        """Called when a node wakes up."""

    def touched(self, node: Node) -> None:
        """Called when a value of a node was set from outside."""


class Graph(FamiliarGraph):
    """One graph, ready to run. Made by `graph.plan.compile_graphs`.

    evaluator_of: makes its evaluator, at the first evaluation.

    on_error: "stop" (a failing node ends the run) or "continue" (a warning is given, and the node counts as having
    nothing to do). step_limit: how many nodes one walk may compute (in loops made by `fire_and_return`, each pass is
    counted by itself); a longer walk is reported as a runaway. interrupts: whether a trigger that reaches a sleeping
    node starts it again instead of being ignored.
    """

    def __init__(
        self,
        spec: GraphSpec,
        variables: Variables,
        evaluator_of: Callable[[Graph], EvaluatorProtocol],
        target: str = "",
    ) -> None:
        self.compiled_spec = spec
        """What it was compiled from; values set since are in `written`."""
        self.path = spec.path
        self.evaluator: Evaluator = spec.evaluator
        self.pipeline_stage: PipelineStage = spec.pipeline_stage
        self.variables = variables
        self.mark = spec.mark
        self.members: dict[str, Node] = {}
        """Its nodes, whether edits wait to be compiled or not."""
        self.stale: Callable[[str], None] | None = None
        """Compiles the edits that wait of the graph with this path; None if no edit waits."""
        self._stale_nodes: list[Node] = []
        self.context = Context()
        self.on_error: Literal["stop", "continue"] = "stop"
        self.excuses: Excuses = "lacks" if spec.excuses_lacks else "waiting"
        self.step_limit = 1_000_000
        self.interrupts = False
        self.evaluations = 0
        self.notes: tuple[tuple[str, str, str], ...] = ()
        """Warnings of the compiler (code, where, message); given to the context at the first evaluation."""
        self.starts: dict[Copy, None] = {}
        """The copies of every data connection that begins or ends in this graph."""
        self.linked: set[str] = set()
        """Paths of the graphs with which it exchanges data."""
        self.written: dict[tuple[str, str], Any] = {}
        """Values set since it was compiled, by node name and full attribute name."""
        self.asked: set[tuple[str, str]] = set()
        """Outputs that a program reads, by node name and full name; they count as consumed."""
        self.disabled = False
        """Whether evaluations of it do nothing."""
        self.disabled_nodes: set[str] = set()
        """Names of the nodes whose compute does nothing; see `disable_node`."""
        self.target = target or spec.path
        """The prim that `_OMNI_GRAPH_TARGET` stands for: the prim of this instance, else the graph itself."""
        self.instances: dict[str, Graph] = {}
        """A copy of the graph for each prim that has it, with its own values and memory."""
        self._wraps: list[Callable[[Node, Compute], Compute]] = []
        self._idle: list[Callable[[], None]] = []
        self._requested: dict[Node, None] = {}
        self._told = False
        self._evaluator_of = evaluator_of
        self.evaluator_state: EvaluatorProtocol | None = None
        """The evaluator; made at the first evaluation."""
        self._running = False

    def __repr__(self) -> str:
        return f"<{self.evaluator} graph {self.path}, {len(self.nodes)} nodes>"

    @property
    def nodes(self) -> dict[str, Node]:
        """Its nodes by name, compiled, in file order."""
        self.settle()
        return self.members

    @property
    def spec(self) -> GraphSpec:
        """What it is compiled from, with all edits; values set since are in `written`."""
        self.settle()
        return self.compiled_spec

    def settle(self) -> None:
        """Compiles the edits that wait. Raises UserError if they do not fit together."""
        if self.stale is not None:
            self.stale(self.path)

    def outdate(self, nodes: Iterable[Node], compile_edits: Callable[[str], None]) -> None:
        """Records an edit that concerns these nodes; what they read, and every evaluation, compiles it first."""
        for node in nodes:
            node.__class__ = StaleNode
            self._stale_nodes.append(node)
        self.stale = compile_edits

    def refresh(self) -> list[Node]:
        """Ends what `outdate` began, because the caller compiles the edits; returns the nodes that were outdated."""
        nodes, self._stale_nodes, self.stale = self._stale_nodes, [], None
        for node in nodes:
            node.__class__ = Node
        return nodes

    def drop(self, name: str) -> None:
        """Removes a node; what was connected to it is outdated."""
        node = self.members.pop(name)
        node.__class__ = Node
        node.release()

    def node(self, name: str) -> Node:
        """The node with that name or path. Raises KeyError with the nearest name."""
        name = name.removeprefix(f"{self.path}/")
        try:
            return self.nodes[name]
        except KeyError:
            raise KeyError(f'graph {self.path} has no node "{name}"{did_you_mean(name, self.nodes)}') from None

    def to_networkx(self) -> Any:
        """This graph as a `networkx.MultiDiGraph`, for your own analyses; see `graph.evaluate.links.to_networkx`."""
        from .links import to_networkx

        return to_networkx([self])

    def evaluate(self, context: Context, activations: Sequence[tuple[Node | str, str]] = ()) -> None:
        """Evaluates once. Execution graphs: sleeping nodes, then events, then `activations` in the given order.

        A graph with instances is evaluated once for each prim, in their order, and not by itself. Edits by its own
        nodes take effect when the evaluation has ended. Raises ComputeError when a node fails, RunawayError when a walk
        does not end, and RuntimeError when one of its own nodes evaluates the graph.
        """
        if self._running:
            raise RuntimeError(f"graph {self.path} is being evaluated already; a node cannot evaluate its own graph")
        self.settle()
        self.context = context
        if self.disabled:
            return
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
                    self.evaluator_state = self._evaluator_of(self)
                started = [(self._of(node), name) for node, name in activations] if activations else []
                if self._requested:
                    started += self._take_requested()
                self.evaluator_state.run(started)
        finally:
            self._running = False
            if self._idle:
                self._now_idle()

    def request(self, node: Node) -> None:
        """Makes a node compute in the next evaluation, after events and activations, at most once."""
        self._requested[node] = None

    def _take_requested(self) -> list[tuple[Node, Any]]:
        requested, self._requested = self._requested, {}
        present = [node for node in requested if self.nodes.get(node.name) is node]
        # Events compute anyway; in lazy and push graphs every node is reached.
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
        """Whether it is evaluated once for each prim that has it, instead of once by itself."""
        mode = self.spec.evaluation_mode
        return mode == "instanced" or (mode == "automatic" and bool(self.instances))

    def instance(self, prim: str) -> Graph:
        """The instance of a prim. Raises KeyError with the nearest prim."""
        try:
            return self.instances[prim]
        except KeyError:
            near = did_you_mean(prim, self.instances)
            raise KeyError(f"graph {self.path} has no instance on {prim}{near}") from None

    def change_pipeline_stage(self, stage: PipelineStage) -> None:
        """Moves the graph to another pipeline stage, from the next update on."""
        if stage not in get_args(PipelineStage):
            known = ", ".join(get_args(PipelineStage))
            raise ValueError(
                f'"{stage}" is not a pipeline stage{did_you_mean(stage, get_args(PipelineStage))} ({known})'
            )
        self.pipeline_stage = stage

    def when_idle(self, action: Callable[[], None]) -> None:
        """Calls `action` when the present evaluation has ended; at once if none is running."""
        if self._running:
            self._idle.append(action)
        else:
            action()

    def resolved(self, value: Any) -> Any:
        """The value with `_OMNI_GRAPH_TARGET` replaced by the prim of this instance."""
        return with_target(value, self.target)

    def _evaluate_instances(self, context: Context, activations: Sequence[tuple[Node | str, str]]) -> None:
        by_name = [(node if isinstance(node, str) else node.name, name) for node, name in activations]
        for instance in self.instances.values():
            instance.on_error, instance.interrupts = self.on_error, self.interrupts
            instance.excuses = self.excuses
            instance.step_limit, instance.pipeline_stage = self.step_limit, self.pipeline_stage
            instance.evaluate(context, by_name)

    def _now_idle(self) -> None:
        waiting, self._idle = self._idle, []
        for action in waiting:
            action()

    def observe(self, wrap: Callable[[Node, Compute], Compute]) -> None:
        """Replaces every node's compute by `wrap(node, compute)`, for tools that measure or trace.

        Raises RuntimeError during an evaluation.
        """
        if self._running:
            raise RuntimeError(f"graph {self.path} is being evaluated; observe it before or after")
        self._wraps.append(wrap)
        self._wrap((wrap,))
        if self.evaluator == "push":
            self.evaluator_state = None  # its plan holds the functions, and nothing else that must be kept
        for instance in self.instances.values():
            instance.observe(wrap)

    def disable_node(self, name: str, disabled: bool) -> None:
        """Makes the compute of a node do nothing, or work again; edits of the graph do not change that."""
        names = self.disabled_nodes
        if not names and disabled:
            self.observe(lambda node, compute: lambda db: False if node.name in names else compute(db))
        (names.add if disabled else names.discard)(name)

    @property
    def observed(self) -> bool:
        """Whether any tool wraps the computes of its nodes."""
        return bool(self._wraps)

    def observe_as(self, other: Graph) -> None:
        """Wraps its computes like those of another graph."""
        for wrap in other._wraps:
            self.observe(wrap)

    def take(self, fresh: Graph) -> None:
        """Takes over the form of an edited graph; `adopt` handles nodes, variables and instances."""
        if fresh.spec.pipeline_stage != self.compiled_spec.pipeline_stage:
            self.pipeline_stage = fresh.pipeline_stage
        self.compiled_spec, self.evaluator, self.mark = fresh.compiled_spec, fresh.evaluator, fresh.mark
        self.starts, self.linked, self.written = fresh.starts, fresh.linked, {}
        told = set(self.notes) if self._told else set()
        self.notes = tuple(note for note in fresh.notes if note not in told)
        self._told = False
        if self._wraps:
            self._wrap(self._wraps)

    def _wrap(self, wraps: Sequence[Callable[[Node, Compute], Compute]]) -> None:
        for wrap in wraps:
            for node in self.nodes.values():
                if node.db._compute is not None:
                    node.db._compute = wrap(node, node.db._compute)
        for node in self.nodes.values():
            for wire in node.db._wires.values():
                wire.renew()

    def reset(self, *, clear_commands: bool = False) -> None:
        """What a timeline stop does: authored values, new memory, all nodes awake. Compute counts continue.

        clear_commands: inputs of the role "command" become zero or empty.
        """
        self.settle()
        for instance in self.instances.values():
            instance.reset(clear_commands=clear_commands)
        self.variables.reset()
        for node in self.nodes.values():
            node.reset()
            if clear_commands:
                node.clear(node.type.inputs_as("command"))
        for copy in self.starts:
            copy()
        if self.evaluator_state is not None:
            self.evaluator_state.reset()

    def close(self) -> None:
        """Releases what the nodes hold; calling it twice is harmless."""
        for instance in self.instances.values():
            instance.close()
        stale, nodes = self.stale, self.refresh()
        for node in self.members.values():
            node.release()
        if stale is not None:
            self.outdate(nodes, stale)

    def _of(self, node: Node | str) -> Node:
        return self.node(node) if isinstance(node, str) else node

    # -- for nodes and evaluators ------------------------------------------------------------------------------------

    def sleeps(self, db: Database) -> None:
        """Called when a node of this graph falls asleep."""
        if self.evaluator_state is not None:
            self.evaluator_state.sleeps(db)

    def wakes(self, db: Database) -> None:
        """Called when a node of this graph wakes up."""
        if self.evaluator_state is not None:
            self.evaluator_state.wakes(db)

    def touched(self, node: Node) -> None:
        """Called when a value of this node was set from outside."""
        self.settle()
        if self.evaluator_state is not None:
            self.evaluator_state.touched(node)

    def failed(self, db: Database, error: Exception) -> None:
        """Handles an exception of this node's compute according to `on_error`. Raises ComputeError for "stop".

        Unless the user asked to stop at errors, something missing is only a warning in a saved scene, and so is a
        needed input whose source has given nothing yet.
        """
        db._enabled.clear()
        message = cause_of(db, error)
        if isinstance(error, LackError) and self._excused(db._node):
            self.context.warn("input-not-set", db.path, message)
            return
        if self.on_error == "stop":
            raise ComputeError(db._node, self.context.update, message) from error
        self.context.warn("compute-failed", db.path, message)

    def _excused(self, node: Node) -> bool:
        if self.excuses != "waiting":
            return self.excuses == "lacks"
        return any(node.connected(name) for group in node.empty_needs() for name in group)


def by_path(graphs: Sequence[Graph]) -> Mapping[str, Graph]:
    """The graphs by path, in order."""
    return {graph.path: graph for graph in graphs}


def evaluator_of(graph: Graph) -> EvaluatorProtocol:
    """A new evaluator for a graph."""
    if graph.evaluator == "execution":
        from .execution import ExecutionEvaluator

        return ExecutionEvaluator(graph)
    if graph.evaluator == "push":
        from .push import PushEvaluator

        return PushEvaluator(graph)
    from .dirty import DirtyPushEvaluator

    return DirtyPushEvaluator(graph)
