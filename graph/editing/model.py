"""A graph while it is edited: its spec in a form that can be changed, with ends named in full."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from graph.base.errors import Mark
from graph.base.paths import at_or_below
from graph.evaluate import Graph
from graph.node.registry import Registry, UnknownNodeTypeError
from graph.plan.edit_check import EditCheck, EditedPart, Ends
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec, VariableSpec
from graph.values.types import Extended

Side = Literal["source", "target"]
PREFIXES = ("inputs", "outputs", "state")
SUBGRAPH = "Subgraph"
"""The part of a path between a compound and its inner nodes."""


class EditPlace(Mark):
    """An entry of an edit, as a place in messages about this edit."""


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
        self._connections: dict[Ends, ConnectionSpec] | None = None
        self._by_owner: dict[str, dict[Ends, None]] | None = None
        """Ends of connections by either node; None until first needed."""
        self.check: EditCheck | None = None
        """What checks edits whose compiling can wait; made at the first."""
        self.begin()

    def begin(self) -> None:
        """Starts an edit, which `undo` takes back."""
        self.touched: dict[str, None] = {}
        """New nodes, and those with other values or other connections to them."""
        self.added: list[Ends] = []
        self.cut: list[Ends] = []
        self.removed: list[str] = []
        self.others = False
        """Whether the edit also does something that these fields do not hold."""
        compounds = {name: dict(ports) for name, ports in self.compounds.items()}
        connections = None if self._connections is None else dict(self._connections)
        self._before = dict(self.nodes), dict(self.variables), compounds, connections

    def undo(self) -> None:
        """Takes back what was changed since `begin`."""
        self.nodes, self.variables, self.compounds, self._connections = self._before
        self._by_owner = None
        self.begin()

    @property
    def connections(self) -> dict[Ends, ConnectionSpec]:
        """Connections by both full ends, in order."""
        if self._connections is None:
            self._connections = {
                (self.full_end(one.source, "source"), self.full_end(one.target, "target")): one
                for one in self.base.connections
            }
        return self._connections

    def change(self, name: str) -> NodeModel:
        """The node, to be changed."""
        old = self.nodes[name]
        self.touched[name] = None
        if self._before[0].get(name) is not old:
            old.spec = None
            return old
        node = NodeModel(old.type, dict(old.inputs), dict(old.marks), dict(old.attributes), old.mark)
        self.nodes[name] = node
        return node

    def take_values(self, graph: Graph) -> None:
        """Takes the values that were set on the nodes of the graph since it was compiled.

        A value of an attribute of open type keeps the type that it had then.
        """
        for (name, full), value in graph.written.items():
            if name in self.nodes:
                node, compiled = self.nodes[name], graph.members[name]
                type_ = compiled.types[full]
                if type_ is not None and isinstance(compiled.attribute(full).parsed, Extended):
                    value = {"type": type_.name, "value": value}
                key = next((one for one in (full, full.partition(":")[2]) if one in node.inputs), full)
                inputs = {**node.inputs, key: value}
                self.nodes[name] = NodeModel(node.type, inputs, node.marks, node.attributes, node.mark)

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
        self.others |= name in self.compounds
        self.removed += [one for one in self.nodes if one in gone]
        for one in gone:
            self.nodes.pop(one, None)
        for compound in [one for one in self.compounds if at_or_below(one, name)]:
            del self.compounds[compound]
        self.drop(gone)
        self.touched = {one: None for one in self.touched if one not in gone}

    def connect(self, ends: tuple[str, str], mark: Mark) -> None:
        """Adds a connection."""
        self.connections[ends] = ConnectionSpec(*ends, mark)
        if self._by_owner is not None:
            _note_ends(self._by_owner, ends)
        self.added.append(ends)
        self.touched[ends[1].rpartition(".")[0]] = None

    def disconnect(self, ends: tuple[str, str]) -> bool:
        """Removes a connection; False if it does not exist."""
        if self.connections.pop(ends, None) is None:
            return False
        self.cut.append(ends)
        self.touched[ends[1].rpartition(".")[0]] = None
        if self._by_owner is not None:
            for end in ends:
                self._by_owner[end.rpartition(".")[0]].pop(ends, None)
        return True

    def drop(self, names: set[str]) -> None:
        """Removes the connections from and to these nodes (names, or paths of nodes of other graphs)."""
        for name in names:
            for ends in list(self._ends_by_owner().get(name, ())):
                self.disconnect(ends)

    def is_fed(self, name: str, full: str) -> bool:
        """Whether a connection leads to an attribute of a node."""
        return any(one.target == f"{name}.{full}" for one in self._around(name))

    def into(self, name: str) -> list[tuple[str, str]]:
        """Both ends of the connections into a node, in order."""
        return [ends for ends in self._ends_by_owner().get(name, ()) if ends[1].rpartition(".")[0] == name]

    def part(self) -> EditedPart | None:
        """What the edit concerns; None if it also changes variables, compounds or attributes."""
        if (
            self.others
            or not self.touched.keys().isdisjoint(self.removed)
            or not self.nodes.keys() >= self.touched.keys()
        ):
            return None
        return EditedPart([self.node_spec(name) for name in self.touched], self.added, self.cut, self._around)

    def _around(self, name: str) -> Iterable[ConnectionSpec]:
        connections = self.connections
        for ends in self._ends_by_owner().get(name, ()):
            one = connections[ends]
            yield one if (one.source, one.target) == ends else ConnectionSpec(*ends, one.mark)

    def _ends_by_owner(self) -> dict[str, dict[Ends, None]]:
        if self._by_owner is None:
            self._by_owner = {}
            for ends in self.connections:
                _note_ends(self._by_owner, ends)
        return self._by_owner

    def forget_marks(self) -> None:
        """Removes the places in the edit, which mean nothing in later messages."""
        for name in self.touched.keys() & self.nodes.keys():
            node = self.nodes[name]
            node.mark = None if isinstance(node.mark, EditPlace) else node.mark
            node.marks = {key: mark for key, mark in node.marks.items() if not isinstance(mark, EditPlace)}
            node.spec = None
        for ends in self.added:
            if ends in self.connections:
                self.connections[ends] = ConnectionSpec(*ends)

    def spec(self) -> GraphSpec:
        """The spec to compile the graph from."""
        return replace(
            self.base,
            nodes=tuple(map(self.node_spec, self.nodes)),
            connections=self.base.connections if self._connections is None else tuple(self._connections.values()),
            variables=dict(self.variables),
            compounds={name: dict(ports) for name, ports in self.compounds.items()},
        )

    def node_spec(self, name: str) -> NodeSpec:
        """A node as a spec has it."""
        node = self.nodes[name]
        if node.spec is None:
            node.spec = NodeSpec(name, node.type, dict(node.inputs), node.mark, dict(node.marks), dict(node.attributes))
        return node.spec


def _note_ends(by_owner: dict[str, dict[Ends, None]], ends: Ends) -> None:
    for end in ends:
        by_owner.setdefault(end.rpartition(".")[0], {})[ends] = None
