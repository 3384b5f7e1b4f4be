"""The evaluator of dirty_push (lazy) graphs: like push, but only nodes whose inputs changed."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from graph.node.database import STARTED, Database

from .push import count_fired

if TYPE_CHECKING:
    from .graph import Activation, Graph
    from .node import Node

_PLAIN = (bool, int, float, str)


class DirtyPushEvaluator:
    """Computes, in dependency order, the nodes whose inputs changed since they last computed.

    The first evaluation computes all nodes. A later one computes the nodes that were set to another value from outside
    or requested (`Node.request_compute`), those that read more than their inputs (`NodeType.always_dirty`), and the
    readers of outputs that changed. Plain values are compared; an array, list or bundle counts as changed whenever a
    node writes it.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        computing = (node for node in graph.nodes.values() if node.type.compute is not None)
        self._nodes = sorted(computing, key=lambda node: node.rank)
        self._always = [node for node in self._nodes if node.type.always_dirty]
        self._queue: list[tuple[int, Node]] = []
        self._queued: set[Node] = set()
        self._seen: dict[Node, tuple[Any, ...]] = {}
        self.reset()

    def run(self, activations: Sequence[Activation]) -> None:
        """Evaluates the graph once; an activation computes its node with that execution input triggered."""
        for node in self._always:
            self._mark(node)
        queue = self._queue
        while queue:
            _, node = heapq.heappop(queue)
            self._queued.discard(node)
            self._compute(node)
        for node, name in activations:
            node.db._active = name
            self._compute(node)
            node.db._active = STARTED
            while queue:
                _, behind = heapq.heappop(queue)
                self._queued.discard(behind)
                self._compute(behind)

    def reset(self) -> None:
        """Everything will be computed again."""
        self._seen.clear()
        self._queue = [(node.rank, node) for node in self._nodes]
        self._queued = set(self._nodes)

    def carry(self, before: DirtyPushEvaluator, changed: Iterable[Node]) -> None:
        """Continues the work of another evaluator of the graph, after an edit that concerned the `changed` nodes."""
        present = set(self._nodes)
        self._seen = {node: values for node, values in before._seen.items() if node in present}
        self._queue, self._queued = [], set()
        for node in (*before._queued, *changed):
            # A constant never computes, but its readers do.
            for one in (node,) if node.type.compute is not None else node.readers:
                if one in present:
                    self._mark(one)

    def touched(self, node: Node) -> None:
        """A node was set from outside: it and the readers of its inputs will be computed."""
        self._mark(node)
        for reader in node.readers:
            self._mark(reader)

    def sleeps(self, db: Database) -> None:
        """Nodes with execution attributes compute in every evaluation anyway."""

    def wakes(self, db: Database) -> None:
        """Nodes with execution attributes compute in every evaluation anyway."""

    def _mark(self, node: Node) -> None:
        if node.graph is not self._graph:
            node.graph.touched(node)
        elif node not in self._queued and node.type.compute is not None:
            self._queued.add(node)
            heapq.heappush(self._queue, (node.rank, node))

    def _compute(self, node: Node) -> None:
        db = node.db
        db.computes += 1
        try:
            done = db._compute(db)
        except Exception as error:
            self._graph.failed(db, error)
            return
        count_fired(db)
        if done is False:
            return
        if not node.readers:
            # A value that nobody has read is new to a reader that an edit connects.
            self._seen.pop(node, None)
            return
        values = node.source_values()
        before = self._seen.get(node)
        self._seen[node] = values
        if before is not None and all(map(_same, before, values)):
            return
        if db._push is not None:
            db._push()
        for reader in node.readers:
            self._mark(reader)


def _same(before: Any, now: Any) -> bool:
    return type(before) is type(now) and isinstance(now, _PLAIN) and before == now
