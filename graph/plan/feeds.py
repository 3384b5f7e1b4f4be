"""The data connections of a graph by node: an edit in place looks at these instead of the whole graph."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from graph.base.records import dataclass, field
from graph.evaluate import Graph, Node
from graph.evaluate.rewiring import renew_pushes
from graph.evaluate.wire import Copy, copy_between
from graph.node.declaration import NodeType
from graph.values.conversion import converter
from graph.values.types import Extended

from .draft import Shape

Stage = tuple[int, ...]
"""When a type was resolved: (0,) along connections, (1, node, attribute) from that written value, BACKWARDS."""
BACKWARDS: Stage = (2,)
End = tuple[Node, str]


class OtherwiseError(Exception):
    """The edit cannot be made in place."""


@dataclass(eq=False, slots=True)
class Feed:
    """A data connection: `copy` writes the value of `output` of the source to `input` of the target (full names)."""

    source: Node
    output: str
    target: Node
    input: str
    number: int
    """Later connections have larger numbers."""
    copy: Copy = field(init=False, default=lambda: None)

    @property
    def types(self) -> tuple[object, object]:
        """The resolved types of both ends."""
        return self.source.types[self.output], self.target.types[self.input]

    def made(self) -> Copy:
        """A copy function for the present types."""
        part, _, output = self.output.partition(":")
        first, second = self.source.types[self.output], self.target.types[self.input]
        convert = None if first is None or second is None else converter(first, second)
        source, sink = getattr(self.source.db, part), self.target.db.inputs
        return copy_between(source, output, sink, self.input.partition(":")[2], convert)


class Feeds:
    """The feeds of one graph by either end, in the order of the connections, and when its open types were resolved."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.into: dict[Node, dict[str, Feed]] = {}
        self.out_of: dict[Node, dict[Feed, None]] = {}
        self.stages: dict[Node, dict[str, Stage]] = {}
        self.shapes: dict[NodeType, Shape] = {}
        self.count = 0
        """Count so far; also the last one's number."""

    def add(self, source: Node, output: str, target: Node, name: str) -> Feed:
        """A new feed, after all others, without a copy function yet."""
        self.count += 1
        feed = Feed(source, output, target, name, self.count)
        self.into.setdefault(target, {})[name] = feed
        self.out_of.setdefault(source, {})[feed] = None
        return feed

    def remove(self, feed: Feed) -> None:
        """Removes a feed."""
        del self.into[feed.target][feed.input]
        del self.out_of[feed.source][feed]

    def forget(self, node: Node) -> None:
        """Removes a node without feeds."""
        self.into.pop(node, None)
        self.out_of.pop(node, None)
        self.stages.pop(node, None)

    def at(self, node: Node) -> Iterator[Feed]:
        """The feeds into and out of a node."""
        yield from self.into.get(node, {}).values()
        yield from self.out_of.get(node, ())

    def has_open(self, node: Node) -> bool:
        """Whether the node's types depend on its values and connections."""
        if node.type.resolve is not None or self.shape(node.type).open:
            return True
        return any(isinstance(one.parsed, Extended) for one in node.added.values())

    def shape(self, node_type: NodeType) -> Shape:
        """What all nodes of this type share."""
        found = self.shapes.get(node_type)
        if found is None:
            found = self.shapes[node_type] = Shape.of(node_type)
        return found


def feeds_of(graph: Graph) -> Feeds:
    """The feeds of a graph.

    Raises OtherwiseError if an input passes its value on, because such a connection is not one feed.
    """
    feeds = Feeds(graph)
    for connection in graph.spec.connections:
        at, output = _end_as_written(graph, connection.source, ("outputs", "inputs", "state"))
        to, name = _end_as_written(graph, connection.target, ("inputs", "state"))
        if to.attribute(name).is_execution:
            continue
        if not name.startswith("inputs:") or (output.startswith("inputs:") and output in at.fed_names):
            raise OtherwiseError
        feeds.add(at, output, to, name)
    pushes: dict[Node, list[Copy]] = {}
    for node, leads in feeds.out_of.items():
        passes: dict[str, list[Copy]] = {}
        for feed in leads:
            feed.copy = feed.made()
            to_list = pushes.setdefault(node, []) if not feed.output.startswith("inputs:") else None
            (passes.setdefault(feed.output, []) if to_list is None else to_list).append(feed.copy)
        node.passes, node.pushes = passes, pushes.get(node, [])
        renew_pushes(node)
    graph.starts = {
        feed.copy: None
        for leads in feeds.into.values()
        for feed in leads.values()
        if feed.source.types[feed.output] is not None
    }
    return feeds


def _end_as_written(graph: Graph, text: str, prefixes: Sequence[str]) -> End:
    owner, _, attribute = text.rpartition(".")
    for separator in "/.":
        owner = owner.removeprefix(f"{graph.path}{separator}")
    node = graph.nodes.get(owner)
    if node is None:
        raise OtherwiseError
    full = next((f for f in (attribute, *(f"{one}:{attribute}" for one in prefixes)) if f in node.types), None)
    if full is None:
        raise OtherwiseError
    return node, full


def is_open(node: Node, full: str) -> bool:
    """Whether the type of an attribute depends on values and connections."""
    return isinstance(node.attribute(full).parsed, Extended)
