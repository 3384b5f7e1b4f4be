"""What whole graphs did, by update: firings, values, warnings, messages, frames."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from graph.base.errors import RunError
from graph.base.suggest import did_you_mean
from graph.evaluate import Graph, Node


class GraphTrace:
    """What the graphs of a file did. References are `node.attr`, or `/World/Graph/node.attr` if a name is not unique.

    An attribute is short (`tick`: outputs first, then inputs, then state) or full (`inputs:x`).

    updates: how many updates were completed. error: what ended the run early (with `run_graph(..., catch=True)`).
    in_world: whether it ran in an App. warnings: objects with code, where, message and count. messages: the ROS 2
    messages of each topic as (update, message). frames: for each sensor prim the updates in which it delivered a frame.
    Without a world the last two are empty.
    """

    def __init__(self, graphs: Iterable[Graph], record: Collection[str] | None = None) -> None:
        self.graphs: dict[str, Graph] = {graph.path: graph for graph in graphs}
        self._by_path = {node.path: node for graph in self.graphs.values() for node in graph.nodes.values()}
        self.updates = 0
        self.in_world = False
        self.error: RunError | None = None
        self.warnings: list[Any] = []
        self.messages: dict[str, list[tuple[int, Any]]] = {}
        self.frames: dict[str, list[int]] = {}
        self._fires: dict[tuple[Node, str], list[int]] = {}
        self._values: dict[tuple[Node, str], list[Any]] = {}
        self._counts: list[tuple[Node, dict[str, int]]] = []
        self._watch(record)

    def __repr__(self) -> str:
        counts = {"updates": self.updates, "nodes": len(self._by_path), "topics": len(self.messages)}
        counts |= {"sensors": len(self.frames), "warnings": len(self.warnings)}
        said = " ".join(f"{name}={count}" for name, count in counts.items())
        return f"<GraphTrace {said}{f': {self.error}' if self.error else ''}>"

    def node(self, reference: str) -> Node:
        """The node with that name or path. Raises KeyError with the nearest name."""
        if reference in self._by_path:
            return self._by_path[reference]
        found = [graph.nodes[reference] for graph in self.graphs.values() if reference in graph.nodes]
        if len(found) == 1:
            return found[0]
        if found:
            raise KeyError(f'"{reference}" stands in several graphs; write {" or ".join(node.path for node in found)}')
        known = self._by_path if "/" in reference else [node.name for node in self._by_path.values()]
        raise KeyError(f'there is no node "{reference}"{did_you_mean(reference, known)}')

    def attribute(self, reference: str, prefix: str = "outputs") -> tuple[Node, str]:
        """Node and full attribute name of a reference; for a short name `prefix` is searched first.

        Raises KeyError with the nearest name.
        """
        name, dot, short = reference.rpartition(".")
        if not dot:
            raise KeyError(f'"{reference}" names no attribute; write node.attribute')
        node = self.node(name)
        return node, full_name(node, short, prefix)

    def fired(self, reference: str) -> list[int]:
        """The updates in which this execution output was followed, once for each time."""
        node, full = self.attribute(reference)
        if not full.startswith("outputs:") or not node.attribute(full).is_execution:
            raise KeyError(f'"{reference}" ({node.type.id}) is not an execution output; ask for its values')
        return self._fires[node, full.partition(":")[2]]

    def values(self, reference: str) -> list[Any]:
        """The value of an attribute after each update."""
        node, full = self.attribute(reference)
        if node.attribute(full).is_execution:
            raise KeyError(f'"{reference}" ({node.type.id}) is an execution attribute; ask when it fired')
        try:
            return self._values[node, full]
        except KeyError:
            raise KeyError(f'"{reference}" was not recorded; name it in record=') from None

    def value(self, reference: str) -> Any:
        """The value of an attribute after the last update."""
        return self.values(reference)[-1]

    def computes(self, reference: str) -> int:
        """How often a node computed."""
        return self.node(reference).computes

    # -- for the runner ----------------------------------------------------------------------------------------------

    def note(self, update: int) -> None:
        """Records the firings of an update and the values after it."""
        for node, before in self._counts:
            for name, count in node.fired.items():
                more = count - before[name]
                if more:
                    before[name] = count
                    self._fires[node, name] += [update] * more
        for (node, full), values in self._values.items():
            values.append(held(node.get(full)))

    def _watch(self, record: Collection[str] | None) -> None:
        for graph in self.graphs.values():
            for node in graph.nodes.values():
                if node.fired:
                    self._counts.append((node, dict(node.fired)))
                    self._fires.update({(node, name): [] for name in node.fired})
                if record is None:
                    data = [full for full, attribute in node.attributes() if not attribute.is_execution]
                    self._values.update({(node, full): [] for full in data})
        for reference in record or ():
            node, full = self.attribute(reference)
            if not node.attribute(full).is_execution:
                self._values[node, full] = []


def full_name(node: Node, name: str, prefix: str = "outputs") -> str:
    """`outputs:x` for `x`, if `prefix` is outputs and the node has such an output; else the node's own rule."""
    return f"{prefix}:{name}" if name in node.names.get(prefix, ()) else node.full_name(name)


def held(value: Any) -> Any:
    """A copy of a value that does not change with the node: arrays and containers are copied."""
    if isinstance(value, list):
        return list(value)
    if isinstance(value, Mapping):
        return dict(value)
    copy = getattr(value, "copy", None)
    return copy() if copy is not None and hasattr(value, "dtype") else value
