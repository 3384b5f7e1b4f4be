"""Turns raw graphs into `GraphSpec`s: flattens compounds, names connections, drops broken ones with a warning."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from operator import attrgetter, itemgetter
from typing import Any

from graph.base.errors import Mark
from graph.base.limits import check
from graph.node.declaration import Attribute
from graph.node.registry import DEFAULT
from graph.spec.file_spec import ConnectionSpec, FileSpec, GraphSpec, NodeSpec, VariableSpec
from graph.spec.migration import meant_nothing, migrate, migrated_type, upgraded
from graph.values.types import Type

from .json_values import decoded, in_noted_order, is_default, restored
from .ports import Ports, sources_of, targets_of
from .properties import RawAttribute, extended_in
from .raw_graph import KEY, PREFIXES, RawGraph, RawNode, Tell, ogn_type, some
from .variables import variable_name, variable_type

MarkOf = Callable[[str], Mark]
"""The mark of a path on the stage."""


def graph_specs(graphs: Sequence[RawGraph], mark_of: MarkOf, tell: Tell) -> tuple[GraphSpec, ...]:
    """The specifications of all graphs; attributes of nodes have the types that the file declares.

    Raises OverLimit beyond the limit graph.values.
    """
    values = sum(len(node.attributes) for graph in graphs for node in graph.nodes)
    check("graph.values", values, f"the nodes of the scene have {values:,} attributes")
    ports = Ports(
        [one for graph in graphs for one in graph.compounds], [one for graph in graphs for one in graph.nodes]
    )
    homes = {node.path: (graph.path, node.name) for graph in graphs for node in graph.nodes}
    homes |= {compound.path: (graph.path, compound.name) for graph in graphs for compound in graph.compounds}
    settled, animated = _Settled(), list[str]()
    specs = tuple(_graph(graph, ports, homes, settled, animated, mark_of, tell) for graph in graphs)
    if animated:
        message = f"time samples move no graph; one value counts of {some(animated, 'attribute')}"
        tell("value-animated", animated[0], message)
    _tell_newer_types(graphs, tell)
    return specs


def _tell_newer_types(graphs: Iterable[RawGraph], tell: Tell) -> None:
    """Warns of types that have a later version in the file than here, at the first node of each."""
    first: dict[str, RawNode] = {}
    for graph in graphs:
        for node in graph.nodes:
            first.setdefault(node.type, node)
    for type_id, node in first.items():
        version = node.version if type_id in DEFAULT else None
        if version is not None and version > (here := DEFAULT.get(type_id)).version:
            message = f"{here.short_name} is of version {version} in the file and of version {here.version} here"
            tell("type-newer", node.path, f"{message}; what is new is left out")


class _Settled(dict[str, Mapping[str, Attribute]]):
    """By type id in the file, the full names of the attributes whose type is fixed."""

    def __missing__(self, type_id: str) -> Mapping[str, Attribute]:
        present = migrated_type(type_id)[0]
        known = DEFAULT.get(present) if present in DEFAULT else None
        groups = (("inputs", known.inputs), ("outputs", known.outputs), ("state", known.state)) if known else ()
        self[type_id] = found = {
            f"{prefix}:{name}": one
            for prefix, group in groups
            for name, one in group.items()
            if isinstance(one.parsed, Type)
        }
        return found


def _graph(
    graph: RawGraph,
    ports: Ports,
    homes: Mapping[str, tuple[str, str]],
    settled: Mapping[str, Mapping[str, Attribute]],
    animated: list[str],
    mark_of: MarkOf,
    tell: Tell,
) -> GraphSpec:
    connections = [
        connection
        for node in graph.nodes
        for attribute in node.attributes
        if (sources := sources_of(attribute))
        for connection in _connections(graph.path, node, attribute.name, sources, ports, homes, mark_of, tell)
    ]
    variables = in_noted_order(graph.variables, variable_name, graph.custom, "variables")
    nodes = in_noted_order(graph.nodes, attrgetter("name"), graph.custom, "nodes")
    listed = graph.custom.get("removedVariables")
    removed = set(listed) if isinstance(listed, list) else set()
    # Our own writer records everything about a graph; other programs, and later additions, do not.
    saved = not (graph.custom and all(node.custom for node in graph.nodes)) or graph.custom.get("lenient") is True
    return GraphSpec(
        graph.path,
        tuple(_node(node, ports, {} if node.custom else settled[node.type], animated, mark_of) for node in nodes),
        tuple(_in_written_order(connections, graph.custom.get("connections"))),
        graph.evaluator,
        graph.pipeline_stage,
        {
            variable_name(one): VariableSpec(
                variable_type(one) or one.sdf_type, restored(one.value, one.custom), mark_of(f"{graph.path}.{one.name}")
            )
            for one in variables
            if variable_name(one) not in removed
        },
        mark_of(graph.path),
        compounds={compound.name: _ports(graph, compound, ports) for compound in graph.compounds},
        unfinished=saved,
        saved=saved,
        evaluation_mode=graph.evaluation_mode,
        instances=graph.instances,
    )


def _ports(graph: RawGraph, compound: RawNode, ports: Ports) -> dict[str, tuple[str, ...]]:
    """The ports of a compound and the inner attributes that each stands for."""
    prefix = f"{graph.path}/"
    found: dict[str, list[str]] = {}
    for port in compound.attributes:
        path = f"{compound.path}.{port.name}"
        found[port.name] = list(ports.behind(path)) if port.name.startswith("outputs:") else ports.inside(path)
    return {name: tuple(end.removeprefix(prefix) for end in ends) for name, ends in found.items()}


def _node(
    node: RawNode, ports: Ports, settled: Mapping[str, Attribute], animated: list[str], mark_of: MarkOf
) -> NodeSpec:
    """The node; data in the file on attributes of fixed type is read only where needed.

    Paths of attributes that have time samples are added to `animated`.
    """
    inputs: dict[str, Any] = {}
    marks: dict[str, Mark] = {}
    types: dict[str, str] = {}
    for attribute in node.attributes:
        name = attribute.name
        output = name.startswith("outputs:")
        known = settled.get(name)
        if known is None:
            declared = ogn_type(attribute)
            if declared is not None:
                types[name] = declared
        elif output or known.is_execution:
            continue
        if output:
            continue
        custom = attribute.custom
        if known is not None and custom.get("isExecution"):
            types[name] = "execution"
        value, written = _value(attribute, custom), f"{node.path}.{name}"
        for source in sources_of(attribute) if ports else ():
            port = None if ports.behind(source) else ports.value(source)
            if port is not None:  # nothing feeds the compound's port, so the port's own value reaches the node
                value, written = _value(port, port.custom), written + ".connect"
                break
        if value is not None and not (custom and is_default(value, custom)):
            key = name.removeprefix("inputs:")
            inputs[key] = value
            marks[key] = mark_of(written)
            if attribute.is_animated:
                animated.append(f"{node.path}.{name}")
    if node.custom:  # recorded by our own writer: attributes that are not of the type, or without a name in USD
        types = {str(full): str(one) for full, one in _mapping(node.custom, "attributes").items()}
        inputs.update(_mapping(node.custom, "inputs"))
        inputs = dict(in_noted_order(inputs.items(), itemgetter(0), node.custom, "order"))
    given = upgraded(node.type, node.version, inputs) if meant_nothing(node.type)[0] else inputs
    return NodeSpec(node.name, _type_as_written(node), given, mark_of(node.path), marks, types)


def node_and_links(
    prim: Any, graph: str, name: str, mark_of: MarkOf, tell: Tell
) -> tuple[NodeSpec, dict[tuple[str, str], None]]:
    """The specification of one node prim that is in no compound, and the connections into it as `links_of` gives them.

    name: its path from the graph's.
    """
    path, animated = prim.GetPath(), list[str]()
    node = RawNode(prim, path, str(path), name)
    ports = Ports([], [node])
    found = _node(node, ports, {} if node.custom else _Settled()[node.type], animated, mark_of)
    if animated:
        tell("value-animated", animated[0], "time samples move no graph; one value counts of this attribute")
    present = migrate(FileSpec(graphs=(GraphSpec(graph, (found,)),))).graphs[0].nodes[0]
    return present, _links(graph, node, ports)


def links_of(graphs: Sequence[RawGraph]) -> list[dict[str, dict[tuple[str, str], None]]]:
    """For each graph the connections into each node that has any, by both full ends.

    An end in the same graph is `node.outputs:x`, another one a path.
    """
    ports = Ports(
        [one for graph in graphs for one in graph.compounds], [one for graph in graphs for one in graph.nodes]
    )
    each = [{node.name: _links(graph.path, node, ports) for node in graph.nodes} for graph in graphs]
    return [{name: links for name, links in one.items() if links} for one in each]


def _links(graph: str, node: RawNode, ports: Ports) -> dict[tuple[str, str], None]:
    return {
        (source.removeprefix(f"{graph}/"), f"{node.name}.{attribute.name}"): None
        for attribute in node.attributes
        if not attribute.name.startswith("outputs:")
        for written in sources_of(attribute)
        for source in ports.behind(written)
        if source.rpartition(".")[2].startswith(PREFIXES)
    }


def _type_as_written(node: RawNode) -> str:
    """The type id; the short name of the file that our own writer converted, as long as it still means this type."""
    noted = node.custom.get("type")
    if isinstance(noted, str) and noted in DEFAULT and DEFAULT.get(noted).id == node.type:
        return noted
    return node.type


def _mapping(custom: Mapping[str, Any], name: str) -> dict[str, Any]:
    found = decoded(custom, name)
    return found if isinstance(found, dict) else {}


def _value(attribute: RawAttribute, custom: Mapping[str, Any]) -> Any:
    """The value in the file of an attribute whose customData is `custom`, or None."""
    value: Any = None
    if custom.get("isExecution"):
        pass  # execution, not data
    elif attribute.is_relationship:
        targets = targets_of(attribute)
        value = (targets[0] if len(targets) == 1 else targets) if targets else None
    else:
        value = attribute.value
        extended = extended_in(custom) if custom and not _says_nothing(custom) else {}
        if extended.get("attrValue") is not None and attribute.sdf_type == "token":
            value = extended["attrValue"]
            if isinstance(extended.get("resolvedType"), str):
                value = {"type": extended["resolvedType"], "value": value}
    return restored(value, custom) if custom else value


def _says_nothing(custom: Mapping[str, Any]) -> bool:
    """Whether our own writer recorded that a value of a sublayer does not count."""
    ours = custom.get(KEY)
    return isinstance(ours, dict) and ours.get("noValue") is True


def _connections(
    graph: str,
    node: RawNode,
    attribute: str,
    sources: Sequence[str],
    ports: Ports,
    homes: Mapping[str, tuple[str, str]],
    mark_of: MarkOf,
    tell: Tell,
) -> Iterator[ConnectionSpec]:
    """The connections from `sources` to an attribute."""
    place = f"{node.path}.{attribute}.connect"
    for written in sources:
        for source in ports.behind(written):
            owner, _, name = source.rpartition(".")
            home = homes.get(owner)
            if home is None or not name.startswith(PREFIXES):
                reason = "that is not a node of a graph" if home is None else "that is not an attribute of a node"
                tell("usd-lost-connection", place, f"{node.path}.{attribute} is fed by {source}, but {reason}")
                continue
            if attribute.startswith("outputs:"):
                tell("usd-lost-connection", place, f"{node.path}.{attribute} is an output that {source} feeds")
                continue
            start = f"{home[1]}.{shortened(name, 'outputs:')}" if home[0] == graph else source
            yield ConnectionSpec(start, f"{node.name}.{shortened(attribute, 'inputs:')}", mark_of(place))


def shortened(name: str, prefix: str) -> str:
    """An attribute's name without its prefix, unless the rest would be ambiguous."""
    short = name.removeprefix(prefix)
    return name if short.startswith(PREFIXES) else short


def _in_written_order(connections: list[ConnectionSpec], noted: Any) -> list[ConnectionSpec]:
    """Connections in the order, and with the words, that our own writer recorded.

    A record is the connection as it is read back, with a tab and the original text if that differs; an empty text
    before the tab means a connection that USD cannot hold. Connections without a record come last, in prim order.
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
