"""The evaluator of action graphs: control follows execution wires, data is pulled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graph.db import RETURNED, STARTED, Database

from .errors import RunawayError
from .node import Node, upstream_data

if TYPE_CHECKING:
    from .graph import Activation, Graph

Step = tuple[Database, Any]
"""A node to compute and what makes it: an execution input's name, STARTED or RETURNED."""


class ExecutionEvaluator:
    """Sleeping nodes first, then event nodes, then activations; within each group in file order.

    Each of them starts a walk that is followed to its end before the next: depth first, outputs in the order they were
    fired, targets in the order of the file's connections. Before a node computes, the data nodes (those without
    execution attributes) upstream of it do, each once; nodes with execution attributes are never computed on demand.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        nodes = graph.nodes.values()
        events = [node for node in nodes if node.type.event is not None and node.type.compute is not None]
        self._events = [node.db for node in sorted(events, key=lambda node: (node.type.event, node.index))]
        self._sleepers: list[Database] = []
        self._woken: list[Database] = []

    def run(self, activations: Sequence[Activation]) -> None:
        """Evaluates the graph once."""
        try:
            for db in sorted(self._sleepers, key=lambda db: db._node.index):
                if db.asleep:
                    self._walk([(db, STARTED)])
            for db in self._events:
                self._walk([(db, STARTED)])
            for node, name in activations:
                self._walk([(node.db, name)])
        finally:
            for db in self._woken:
                db._blocked = db.asleep
            self._woken.clear()

    def reset(self) -> None:
        """Forgets who sleeps."""
        self._sleepers.clear()
        self._woken.clear()

    def sleeps(self, db: Database) -> None:
        """Computes the node in every later evaluation, until it wakes."""
        db._blocked = not self._graph.interrupts
        if db not in self._sleepers:
            self._sleepers.append(db)

    def wakes(self, db: Database) -> None:
        """The node stays deaf until this evaluation ends."""
        self._sleepers.remove(db)
        self._woken.append(db)

    def touched(self, node: Node) -> None:
        """Nothing to do: nodes compute when control reaches them."""

    def _walk(self, stack: list[Step]) -> None:
        limit = self._graph.step_limit
        steps = 0
        db = stack[-1][0]
        while True:
            try:
                while stack:
                    db, active = stack.pop()
                    if active:
                        if db._blocked:
                            continue
                    elif active is RETURNED:
                        steps = db._frames.pop()
                    steps += 1
                    if steps > limit:
                        raise RunawayError
                    if db._pulls != ():
                        self._pull(db)
                    db._active = active
                    db.computes += 1
                    done = db._compute(db)
                    enabled = db._enabled
                    if done is False:
                        if enabled:
                            enabled.clear()
                            db._return_at = 0
                        continue
                    if db._push is not None:
                        db._push()
                    if enabled:
                        if len(enabled) == 1 and not db._return_at:
                            wire = enabled.pop()
                            wire.count += 1
                            stack += wire.targets
                        else:
                            steps = self._branch(db, stack, steps)
                return
            except RunawayError:
                raise self._runaway(db, stack) from None
            except Exception as error:
                self._graph.failed(db, error)

    def _branch(self, db: Database, stack: list[Step], steps: int) -> int:
        """Puts several fired outputs, or one to return from, on the stack; gives the step count to go on with.

        A loop's pass counts its own steps: the count so far waits until the walk returns to the node.
        """
        enabled = db._enabled
        return_at = db._return_at
        for position in range(len(enabled), 0, -1):
            if position == return_at:
                db._frames.append(steps)
                stack.append((db, RETURNED))
                steps = 0
            wire = enabled[position - 1]
            wire.count += 1
            stack += wire.targets
        enabled.clear()
        db._return_at = 0
        return steps

    def _pull(self, db: Database) -> None:
        """Computes the data nodes upstream of a node, upstream before downstream."""
        pulls = db._pulls
        if pulls is None:
            pulls = db._pulls = upstream_data(db._node)
        for data in pulls:
            data.computes += 1
            try:
                if data._compute(data) is not False and data._push is not None:
                    data._push()
            except Exception as error:
                data._node.graph.context = self._graph.context
                data._node.graph.failed(data, error)

    def _runaway(self, db: Database, stack: list[Step]) -> RunawayError:
        """Names the nodes that go round, by walking on until one comes again."""
        round_: list[str] = []
        seen: set[Database] = set()
        while db not in seen and len(round_) < 50:
            seen.add(db)
            round_.append(db._node.name)
            fired = [wire for wire in db._wires.values() if wire.targets and wire.count]
            busiest = max(fired, key=lambda wire: wire.count, default=None)
            if busiest is None:
                break
            db = busiest.targets[-1][0]
        if db._node.name in round_:
            round_ = [*round_[round_.index(db._node.name) :], db._node.name]
        stack.clear()
        return RunawayError(
            f"graph {self._graph.path}: execution goes round without end ({' -> '.join(round_)}): "
            f"{self._graph.step_limit} steps in update {self._graph.context.update}; "
            "lead the loop through a latent node such as Delay or Countdown, or use ForLoop"
        )
