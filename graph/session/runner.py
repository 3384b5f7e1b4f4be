"""Evaluates an App's graphs in the phases of its updates."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from graph.base.records import dataclass
from graph.editing.graph_set import GraphSet, bind, bound_to, unbind
from graph.node.context import Context
from graph.node.declaration import CLOSING

if TYPE_CHECKING:
    from graph.evaluate import Graph, Node
    from graph.node.context import Scripts
    from graph.sim.app import App

OnError = Literal["stop", "continue"]

INTERRUPTS_OFF = "/ext/omni.graph.action/disableInterrupts"
"""Setting: whether a trigger that reaches a sleeping node is ignored."""
STOP_CLEARS_COMMANDS = "/tickgraph/stopClearsCommands"
"""Setting: whether a stop clears the inputs of the role "command"."""

Entry = tuple["Node", str, str]
"""A node that new frames start: node, triggered execution input, input that names the render product."""

STARTS = ("OmniGraph Start Play", "Simulation Start Play", "Animation Start Play")
STOPS = ("OmniGraph Stop Play", "Simulation Stop Play", "Animation Stop Play")


@dataclass(frozen=True, slots=True)
class _Stages:
    """The graphs of each pipeline stage, in order."""

    every_update: tuple[Graph, ...]
    after_frames: tuple[tuple[Graph, tuple[Entry, ...]], ...]
    demanded: dict[str, list[Graph]]
    """On-demand graphs by the phase of their events."""

    @classmethod
    def of(cls, graphs: Iterable[Graph]) -> _Stages:
        """The graphs grouped by their present stages."""
        of_stage: dict[str, list[Graph]] = {}
        for graph in graphs:
            of_stage.setdefault(graph.pipeline_stage, []).append(graph)
        demanded: dict[str, list[Graph]] = {}
        for graph in of_stage.get("on_demand", ()):
            for phase in dict.fromkeys(node.type.phase for node in graph.nodes.values()):
                demanded.setdefault(phase, []).append(graph)
        demanded.pop("", None)
        demanded.pop(CLOSING, None)
        return cls(
            (*of_stage.get("simulation", ()), *of_stage.get("pre_render", ())),
            tuple((graph, tuple(frame_entries(graph))) for graph in of_stage.get("post_render", ())),
            demanded,
        )


class GraphRunner:
    """Binds graphs to an App: each is evaluated in the phase of its stage, in file order; a stop resets all nodes.

    Graphs may be added, edited and moved to another stage at any time (see `graph.Controller`); each update starts with
    their state at that moment. `on_error`: what a node that raises does to the run. None: as the settings say, and
    something missing in a saved scene does not end the run. `asked`: a program may read any output at any time.
    """

    def __init__(
        self,
        app: App,
        graphs: Sequence[Graph],
        *,
        on_error: OnError | None = None,
        scripts: Scripts = "refuse",
        asked: bool = False,
    ) -> None:
        self.graphs = {graph.path: graph for graph in graphs}
        self._app = app
        self._on_error = on_error or _on_error(app)
        self._excuses_lacks = on_error != "stop"
        self._context = Context(app=app, warn=app.warn, scripts=scripts, asked=asked)
        self.set = GraphSet(self.graphs, context=self._context, app=app, prepare=self._prepare)
        bind(app, self.set)
        for graph in graphs:
            self._prepare(graph)
        import numpy as np

        # Values that are not numbers are carried as IEEE 754 says; NumPy's lines about them name no node.
        self._quiet: Any = np.errstate(all="ignore")
        self._key: tuple[Any, ...] = ()
        self._stages = _Stages.of(())
        self._in_phases: list[Callable[[], None]] = []
        self._instance_prims()
        self._regroup()
        self._unsubscribe = [
            app.on("timeline_state", self._regroup),
            app.on("simulation_graphs", self._quiet(self._run_update)),
            app.on("post_render_graphs", self._quiet(self._run_frames)),
            app.on("play", self._played),
            app.on("stop", self._reset),
            app.on("stage_closing", self.set.clear),
            app.on("closing", self._quiet(self._close_down)),
            app.on("close", self.close),
            app.settings.subscribe(INTERRUPTS_OFF, self._set_interrupts),
        ]

    @property
    def events(self) -> Any:
        """The event bus of these graphs, by which scripts send events to their nodes."""
        return self._context.events

    def close(self) -> None:
        """Releases what the nodes hold and unsubscribes from the App's phases; calling it twice is harmless."""
        while self._unsubscribe:
            self._unsubscribe.pop()()
        while self._in_phases:
            self._in_phases.pop()()
        for graph in self.graphs.values():
            graph.close()
        unbind(self._app, self.set)
        self.set.close()

    def _prepare(self, graph: Graph) -> None:
        graph.context, graph.on_error = self._context, self._on_error
        if not self._excuses_lacks:
            graph.excuses = "nothing"
        graph.interrupts = not self._app.settings.get(INTERRUPTS_OFF, True)

    def _set_interrupts(self, off: Any) -> None:
        for graph in self.graphs.values():
            graph.interrupts = not off

    def _regroup(self) -> None:
        """Updates the groups after edits and changes of stage."""
        key = tuple([(graph, graph.pipeline_stage, id(graph.nodes)) for graph in self.graphs.values()])
        if key == self._key:
            return
        self._key = key
        self._stages = _Stages.of(self.graphs.values())
        while self._in_phases:
            self._in_phases.pop()()
        for phase, asking in self._stages.demanded.items():
            self._in_phases.append(self._app.on(phase, self._quiet(partial(self._run_on_demand, asking))))

    def _run_update(self) -> None:
        self._context.follow(self._app)
        for graph in self._stages.every_update:
            graph.evaluate(self._context)
        for _, entries in self._stages.after_frames:
            for node, *_ in entries:
                node.prepare()

    def _run_on_demand(self, graphs: Iterable[Graph]) -> None:
        self._context.follow(self._app)
        for graph in graphs:
            graph.evaluate(self._context)

    def _run_frames(self) -> None:
        """Runs post-render graphs: once for each frame that starts nodes of them; without such nodes, for any frame."""
        new = self._app.rendering.new_frames
        for product in new:
            for graph, entries in self._stages.after_frames:
                activations = [(node, port) for node, port, name in entries if node.get(name) == product.path]
                if activations:
                    self._evaluate_at(graph, product.frame.reference, activations)
        for graph, entries in self._stages.after_frames if new else ():
            if not entries and runs_by_itself(graph):
                self._evaluate_at(graph, max(product.frame.reference for product in new))

    def _evaluate_at(self, graph: Graph, frame_time: Fraction, activations: Sequence[tuple[Node, str]] = ()) -> None:
        """Evaluates a graph for a frame of this time [s]."""
        self._context.frame_time = frame_time
        try:
            graph.evaluate(self._context, activations)
        finally:
            self._context.frame_time = None

    def _played(self) -> None:
        self._instance_prims()
        self._regroup()
        for name in STARTS:
            self.events.send(f"stage:{name}", update=self._context.update)

    def _reset(self) -> None:
        clear = bool(self._app.settings.get(STOP_CLEARS_COMMANDS))
        for graph in self.graphs.values():
            graph.reset(clear_commands=clear)
        self.events.clear()
        for name in STOPS:
            self.events.send(f"stage:{name}", update=self._context.update)

    def _close_down(self) -> None:
        """Walks once from the events of closing; a graph that is running now is left out."""
        self._context.follow(self._app)
        self._context.closing = True
        try:
            for graph in self.graphs.values():
                has_walk = any(node.type.phase == CLOSING for node in graph.nodes.values())
                if has_walk and graph.evaluator == "execution" and not graph.running:
                    graph.evaluate(self._context)
        finally:
            self._context.closing = False

    def _instance_prims(self) -> None:
        """Gives each graph an instance for every prim of the stage that has it."""
        if not self.graphs:
            return
        from graph.usd_files.instances import instances_on

        users = instances_on(self._app.stage)
        for path in list(self.graphs):
            spec = self.set.current_spec(path)
            instances = {
                prim: {name: value for name, value in given.items() if name in spec.variables}
                for prim, given in users.get(path, {}).items()
            }
            if instances and instances != spec.instances:
                self.set.apply([replace(spec, instances=instances)], {})


def _on_error(app: App) -> OnError:
    """What a node that raises does to the run, by the App's settings."""
    from graph.sim.settings import NODE_ERRORS_STOP

    return "stop" if app.settings.get(NODE_ERRORS_STOP, True) else "continue"


def frame_entries(graph: Graph) -> Iterable[Entry]:
    """The nodes that a new frame of their render product starts: their first execution input is unconnected."""
    for node in graph.nodes.values():
        products = node.type.inputs_as("product")
        if not products:
            continue
        for name, attribute in node.type.inputs.items():
            if attribute.is_execution and not node.connected(name):
                yield node, name, products[0]
                break


def runs_by_itself(graph: Graph) -> bool:
    """Whether an evaluation without a trigger computes anything: events in an execution graph, any node in others."""
    return graph.evaluator != "execution" or any(
        node.type.event is not None and node.type.phase != CLOSING for node in graph.nodes.values()
    )


def graphs_of(app: App) -> GraphSet:
    """The set of an App's graphs; an App without one gets an empty set, evaluated in its phases."""
    return bound_to(app) or GraphRunner(app, []).set
