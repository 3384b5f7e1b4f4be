"""The evaluator of action graphs: execution follows wires, data is pulled."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import repeat
from operator import length_hint
from typing import TYPE_CHECKING, Any

from graph.base import limits
from graph.node.database import RETURN, RETURNED, STARTED, Database
from graph.node.declaration import CLOSING

from .node import Node, RunawayError, upstream_data
from .wire import Step, Wire, step_to

if TYPE_CHECKING:
    from .graph import Activation, Graph

Budget = Iterator[None]
"""Counts the computes that a walk may still make. It is a `repeat`, which makes no number for each of them."""


class ExecutionEvaluator:
    """Starts with sleeping nodes, then event nodes, then activations; within each group in file order.

    Each of them starts a walk, which is followed to its end before the next one: depth first, outputs in the order in
    which they fired, targets in the order of the file's connections. Before a node computes, the data nodes upstream of
    it (those without execution attributes) compute, each once. Nodes with execution attributes are never computed on
    demand.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        nodes = graph.nodes.values()
        events = [node for node in nodes if node.type.event is not None and node.type.compute is not None]
        ordered = [node.db for node in sorted(events, key=lambda node: (node.type.event, node.index))]
        self._events = [db for db in ordered if db._node.type.phase != CLOSING]
        self._at_the_end = [db for db in ordered if db._node.type.phase == CLOSING]
        # Nodes may sleep already, because an edit creates a new evaluator.
        self._sleepers: list[Database] = [node.db for node in nodes if node.db.asleep]
        self._woken: list[Database] = []
        self._foreign: set[Graph] = set()
        self._spent = 0

    def run(self, activations: Sequence[Activation]) -> None:
        """Evaluates the graph once; when the App is about to close, only the events of closing."""
        self._share_context()
        self._spent = 0
        try:
            if self._graph.context.closing:
                for db in self._at_the_end:
                    self._walk(db, STARTED)
                return
            for db in sorted(self._sleepers, key=lambda db: db._node.index):
                if db.asleep:
                    self._walk(db, STARTED)
            for db in self._events:
                self._walk(db, STARTED)
            for node, name in activations:
                self._walk(node.db, name)
        finally:
            for db in self._woken:
                db._set_blocked(db.asleep and not self._graph.interrupts)
            self._woken.clear()

    def _share_context(self) -> None:
        """Gives data nodes of other graphs the time of the evaluation that pulls them."""
        for graph in self._foreign:
            graph.context = self._graph.context

    def reset(self) -> None:
        """Wakes all nodes."""
        self._sleepers.clear()
        self._woken.clear()

    def sleeps(self, db: Database) -> None:
        """Computes the node in every later evaluation, until it wakes."""
        db._set_blocked(not self._graph.interrupts)
        if db not in self._sleepers:
            self._sleepers.append(db)

    def wakes(self, db: Database) -> None:
        """The node ignores triggers until this evaluation ends."""
        self._sleepers.remove(db)
        self._woken.append(db)

    def touched(self, node: Node) -> None:
        """Does nothing: nodes compute when execution reaches them."""

    def _walk(self, db: Database, cause: Any) -> None:
        """Follows execution from one node to the end of every wire.

        The inner loop follows single wires without the stack; it is the hot path of an action graph.
        """
        # A wait has ended: what starts from it may lead back to the node.
        origin = db if cause is STARTED else None
        budget = self._budget()
        stack = [step_to(db, cause)]
        while True:
            try:
                while stack:
                    step = stack.pop()
                    if step[1] is RETURNED:
                        self._spend(budget)
                        budget = step[0]._frames.pop()
                    for _ in budget:
                        db, active, compute, push, enabled = step
                        if db._held:
                            if active and db._blocked:
                                db._deaf += 1
                                if db is origin and not db.asleep:
                                    self._came_back(db)
                                break
                            self._pull(db)
                        db._active = active
                        db.computes += 1
                        if compute(db) is False:
                            enabled.clear()
                            break
                        if push is not None:
                            push()
                        if not enabled:
                            break
                        name = enabled.pop()
                        if enabled:
                            enabled.append(name)
                            budget = self._branch(db, stack, budget)
                            break
                        try:
                            wire = db._wires[name]
                        except KeyError:
                            db._no_wire(name)
                        wire.count += 1
                        step = wire.only
                        if step is None:
                            stack += wire.targets
                            break
                    else:
                        raise self._overrun(step)
                self._spend(budget)
                return
            except RunawayError:
                raise
            except Exception as error:
                self._graph.failed(db, error)

    def _budget(self) -> Budget:
        """The computes that a walk, or a pass of a loop, may make."""
        return repeat(None, self._graph.step_limit)

    def _spend(self, budget: Budget) -> None:
        """Counts the computes of a finished pass or walk: loops within loops multiply."""
        self._spent += self._graph.step_limit - length_hint(budget)
        if self._spent > limits.most("graph.steps"):
            raise RunawayError(
                f"graph {self._graph.path}: its loops make more than {limits.most('graph.steps'):,} computes in update "
                f"{self._graph.context.update}; {limits.allowed('graph.steps')}"
            )

    def _branch(self, db: Database, stack: list[Step], budget: Budget) -> Budget:
        """Puts several fired outputs, or one to return from, on the stack; returns the budget to go on with.

        Each pass of a loop has a budget of its own; the present one waits until the walk returns to the node.
        """
        for name in reversed(db._enabled):
            if name is RETURN:
                if len(stack) > self._graph.step_limit:
                    raise self._runaway(db)
                db._frames.append(budget)
                stack.append(step_to(db, RETURNED))
                budget = self._budget()
                continue
            wire = db._wires.get(name) or db._no_wire(name)
            wire.count += 1
            stack += wire.targets
        db._enabled.clear()
        return budget

    def _pull(self, db: Database) -> None:
        """Computes the data nodes upstream of a node, sources first."""
        pulls = db._pulls
        if pulls is True:
            pulls = upstream_data(db._node)
            db._set_pulls(pulls)
            self._foreign.update(data._node.graph for data in pulls)
            self._foreign.discard(self._graph)
            self._share_context()
        for data in pulls:
            data.computes += 1
            try:
                if data._compute(data) is not False and data._push is not None:
                    data._push()
            except Exception as error:
                data._node.graph.failed(data, error)

    def _came_back(self, db: Database) -> None:
        """A node ended its wait, and what followed led back to it: the trigger is ignored, and the loop ends."""
        self._graph.context.warn(
            "trigger-ignored",
            db.path,
            "what follows the end of its wait leads back to it in the same update, where triggers are ignored, so the "
            "loop ends; lead it through SendCustomEvent and OnCustomEvent, which go on in the next update",
        )

    def _overrun(self, step: Step) -> RunawayError:
        """The error of a walk or pass that has used up its budget before this step."""
        db, cause, *_ = step
        return self._endless(db) if cause is RETURNED and not _leads_back(db) else self._runaway(db)

    def _endless(self, db: Database) -> RunawayError:
        """The error of a loop node that is returned to too often."""
        return RunawayError(
            f"graph {self._graph.path}: loop {db._node.name} makes more than {self._graph.step_limit} passes in update "
            f"{self._graph.context.update}; give it fewer, or spread them over updates"
        )

    def _runaway(self, db: Database) -> RunawayError:
        """The error of a runaway walk; names its nodes by following the busiest wires until a node repeats."""
        names: dict[str, None] = {}
        leading: list[Wire] = []
        while db._node.name not in names:
            names[db._node.name] = None
            leading = [wire for wire in db._wires.values() if wire.targets]
            if not leading:
                break
            db = max(leading, key=lambda wire: wire.count).targets[-1][0]
        listed = list(names)
        if leading:
            listed = [*listed[listed.index(db._node.name) :], db._node.name]
        shown = " -> ".join(listed if len(listed) <= 12 else [*listed[:6], "...", *listed[-5:]])
        return RunawayError(
            f"graph {self._graph.path}: execution goes round without end ({shown}): {self._graph.step_limit} steps in "
            f"update {self._graph.context.update}; lead the loop through SendCustomEvent and OnCustomEvent, which go "
            "on in the next update, or use ForLoop"
        )


def _leads_back(db: Database) -> bool:
    """Whether the wires that were followed lead from the node back to it."""
    seen: set[Database] = set()
    pending = [db]
    while pending:
        for wire in pending.pop()._wires.values():
            reached = {step[0] for step in wire.targets} - seen if wire.count else set()
            if db in reached:
                return True
            seen |= reached
            pending += reached
    return False
