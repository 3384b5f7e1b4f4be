"""Evaluates graphs on request."""

from __future__ import annotations

from collections.abc import Sequence

from graph.editing.errors import OmniGraphError
from graph.editing.graph_set import GraphSet
from graph.evaluate import Graph

_RENDERED = ("pre_render", "post_render")


def evaluate_all(graphs: GraphSet, chosen: Sequence[Graph] | None) -> None:
    """Evaluates the chosen graphs once, in that order; None means all graphs of the simulation stage, by path.

    Raises OmniGraphError, with nothing evaluated, if one belongs to a render stage.
    """
    if chosen is None:
        chosen = [graph for _, graph in sorted(graphs.graphs.items()) if graph.pipeline_stage == "simulation"]
    for graph in chosen:
        if graph.pipeline_stage in _RENDERED:
            raise OmniGraphError(
                f"graph {graph.path} is of the {graph.pipeline_stage} stage; the renderer evaluates it, not a script"
            )
    if graphs.app is not None:
        graphs.context.follow(graphs.app)
    else:
        graphs.context.advance()
    for graph in chosen:
        graph.evaluate(graphs.context)
