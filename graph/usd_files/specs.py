"""Raw graphs to `GraphSpec`s: compounds flattened, connections by name, what leads nowhere left out with a line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from graph.errors import Mark
from graph.migration import upgraded
from graph.registry import DEFAULT
from graph.spec import ConnectionSpec, GraphSpec, NodeSpec, VariableSpec

from .graph_prims import RawGraph, Tell, variable_name
from .json_values import decoded, restored
from .node_prims import KEY, RawAttribute, RawNode, ogn_type
from .ports import Ports, sources_of, targets_of

MarkOf = Callable[[str], Mark]
"""The mark of a path on the stage."""


def graph_specs(graphs: Sequence[RawGraph], mark_of: MarkOf, tell: Tell) -> tuple[GraphSpec, ...]:
    """The specifications of all graphs; attributes of nodes have the types that the file declares."""
    ports = Ports(
        [one for graph in graphs for one in graph.compounds], [one for graph in graphs for one in graph.nodes]
    )
    homes = {node.path: (graph.path, node.name) for graph in graphs for node in graph.nodes}
    homes |= {compound.path: (graph.path, compound.name) for graph in graphs for compound in graph.compounds}
    return tuple(_graph(graph, ports, homes, mark_of, tell) for graph in graphs)


def _graph(
    graph: RawGraph, ports: Ports, homes: Mapping[str, tuple[str, str]], mark_of: MarkOf, tell: Tell
) -> GraphSpec:
    connections = [
        connection
        for node in graph.nodes
        for attribute in node.attributes
        if attribute.sources or attribute.sdf_type == "rel"
        for connection in _connections(graph.path, node, attribute, ports, homes, mark_of, tell)
    ]
    listed = graph.custom.get("removedVariables")
    removed = set(listed) if isinstance(listed, list) else set()
    return GraphSpec(
        graph.path,
        tuple(_node(node, ports, mark_of) for node in graph.nodes),
        tuple(_in_written_order(connections, graph.custom.get("connections"))),
        graph.evaluator,
        graph.pipeline_stage,
        {
            variable_name(one): VariableSpec(
                _written_type(one), restored(one.value, one.custom), mark_of(f"{graph.path}.{one.name}")
            )
            for one in graph.variables
            if variable_name(one) not in removed
        },
        mark_of(graph.path),
        compounds={compound.name: _ports(graph, compound, ports) for compound in graph.compounds},
        unfinished=not graph.custom,
        saved=not graph.custom,
        evaluation_mode=graph.evaluation_mode,
        instances=graph.instances,
    )


def _ports(graph: RawGraph, compound: RawNode, ports: Ports) -> dict[str, tuple[str, ...]]:
    """The ports of a compound and the ends of inner nodes that each stands for."""
    prefix = f"{graph.path}/"
    found: dict[str, list[str]] = {}
    for port in compound.attributes:
        path = f"{compound.path}.{port.name}"
        found[port.name] = list(ports.behind(path)) if port.name.startswith("outputs:") else ports.inside(path)
    return {name: tuple(end.removeprefix(prefix) for end in ends) for name, ends in found.items()}


def _written_type(variable: RawAttribute) -> str:
    """The OGN type of a variable; our own writer notes those that share a USD type with another."""
    ours = variable.custom.get(KEY)
    noted = ours.get("type") if isinstance(ours, dict) else None
    return noted if isinstance(noted, str) else ogn_type(variable) or variable.sdf_type


def _node(node: RawNode, ports: Ports, mark_of: MarkOf) -> NodeSpec:
    inputs: dict[str, Any] = {}
    marks: dict[str, Mark] = {}
    types: dict[str, str] = {}
    for attribute in node.attributes:
        declared = ogn_type(attribute)
        if declared is not None:
            types[attribute.name] = declared
        if attribute.name.startswith("outputs:"):
            continue
        value, written = _value(attribute), f"{node.path}.{attribute.name}"
        for source in sources_of(attribute) if ports else ():
            port = None if ports.behind(source) else ports.value(source)
            if port is not None:  # nothing feeds the compound's port, so its own value reaches the node
                value, written = _value(port), written + ".connect"
                break
        if value is not None:
            key = attribute.name.removeprefix("inputs:")
            inputs[key] = value
            marks[key] = mark_of(written)
    if node.custom:  # our own writer notes which attributes are not of the type, and what USD has no names for
        types = {str(full): str(one) for full, one in _mapping(node.custom, "attributes").items()}
        inputs.update(_mapping(node.custom, "inputs"))
    return NodeSpec(
        node.name, _type_as_written(node), upgraded(node.type, node.version, inputs), mark_of(node.path), marks, types
    )


def _type_as_written(node: RawNode) -> str:
    """The type id; the short name that stood in the file our own writer had, as long as it still means this type."""
    noted = node.custom.get("type")
    if isinstance(noted, str) and noted in DEFAULT and DEFAULT.get(noted).id == node.type:
        return noted
    return node.type


def _mapping(custom: Mapping[str, Any], name: str) -> dict[str, Any]:
    found = decoded(custom, name)
    return found if isinstance(found, dict) else {}


def _value(attribute: RawAttribute) -> Any:
    """What the file gives the attribute; None for nothing."""
    value: Any = None
    if attribute.is_execution:
        pass  # control, no data
    elif attribute.sdf_type == "rel":
        targets = targets_of(attribute)
        value = (targets[0] if len(targets) == 1 else targets) if targets else None
    else:
        value = attribute.value
        extended = {} if _says_nothing(attribute) else attribute.extended
        if extended.get("attrValue") is not None and attribute.sdf_type == "token":
            value = extended["attrValue"]
            if isinstance(extended.get("resolvedType"), str):
                value = {"type": extended["resolvedType"], "value": value}
    return restored(value, attribute.custom)


def _says_nothing(attribute: RawAttribute) -> bool:
    """Whether our own writer noted that a value of a layer below counts no more."""
    ours = attribute.custom.get(KEY)
    return isinstance(ours, dict) and ours.get("noValue") is True


def _connections(
    graph: str,
    node: RawNode,
    attribute: RawAttribute,
    ports: Ports,
    homes: Mapping[str, tuple[str, str]],
    mark_of: MarkOf,
    tell: Tell,
) -> Iterator[ConnectionSpec]:
    place = f"{node.path}.{attribute.name}.connect"
    for written in sources_of(attribute):
        for source in ports.behind(written):
            owner, _, name = source.rpartition(".")
            home = homes.get(owner)
            if home is None or not name.startswith(("outputs:", "inputs:", "state:")):
                reason = "that is no node of a graph" if home is None else "that is no attribute of a node"
                tell("usd-lost-connection", place, f"{node.path}.{attribute.name} is fed by {source}, but {reason}")
                continue
            if attribute.name.startswith("outputs:"):
                tell("usd-lost-connection", place, f"{node.path}.{attribute.name} is an output that {source} feeds")
                continue
            start = f"{home[1]}.{shortened(name, 'outputs:')}" if home[0] == graph else f"{owner}.{name}"
            yield ConnectionSpec(start, f"{node.name}.{shortened(attribute.name, 'inputs:')}", mark_of(place))


def shortened(name: str, prefix: str) -> str:
    """An attribute's name without the prefix that goes without saying, unless what is left would be misread."""
    short = name.removeprefix(prefix)
    return name if short.startswith(("inputs:", "outputs:", "state:")) else short


def _in_written_order(connections: list[ConnectionSpec], noted: Any) -> list[ConnectionSpec]:
    """Connections in the order, and with the words, that our own writer noted.

    A note is the connection as it is read back, with a tab and the text as it was written where that differs; nothing
    before the tab stands for a connection that USD cannot hold. Connections without a note come last, in prim order.
    """
    if not isinstance(noted, list):
        return connections
    found = {f"{one.source} -> {one.target}": one for one in connections}
    ordered: list[ConnectionSpec] = []
    for note in map(str, noted):
        text, tab, written = note.partition("\t")
        source, arrow, target = (written if tab else text).partition(" -> ")
        if arrow and (not text or text in found):
            mark = found.pop(text).mark if text else None
            ordered.append(ConnectionSpec(source, target, mark))
    return [*ordered, *(one for one in connections if f"{one.source} -> {one.target}" in found)]
