"""Checks, before any change, whether an edit can be made in place, and what it then changes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from graph.base.records import dataclass
from graph.evaluate import Node
from graph.evaluate.instances import with_target
from graph.spec.file_spec import ConnectionSpec, NodeSpec
from graph.values.coercion import coerce
from graph.values.conversion import converter, convertible
from graph.values.untyped import coerced, typed_value

from .feeds import BACKWARDS, Feed, Feeds, OtherwiseError
from .order import moved_behind
from .region import settle_region

Wire = tuple[Node, str, Node, str]
"""An execution output, and the input that it is connected to."""
SpecOf = Callable[[Node], NodeSpec]
"""Gives the spec of a node after the edit."""


@dataclass(frozen=True)
class Patch:
    """What is added, by full names (`node.outputs:x`), and what is removed: nodes with all of their connections."""

    nodes: Sequence[NodeSpec] = ()
    connections: Sequence[ConnectionSpec] = ()
    values: Sequence[tuple[str, str, Any]] = ()
    """Values of existing nodes: name, full attribute name, value."""
    removed: Sequence[str] = ()
    cut: Sequence[tuple[str, str]] = ()


class CheckedPatch:
    """The changes of a patch that can be made in place. Raises OtherwiseError or UserError if it cannot."""

    def __init__(self, feeds: Feeds, patch: Patch, fresh: dict[str, Node], spec_of: SpecOf) -> None:
        graph = feeds.graph
        self.graph, self.feeds, self.fresh, self._spec_of = graph, feeds, fresh, spec_of
        self.gone = [self._node(name) for name in patch.removed]
        self.wires_cut: list[Wire] = []
        self.cut: dict[Feed, None] = {}
        self.wires: list[Wire] = []
        self.leads: dict[Feed, None] = {}
        for ends in patch.cut:
            self._note_cut(*ends)
        for connection in patch.connections:
            self._note_lead(connection)
        self._open_values: set[Node] = set()
        self.values = [one for value in patch.values if (one := self._settable(*value)) is not None]
        self.ranks = self._order()
        self.region = settle_region(feeds, self._start(), spec_of, self._feeds_at)
        self.changed = [feed for feed in self._feeds_of_region() if self._pair(feed) != feed.types]
        for feed in (*self.leads, *self.changed):
            self._check(feed)
        self.starts = self._values_of_cut()

    def _node(self, name: str) -> Node:
        node = self.fresh.get(name) or self.graph.nodes.get(name)
        if node is None:
            raise OtherwiseError
        return node

    def _end(self, end: str) -> tuple[Node, str]:
        name, _, full = end.rpartition(".")
        node = self._node(name)
        if full not in node.types:
            raise OtherwiseError
        return node, full

    def _note_cut(self, source: str, target: str) -> None:
        (at, output), (to, name) = self._end(source), self._end(target)
        for node, full in ((at, output), (to, name)):
            if full in node.added and node not in self.gone and full not in self._spec_of(node).attributes:
                raise OtherwiseError  # it existed only for the connection
        if to.attribute(name).is_execution:
            self.wires_cut.append((at, output, to, name))
            return
        feed = self.feeds.into.get(to, {}).get(name)
        if feed is None or feed.source is not at or feed.output != output:
            raise OtherwiseError
        self.cut[feed] = None

    def _note_lead(self, connection: ConnectionSpec) -> None:
        (at, output), (to, name) = self._end(connection.source), self._end(connection.target)
        declared = to.attribute(name)
        out = output.startswith("outputs:")
        mixed = declared.is_execution != at.attribute(output).is_execution
        if not name.startswith("inputs:") or declared.deprecated or mixed:
            raise OtherwiseError
        if declared.is_execution:
            if not out:
                raise OtherwiseError
            self.wires.append((at, output, to, name))
            return
        if not out and (not output.startswith("inputs:") or self._fed(at, output)):
            raise OtherwiseError
        passes = any(feed.output == name for feed in (*self.feeds.out_of.get(to, ()), *self.leads) if feed.source is to)
        if self._fed(to, name) or passes or declared.literal_only or declared.output_only or at is to:
            raise OtherwiseError
        self.leads[Feed(at, output, to, name, self.feeds.count + len(self.leads) + 1)] = None

    def _fed(self, node: Node, full: str) -> bool:
        feed = self.feeds.into.get(node, {}).get(full)
        if feed is not None and feed not in self.cut:
            return True
        return any(lead.target is node and lead.input == full for lead in self.leads)

    def _settable(self, name: str, full: str, value: Any) -> tuple[Node, str, Any] | None:
        node, full = self._end(f"{name}.{full}")
        attribute, type_ = node.attribute(full), node.types[full]
        if full.startswith("outputs:") or attribute.is_execution or attribute.deprecated or full in node.fed_names:
            raise OtherwiseError
        if self._fed(node, full) or node in self.gone:
            raise OtherwiseError
        if self.feeds.has_open(node):
            self._open_values.add(node)
            return None
        if type_ is None or with_target(value, self.graph.target) is not value:
            raise OtherwiseError
        try:
            right = typed_value(value) is None and not attribute.check(coerce(type_, value))
        except ValueError as error:
            raise OtherwiseError from error
        if not right:
            raise OtherwiseError
        return node, full, value

    def _order(self) -> dict[Node, int]:
        """New ranks if a connection leads from a later node to an earlier one."""
        late = [one for one in self.leads if one.output.startswith("outputs:") and one.source.rank >= one.target.rank]
        if not late:
            return {}
        if len(self.leads) > 1:
            raise OtherwiseError
        ranks = moved_behind(late[0].source, late[0].target)
        if ranks is None:
            raise OtherwiseError
        return ranks

    def _start(self) -> Iterator[Node]:
        """The nodes whose open types the edit may change directly."""
        feeds = self.feeds
        for node in (*self.fresh.values(), *self._open_values):
            if feeds.has_open(node):
                yield node
        for feed in (*self.cut, *self.leads):
            if feed.target not in self.gone and feeds.has_open(feed.target):
                yield feed.target
            source = feed.source
            backwards = feeds.stages.get(source, {}).get(feed.output) == BACKWARDS
            if source not in self.gone and (backwards or source.types[feed.output] is None):
                yield source

    def _feeds_at(self, node: Node) -> Iterator[Feed]:
        """The feeds of a node after the edit."""
        for feed in self.feeds.at(node):
            if feed not in self.cut:
                yield feed
        for feed in self.leads:
            if node in (feed.source, feed.target):
                yield feed

    def _feeds_of_region(self) -> dict[Feed, None]:
        found = {feed: None for node in self.region.drafts for feed in self.feeds.at(node)}
        return {feed: None for feed in found if feed not in self.cut}

    def _pair(self, feed: Feed) -> tuple[object, object]:
        region = self.region
        return region.type_of(feed.source, feed.output), region.type_of(feed.target, feed.input)

    def _check(self, feed: Feed) -> None:
        """Raises OtherwiseError if the types, or the present values, at both ends do not match."""
        region = self.region
        first, second = region.type_of(feed.source, feed.output), region.type_of(feed.target, feed.input)
        if first is None or second is None:
            if feed.source in region.drafts or feed.target in region.drafts:
                return  # resolved, and checked, there
            raise OtherwiseError
        if not convertible(first, second):
            raise OtherwiseError
        convert = converter(first, second)
        if convert is None:
            return
        values = [region.initial_of(feed.source, feed.output)]
        if first is feed.source.types[feed.output]:
            values.append(feed.source.get(feed.output))
        try:
            for value in values:
                convert(value)
        except ValueError as error:
            raise OtherwiseError from error

    def _values_of_cut(self) -> list[tuple[Node, str, Any]]:
        """The initial values of inputs of fixed type that lost their connection."""
        found = []
        for feed in self.cut:
            node, full = feed.target, feed.input
            if node in self.gone or node in self.region.drafts or self._fed(node, full):
                continue
            found.append((node, full, self._authored(node, full)))
        return found

    def _authored(self, node: Node, full: str) -> Any:
        inputs, attribute, type_ = self._spec_of(node).inputs, node.attribute(full), node.types[full]
        key = next((k for k in (full, full.partition(":")[2]) if k in inputs), None)
        if key is None:
            return attribute.initial
        if type_ is None:
            raise OtherwiseError
        raw = with_target(inputs[key], self.graph.target)
        try:
            value = coerced(type_, raw)
        except ValueError as error:
            raise OtherwiseError from error
        if attribute.check(value):
            raise OtherwiseError
        return value
