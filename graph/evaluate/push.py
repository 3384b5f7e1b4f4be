"""The evaluator of push graphs: every node once, upstream before downstream."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from graph.node.database import RETURN, STARTED, Database

if TYPE_CHECKING:
    from .graph import Activation, Graph
    from .node import Node


class PushEvaluator:
    """Computes every node once per evaluation, in dependency order; ties are in file order.

    Execution wires are not followed: fired outputs are only counted, and no execution input is triggered.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        nodes = sorted((n for n in graph.nodes.values() if n.type.compute is not None), key=lambda node: node.rank)
        self._plan = [(node.db, node.db._compute, node.db._push) for node in nodes]
        self._firing = [node.db for node in nodes if node.db._wires]

    def run(self, activations: Sequence[Activation]) -> None:
        """Evaluates the graph once; an activation computes its node once more, with that execution input triggered."""
        self._run_plan()
        for node, name in activations:
            node.db._active = name
            self._compute(node.db)
            node.db._active = STARTED
        for db in self._firing:
            count_fired(db)

    def _run_plan(self) -> None:
        db = None
        plan = iter(self._plan)
        while True:
            try:
                for db, compute, push in plan:
                    db.computes += 1
                    if compute(db) is not False and push is not None:
                        push()
                return
            except Exception as error:
                assert db is not None
                self._graph.failed(db, error)

    def _compute(self, db: Database) -> None:
        db.computes += 1
        try:
            if db._compute(db) is not False and db._push is not None:
                db._push()
        except Exception as error:
            self._graph.failed(db, error)

    def reset(self) -> None:
        """Nothing is kept between evaluations."""

    def sleeps(self, db: Database) -> None:
        """Every node computes in every evaluation anyway."""

    def wakes(self, db: Database) -> None:
        """Every node computes in every evaluation anyway."""

    def touched(self, node: Node) -> None:
        """Every node computes in every evaluation anyway."""


def count_fired(db: Database) -> None:
    """Counts fired outputs that are not followed."""
    for name in db._enabled:
        if name is not RETURN:
            wire = db._wires.get(name) or db._no_wire(name)
            wire.count += 1
    db._enabled.clear()
