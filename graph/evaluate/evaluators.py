"""The evaluators of graphs, by their names in graph files."""

from __future__ import annotations

from .graph import EvaluatorProtocol, Graph


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
