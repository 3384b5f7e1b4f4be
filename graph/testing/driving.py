"""Drives graphs under test: sets values that change with the updates and triggers execution inputs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from graph.base.errors import Problem, UserError
from graph.evaluate import Activation, Graph, Node
from graph.node.context import Context

from .trace import GraphTrace
from .updates import count_updates


class Driver:
    """Sets inputs and triggers execution inputs, update by update.

    A graph's pulses are part of its first evaluation in the update, after its own events. A graph that is not evaluated
    in an update (not requested, or no frame came) is evaluated for its pulses at the update's end. Raises UserError
    with every wrong reference.
    """

    def __init__(
        self, trace: GraphTrace, inputs: Mapping[str, Any], pulses: Mapping[str, Iterable[int]], updates: int
    ) -> None:
        problems: list[Problem] = []
        self._changing: list[tuple[Node, str, Callable[[int], Any]]] = []
        self._schedule: list[tuple[Node, str, dict[int, int]]] = []
        self._due: dict[Graph, list[Activation]] = {}
        for reference, value in inputs.items():
            try:
                node, full = _input(trace, reference)
            except KeyError as error:
                problems.append(Problem(f"inputs: {error.args[0]}"))
                continue
            if callable(value):
                self._changing.append((node, full, value))
        for reference, times in pulses.items():
            try:
                self._schedule.append((*_execution_input(trace, reference), count_updates(times, updates - 1)))
            except (KeyError, TypeError, ValueError) as error:
                problems.append(Problem(f"pulses: {error.args[0]}"))
        if problems:
            raise UserError(problems)
        for graph in dict.fromkeys(node.graph for node, _, _ in self._schedule):
            self._due[graph] = []
            _pass_on(graph, self._due[graph])

    def begin(self, update: int) -> None:
        """Call it before an update: sets values that change, records what is to be triggered."""
        for node, full, value in self._changing:
            try:
                node.set(full, value(update))
            except ValueError as error:
                raise UserError(f"inputs: update {update}: {error}") from None
        for node, name, times in self._schedule:
            self._due[node.graph] += [(node, name)] * times.get(update, 0)

    def end(self) -> None:
        """Call it after an update: evaluates the graphs with remaining pulses."""
        for graph, due in self._due.items():
            if due:
                graph.evaluate(graph.context)


def _pass_on(graph: Graph, due: list[Activation]) -> None:
    """Makes the graph's evaluations include the due pulses."""
    evaluate = graph.evaluate

    def evaluate_with_pulses(context: Context, activations: Sequence[tuple[Node | str, str]] = ()) -> None:
        taken = [*due]
        due.clear()
        evaluate(context, [*activations, *taken])

    graph.evaluate = evaluate_with_pulses  # type: ignore[method-assign]


def _input(trace: GraphTrace, reference: str) -> tuple[Node, str]:
    node, full = trace.attribute(reference, "inputs")
    if node.attribute(full).is_execution:
        raise KeyError(f'"{reference}" ({node.type.id}) is an execution attribute; trigger it by pulses')
    if full.startswith("outputs:"):
        raise KeyError(f'"{reference}" ({node.type.id}) is an output; only inputs and state can be set')
    if node.connected(full):
        raise KeyError(f'"{reference}" is connected; set its source')
    return node, full


def _execution_input(trace: GraphTrace, reference: str) -> tuple[Node, str]:
    node, full = trace.attribute(reference, "inputs")
    if not full.startswith("inputs:") or not node.attribute(full).is_execution:
        raise KeyError(f'"{reference}" ({node.type.id}) is not an execution input; set it by inputs')
    return node, full.partition(":")[2]
