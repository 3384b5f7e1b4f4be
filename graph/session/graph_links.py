"""The connections of compiled graphs, node to node, and the order in which execution runs along them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

from graph.evaluate.links import Link, links_of

if TYPE_CHECKING:
    from graph.evaluate import Graph, Node
    from graph.node.declaration import Role
    from graph.spec.file_spec import Note


class Links:
    """Every connection between nodes of these graphs."""

    def __init__(self, graphs: Iterable[Graph]) -> None:
        graphs = list(graphs)
        self.nodes = [node for graph in graphs for node in graph.nodes.values()]
        self.all = list(links_of(graphs))
        self.into: dict[Node, list[Link]] = {}
        self.out_of: dict[Node, list[Link]] = {}
        for link in self.all:
            self.into.setdefault(link.target, []).append(link)
            self.out_of.setdefault(link.source, []).append(link)

    def execution_outputs(self) -> Iterator[tuple[Node, str, list[Node]]]:
        """(node, output, targets in file order) of each execution output with two or more connected nodes."""
        fans: dict[tuple[Node, str], list[Node]] = {}
        for link in self.all:
            if link.execution:
                fans.setdefault((link.source, link.output), []).append(link.target)
        for (node, output), targets in fans.items():
            distinct = list(dict.fromkeys(targets))
            if len(distinct) > 1:
                yield node, output, distinct

    def reached(self, start: Node) -> set[Node]:
        """The nodes that execution reaches from `start`, itself included."""
        found: set[Node] = set()
        pending = [start]
        while pending:
            node = pending.pop()
            if node not in found:
                found.add(node)
                pending += [link.target for link in self.out_of.get(node, ()) if link.execution]
        return found

    @cached_property
    def makers(self) -> list[tuple[Node, str]]:
        """The enabled nodes that have sensors rendered, each with the sensor's prim."""
        return [
            (node, str(path))
            for node in self.nodes
            if node.type.outputs_as("product") and ("enabled" not in node.type.inputs or node.get("enabled"))
            for name in node.type.inputs_as("sensor")
            for path in node.get(name) or ()
        ]

    def sensors_behind(self, node: Node) -> list[str]:
        """The prims of the sensors whose render product a node gets."""
        names = node.type.inputs_as("product")
        sources = {link.source for link in self.into.get(node, ()) if link.input in names and not link.execution}
        return [path for maker, path in self.makers if maker in sources]

    def consumers(self) -> Iterator[tuple[Node, str, frozenset[str]]]:
        """Each node that asks a sensor for quantities beyond the points, the sensor's prim, and the channels."""
        for node in self.nodes:
            if node.type.inputs_as("product") and (channels := self._asked_by(node)):
                yield from ((node, path, channels) for path in self.sensors_behind(node))

    def _asked_by(self, node: Node) -> frozenset[str]:
        """The channels of a node's metadata and of its switches `output...`, as far as the file decides them."""
        chosen = node.get("selectedMetadata") if "selectedMetadata" in node.type.inputs else None
        named = [str(name) for name in chosen or ()]
        switches = [node, *(link.source for link in self.into.get(node, ()) if link.input == "selectedMetadata")]
        named += [
            name for one in switches for name in one.type.inputs if name.startswith("output") and one.get(name) is True
        ]
        return named_channels(named)

    def data_sources(self, link: Link) -> Iterator[Link]:
        """The data connections behind one, itself first, upstream through nodes without execution attributes."""
        seen: set[Link] = set()
        pending = [link]
        while pending:
            one = pending.pop()
            if one in seen or one.execution:
                continue
            seen.add(one)
            yield one
            if not one.source.type.has_execution:
                pending += self.into.get(one.source, ())


def named_channels(named: Iterable[str]) -> frozenset[str]:
    """The channels of metadata and outputs by their names."""
    from nodes.ros2.point_clouds import CLOUD_FIELDS
    from sensors.annotators.outputs import LABELS

    named = [name.removeprefix("output") for name in named]
    fields = {name: CLOUD_FIELDS[name].channel for name in named if name in CLOUD_FIELDS}
    labels = {name: LABELS.get(name[:1].lower() + name[1:], "") for name in named}
    return frozenset(filter(None, (fields.get(name) or labels[name] for name in named)))


TIMES: Mapping[Role, str] = {
    "timeline time": "timeline time, which loops and runs ahead of the physics clock",
    "loop time": "the run loop's time, which no stop resets",
}
"""The time that an output of this role gives, which is not the time of sensor stamps."""


def link_notes(links: Links) -> Iterator[Note]:
    """Warnings: stamps that are unconnected or of a wrong clock, and values that depend on the order of wires."""
    yield from _stamp_notes(links)
    yield from _order_notes(links)


def _stamp_notes(links: Links) -> Iterator[Note]:
    for link in links.all:
        if link.input not in link.target.type.inputs_as("stamp"):
            continue
        for source in links.data_sources(link):
            clock = source.source.type.find("outputs", source.output)
            if clock is not None and clock.role in TIMES:
                yield (
                    "timeline-stamp",
                    f"{link.target.path}.inputs:{link.input}",
                    f"gets {source.source.name}.{source.output}: {TIMES[clock.role]}; sensors are stamped with "
                    "IsaacReadSimulationTime.simulationTime",
                )

    for node, incoming in links.into.items():
        names = {link.input for link in incoming}
        publishes = node.type.inputs_as("topic") and any(link.execution for link in incoming)
        stamps = node.type.inputs_as("stamp") if publishes else ()
        if stamps and not any(stamp in names or node.get(stamp) for stamp in stamps):
            yield (
                "timestamp-unconnected",
                f"{node.path}.inputs:{stamps[0]}",
                "nothing gives it a time, so all its messages are stamped 0; connect "
                "IsaacReadSimulationTime.simulationTime",
            )


def nobody_consumes(sensor: str, makers: Sequence[str]) -> tuple[str, str, str]:
    """Code, place and message for a sensor that is rendered though nothing reads it; makers: the nodes that render
    it.
    """
    return "nobody-consumes", sensor, f"it is rendered for {', '.join(makers)}, but nothing asks for its channels"


def unread_products(links: Links) -> Iterator[Note]:
    """A warning for each sensor whose render products are unconnected, so that only a script could read them.

    Nothing where the path of a product is written on an input.
    """
    if any(node.get(name) for node in links.nodes for name in node.type.inputs_as("product")):
        return
    makers: dict[str, list[Node]] = {}
    for node, path in links.makers:
        makers.setdefault(path, []).append(node)
    for path, nodes in makers.items():
        wires = (link for node in nodes for link in links.out_of.get(node, ()))
        if not any(link.output in link.source.type.outputs_as("product") for link in wires):
            yield nobody_consumes(path, [node.path for node in nodes])


def _order_notes(links: Links) -> Iterator[Note]:
    for node, output, targets in links.execution_outputs():
        reached = {target: links.reached(target) for target in targets}
        for first, second in combinations(targets, 2):
            shared = reached[first] & reached[second]
            early, late = reached[first] - shared, reached[second] - shared
            if exchange := _exchange(links, early, late):
                yield (
                    "fan-out-order",
                    f"{node.path}.outputs:{output}",
                    f"{exchange} reads it in the same update only because {first.name} is wired before {second.name}; "
                    "chain them, or use Multisequence",
                )
            if exchange := _exchange(links, late, early):
                yield (
                    "fan-out-order",
                    f"{node.path}.outputs:{output}",
                    f"{exchange} reads the value of the update before, because {first.name} is wired before "
                    f"{second.name}; swap them, or use Multisequence",
                )


def _exchange(links: Links, writers: set[Node], readers: set[Node]) -> str:
    """The first data connection from one of the writers to one of the readers, as text, or ""."""
    for link in links.all:
        if link.target in readers and not link.execution:
            for source in links.data_sources(link):
                if source.source in writers:
                    return _as_text(source, link)
    return ""


def _as_text(source: Link, link: Link) -> str:
    name = link.target.name
    return f"{source.source.name}.{source.output} -> {name}.{link.input}: {name}"
