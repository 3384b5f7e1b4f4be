"""Writes connections in USD, on their destinations, with a record of their order and words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from graph.node.declaration import Attribute
from graph.node.registry import Registry
from graph.sim.scene.prim_paths import is_path
from graph.spec.file_spec import ConnectionSpec, FileSpec, GraphSpec, NodeSpec
from graph.values.types import Extended, Type

from .node_writing import EXECUTION, declared_attributes
from .specs import shortened
from .values import sdf_name


@dataclass(frozen=True, slots=True)
class _End:
    path: str
    """Of the attribute."""
    graph: str
    node: str
    name: str
    """The attribute's full name."""
    type: str
    """Its OGN type, or "token" if that is open or unknown."""


class Links:
    """Writes the connections of a file's graphs after all their nodes are in the layer."""

    def __init__(self, spec: FileSpec, registry: Registry) -> None:
        self._nodes = {f"{graph.path}/{node.name}": (graph, node) for graph in spec.graphs for node in graph.nodes}
        self._declared: dict[str, Mapping[str, Attribute]] = {}
        self._registry = registry

    def write(self, layer: Any, graph: GraphSpec) -> list[str]:
        """Writes a graph's connections; returns the record for `specs`: the order, and the words if they differ."""
        notes = []
        for connection in graph.connections:
            written = f"{connection.source} -> {connection.target}"
            read = self._write_one(layer, graph, connection)
            notes.append(written if read == written else f"{read}\t{written}")
        return notes

    def _write_one(self, layer: Any, graph: GraphSpec, connection: ConnectionSpec) -> str:
        """Writes one connection; returns it as it will be read back, "" if USD cannot hold it."""
        source = self._end(graph, connection.source, "source")
        target = self._end(graph, connection.target, "target")
        if source is None or target is None or target.graph != graph.path or target.name.startswith("outputs:"):
            return ""
        if not _connect(layer, source, target):
            return ""
        start = f"{source.node}.{shortened(source.name, 'outputs:')}" if source.graph == graph.path else source.path
        return f"{start} -> {target.node}.{shortened(target.name, 'inputs:')}"

    def _end(self, graph: GraphSpec, text: str, side: Literal["source", "target"]) -> _End | None:
        name, _, attribute = text.rpartition(".")
        owner, _, local = name.rpartition(".")
        for path in (name, f"{owner}/{local}") if name.startswith("/") else (f"{graph.path}/{name}",):
            if path in self._nodes:
                home, node = self._nodes[path]
                full = self._full_name(path, node, attribute, side)
                declared = self._attributes(path, node).get(full)
                return _End(f"{path}.{full}", home.path, node.name, full, usd_type_name(declared))
        return None

    def _attributes(self, path: str, node: NodeSpec) -> Mapping[str, Attribute]:
        if path not in self._declared:
            known = self._registry.get(node.type) if node.type in self._registry else None
            self._declared[path] = declared_attributes(known, node.attributes)
        return self._declared[path]

    def _full_name(self, path: str, node: NodeSpec, written: str, side: Literal["source", "target"]) -> str:
        """The attribute that a short or full name means on this side; an unknown one gets the side's prefix."""
        prefix, _, name = written.partition(":")
        if prefix in ("inputs", "outputs", "state") and name:
            return written
        known = self._attributes(path, node)
        prefixes = ("outputs", "inputs", "state") if side == "source" else ("inputs", "state")
        return next((full for p in prefixes if (full := f"{p}:{written}") in known), f"{prefixes[0]}:{written}")


def usd_type_name(declared: Attribute | None) -> str:
    """The OGN type of an attribute as USD holds it: "token" if that is open or unknown."""
    if declared is None or isinstance(declared.parsed, Extended):
        return "token"
    return declared.parsed.name


def _connect(layer: Any, source: _End, target: _End) -> bool:
    from graph.sim.usd import Sdf

    if not (is_path(source.path) and is_path(target.path)):
        return False
    path = Sdf.Path(target.path)
    prop = layer.GetPropertyAtPath(path)
    if prop is None:
        prop = fed_property(layer.GetPrimAtPath(path.GetPrimPath()), target.name, source.type)
    if isinstance(prop, Sdf.RelationshipSpec):
        items = prop.targetPathList.explicitItems
    else:
        items = prop.connectionPathList.explicitItems
    feed = Sdf.Path(source.path)
    if feed in items:
        return False
    items.append(feed)
    return True


def fed_property(prim: Any, name: str, source_type: str) -> Any:
    """A new destination that the node's type does not declare: it takes the OGN type of its source."""
    from graph.sim.usd import Sdf
    from graph.values.types import TYPES

    type_: Type = TYPES.get(source_type, TYPES["token"])
    if sdf_name(type_) == "rel":
        prop = Sdf.RelationshipSpec(prim, name)
    else:
        prop = Sdf.AttributeSpec(prim, name, Sdf.ValueTypeNames.Find(sdf_name(type_)))
        if type_.storage == "execution":
            prop.customData = EXECUTION
    prop.custom = True
    return prop
