"""A graph while it is edited: its spec in a form that can be changed, with ends named in full."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

from graph.base.errors import Mark
from graph.base.paths import at_or_below
from graph.node.registry import Registry, UnknownNodeTypeError
from graph.plan.checked_patch import Patch
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec, VariableSpec

Side = Literal["source", "target"]
PREFIXES = ("inputs", "outputs", "state")
SUBGRAPH = "Subgraph"
"""The part of a path between a compound and its inner nodes."""


@dataclass(slots=True)
class NodeModel:
    """A node being edited. `marks` say which entry of the edit set each value."""

    type: str
    inputs: dict[str, Any] = field(default_factory=dict)
    marks: dict[str, Mark] = field(default_factory=dict)
    attributes: dict[str, str] = field(default_factory=dict)
    mark: Mark | None = None
    spec: NodeSpec | None = None
    """The former node, as long as nothing of it has changed."""


@dataclass(slots=True)
class Changes:
    """What one edit does to a model, for edits in place."""

    nodes: dict[str, None] = field(default_factory=dict)
    connections: list[tuple[str, str]] = field(default_factory=list)
    removed: list[str] = field(default_factory=list)
    cut: list[tuple[str, str]] = field(default_factory=list)
    values: list[tuple[str, str]] = field(default_factory=list)
    """Values set on existing nodes: the node and the attribute's full name."""
    others: bool = False
    """Whether the edit also does something that these fields do not hold."""


class Model:
    """An editable graph. Connections are kept by their ends: `node.outputs:x`, absolute for another graph."""

    def __init__(self, spec: GraphSpec, registry: Registry) -> None:
        self.base = spec
        self.path = spec.path
        self.registry = registry
        self.nodes = {
            node.name: NodeModel(
                node.type, dict(node.inputs), dict(node.input_marks), dict(node.attributes), node.mark, node
            )
            for node in spec.nodes
        }
        self.variables: dict[str, VariableSpec] = dict(spec.variables)
        self.compounds = {name: dict(ports) for name, ports in spec.compounds.items()}
        self._connections: dict[tuple[str, str], ConnectionSpec] | None = None
        self._by_owner: dict[str, dict[tuple[str, str], None]] | None = None
        """Ends of connections by either node; None until first needed."""
        self.touched: set[str] = set()
        self.patches: Any = None
        """Makes edits in place; created at the first."""
        self.changes = Changes()
        self._positions = {node.name: position for position, node in enumerate(spec.nodes)}

    @property
    def connections(self) -> dict[tuple[str, str], ConnectionSpec]:
        """Connections by both full ends, in order."""
        if self._connections is None:
            self._connections = {
                (self.full_end(one.source, "source"), self.full_end(one.target, "target")): one
                for one in self.base.connections
            }
        return self._connections

    def change(self, name: str) -> NodeModel:
        """The node, marked as changed."""
        node = self.nodes[name]
        node.spec = None
        self.touched.add(name)
        return node

    def full_end(self, text: str, side: Side) -> str:
        """An end of a connection as this model names it."""
        owner, _, attribute = text.rpartition(".")
        name = self.local_name(owner)
        if name not in self.nodes:
            return text
        return f"{name}.{self.full_attribute(name, attribute, side)}"

    def local_name(self, owner: str) -> str:
        """A node's name in this graph, from a name or from an absolute path of either form."""
        for separator in "/.":
            start = f"{self.path}{separator}"
            if owner.startswith(start):
                return owner[len(start) :]
        return owner

    def full_attribute(self, name: str, written: str, side: Side) -> str:
        """The full name of an attribute on this side:

        `inputs:x` for `x`. As written if the node has no such attribute.
        """
        prefix, _, rest = written.partition(":")
        if prefix in PREFIXES and rest:
            return written
        order = ("outputs", "inputs", "state") if side == "source" else ("inputs", "state", "outputs")
        node = self.nodes[name]
        for one in order:
            if f"{one}:{written}" in node.attributes:
                return f"{one}:{written}"
        try:
            node_type = self.registry.get(node.type)
        except UnknownNodeTypeError:
            return written
        for one in order:
            if written in getattr(node_type, one):
                return f"{one}:{written}"
        for one in order:
            if node_type.find(one, written) is not None:
                return f"{one}:{written}"
        return written

    def remove_node(self, name: str) -> None:
        """Removes a node, or a compound with all inner nodes, and their connections in this graph."""
        gone = {name, *(one for one in self.nodes if at_or_below(one, name))}
        self.changes.others |= name in self.compounds or not gone.isdisjoint(self.changes.nodes)
        self.changes.removed += [one for one in self.nodes if one in gone]
        for one in gone:
            self.nodes.pop(one, None)
        for compound in [one for one in self.compounds if at_or_below(one, name)]:
            del self.compounds[compound]
        self.drop(gone)

    def connect(self, ends: tuple[str, str], mark: Mark) -> None:
        """Adds a connection."""
        self.connections[ends] = ConnectionSpec(*ends, mark)
        if self._by_owner is not None:
            _note_ends(self._by_owner, ends)
        self.changes.connections.append(ends)

    def disconnect(self, ends: tuple[str, str]) -> bool:
        """Removes a connection; False if it does not exist."""
        if self.connections.pop(ends, None) is None:
            return False
        self.changes.cut.append(ends)
        if self._by_owner is not None:
            for end in ends:
                self._by_owner[end.rpartition(".")[0]].pop(ends, None)
        return True

    def drop(self, names: set[str]) -> None:
        """Removes the connections from and to these nodes (names, or paths of nodes of other graphs)."""
        if self._by_owner is None:
            self._by_owner = {}
            for ends in self.connections:
                _note_ends(self._by_owner, ends)
        for name in names:
            for ends in list(self._by_owner.get(name, ())):
                if self.disconnect(ends):
                    self.touched.add(ends[1].rpartition(".")[0])

    def patch(self) -> Patch | None:
        """What the edit adds and sets, without marks; None if it does more than that."""
        changes = self.changes
        if changes.others:
            return None
        for name in changes.nodes:
            self.nodes[name].mark, self.nodes[name].marks = None, {}
        for name, full in changes.values:
            self.nodes[name].marks.pop(full, None)
        return Patch(
            [self.as_it_is(name) for name in changes.nodes],
            [ConnectionSpec(*ends) for ends in changes.connections],
            [(name, full, self.nodes[name].inputs[full]) for name, full in changes.values],
            changes.removed,
            changes.cut,
        )

    def patched(self, patch: Patch) -> GraphSpec:
        """The spec with a patch that was made; further edits of the model start from it."""
        nodes = [*self.base.nodes, *patch.nodes]
        for node in patch.nodes:
            self._positions[node.name] = len(self._positions)
        for name, _, _ in patch.values:
            nodes[self._positions[name]] = self.as_it_is(name)
        if patch.removed:
            gone = set(patch.removed)
            nodes = [node for node in nodes if node.name not in gone]
            self._positions = {node.name: position for position, node in enumerate(nodes)}
        for one in patch.connections:
            self.connections[one.source, one.target] = one
        connections = tuple(self.connections.values()) if patch.cut else (*self.base.connections, *patch.connections)
        self.base = replace(self.base, nodes=tuple(nodes), connections=connections)
        self.changes = Changes()
        self.touched = set()
        return self.base

    def as_it_is(self, name: str) -> NodeSpec:
        """A node's spec that later edits do not change."""
        node = self.nodes[name]
        return NodeSpec(name, node.type, dict(node.inputs), node.mark, dict(node.marks), dict(node.attributes))

    def spec(self) -> GraphSpec:
        """The spec to compile the graph from."""
        return replace(
            self.base,
            nodes=tuple(_node_spec(name, node) for name, node in self.nodes.items()),
            connections=self.base.connections if self._connections is None else tuple(self._connections.values()),
            variables=self.variables,
            compounds=self.compounds,
        )


def _note_ends(by_owner: dict[str, dict[tuple[str, str], None]], ends: tuple[str, str]) -> None:
    for end in ends:
        by_owner.setdefault(end.rpartition(".")[0], {})[ends] = None


def _node_spec(name: str, node: NodeModel) -> NodeSpec:
    return node.spec or NodeSpec(name, node.type, node.inputs, node.mark, node.marks, node.attributes)
