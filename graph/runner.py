"""Evaluates an App's graphs in the phases of its updates."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Literal

from .context import Context

if TYPE_CHECKING:
    from graph.sim import App

    from .evaluate import Graph, Node

OnError = Literal["stop", "continue"]

# A node of a post-render graph is started by a new frame of the product that its `renderProductPath` names.
PRODUCT_INPUT = "renderProductPath"


class GraphRunner:
    """Binds graphs to an App: who is evaluated in which phase, in file order; all node state resets on stop."""

    def __init__(self, app: App, graphs: Sequence[Graph], *, on_error: OnError = "stop") -> None:
        self.graphs = {graph.path: graph for graph in graphs}
        self._app = app
        self._context = Context(app=app, warn=app.warn)
        for graph in graphs:
            graph.context, graph.on_error = self._context, on_error
        of_stage: dict[str, list[Graph]] = {}
        for graph in graphs:
            of_stage.setdefault(graph.pipeline_stage, []).append(graph)
        self._every_update = [*of_stage.get("simulation", ()), *of_stage.get("pre_render", ())]
        self._after_frames = [(graph, list(_frame_entries(graph))) for graph in of_stage.get("post_render", ())]
        demanded: dict[str, list[Graph]] = {}
        for graph in of_stage.get("on_demand", ()):
            for phase in dict.fromkeys(node.type.phase for node in graph.nodes.values()):
                demanded.setdefault(phase, []).append(graph)
        demanded.pop("", None)
        self._unsubscribe: list[Callable[[], None]] = []
        for phase, asking in demanded.items():
            self._on(phase, partial(self._run_on_demand, asking), when=asking)
        self._on("simulation_graphs", self._run_update, when=graphs)
        self._on("post_render_graphs", self._run_frames, when=self._after_frames)
        self._on("stop", self._reset, when=graphs)
        self._on("close", self.close, when=graphs)

    def close(self) -> None:
        """Releases what the nodes hold and leaves the App's phases; calling it twice is harmless."""
        while self._unsubscribe:
            self._unsubscribe.pop()()
        for graph in self.graphs.values():
            graph.close()

    def _on(self, phase: str, callback: Callable[[], None], when: Iterable[object]) -> None:
        if when:
            self._unsubscribe.append(self._app.on(phase, callback))

    def _run_update(self) -> None:
        self._context.follow(self._app)
        for graph in self._every_update:
            graph.evaluate(self._context)
        for _, entries in self._after_frames:
            for node, _ in entries:
                node.prepare()

    def _run_on_demand(self, graphs: Iterable[Graph]) -> None:
        self._context.follow(self._app)
        for graph in graphs:
            graph.evaluate(self._context)

    def _run_frames(self) -> None:
        for product in self._app.rendering.new_frames:
            for graph, entries in self._after_frames:
                activations = [(node, port) for node, port in entries if node.get(PRODUCT_INPUT) == product.path]
                if activations:
                    graph.evaluate(self._context, activations)

    def _reset(self) -> None:
        for graph in self.graphs.values():
            graph.reset()


def _frame_entries(graph: Graph) -> Iterable[tuple[Node, str]]:
    """The nodes that a new frame starts: they name a product and their execution input is not wired."""
    for node in graph.nodes.values():
        if PRODUCT_INPUT not in node.type.inputs:
            continue
        for name, attribute in node.type.inputs.items():
            if attribute.type == "execution" and not node.connected(name):
                yield node, name
                break
