"""Resolves open types again where an edit may change them, and only there.

A region of nodes is resolved as the whole graph would be. What its neighbours know is given, and becomes known at the
same moment: along connections, from some written value, or backwards from a reader. If a neighbour would then know
something else, or at another moment, it joins the region. The result equals that of compiling the whole graph.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

from graph.base.records import dataclass, field
from graph.evaluate import Node
from graph.spec.file_spec import NodeSpec
from graph.values.types import Type

from .connections import Link
from .draft import Draft, draft_node, initial_values
from .feeds import BACKWARDS, Feed, Feeds, OtherwiseError, Stage, is_open
from .types import Known, Settling, check_types

FORWARDS: Stage = (0,)
SMALL = 32
"""A region may always have this many nodes.

Beyond it, a quarter of the graph at most: above that, compiling the whole graph costs less.
"""
Late = tuple[Stage, Draft, str, Type]
"""A type that a neighbour gets to know at a stage."""


def decline(message: str, mark: Any) -> None:
    """Takes a report's place: the compiler will report what is wrong."""
    raise OtherwiseError


@dataclass(slots=True)
class Region:
    """Nodes whose types were resolved again: their drafts, initial values and stages."""

    drafts: dict[Node, Draft] = field(default_factory=dict)
    initial: dict[Node, Mapping[str, Any]] = field(default_factory=dict)
    stages: dict[Node, dict[str, Stage]] = field(default_factory=dict)

    def type_of(self, node: Node, full: str) -> Type | None:
        """The type of an attribute, in the region or outside."""
        draft = self.drafts.get(node)
        return node.types[full] if draft is None else draft.types[full]

    def initial_of(self, node: Node, full: str) -> Any:
        """The initial value of an attribute, in the region or outside."""
        return self.initial[node][full] if node in self.initial else node.initial(full)


class _Resettling(Settling):
    """Resolves a region. `neighbours` are not resolved; `late` is what they get to know after the start."""

    def __init__(
        self, drafts: Sequence[Draft], links: Sequence[Link], neighbours: Collection[Draft], late: Sequence[Late]
    ) -> None:
        super().__init__(drafts, links, decline)
        self._refused.update(neighbours)
        self._late = late
        self._stage = FORWARDS
        self.stages: dict[tuple[Draft, str], Stage] = {}

    def run(self) -> None:
        self._run_forwards()
        written: list[tuple[Stage, bool, Draft, str, Type | None]] = [
            ((1, draft.node.index, place), False, draft, full, None)
            for draft in self._open
            for place, full in enumerate(draft.open)
            if full in draft.authored and full not in draft.fed
        ]
        for stage, late, draft, full, type_ in sorted(
            [*written, *((stage, True, draft, full, type_) for stage, draft, full, type_ in self._late)],
            key=lambda one: one[:2],
        ):
            self._stage = stage
            if late and type_ is not None:
                self._set(draft, full, type_)
            elif draft.types[full] is None:
                self._take_natural(draft, full)
            self._spread()
        self._stage = BACKWARDS
        for link in self._links:
            self._backward(link)
            self._spread()

    def _set(self, draft: Draft, full: str, type_: Type) -> None:
        super()._set(draft, full, type_)
        self.stages[draft, full] = self._stage


def settle_region(
    feeds: Feeds, start: Iterable[Node], spec_of: Callable[[Node], NodeSpec], at: Callable[[Node], Iterable[Feed]]
) -> Region:
    """Resolves these nodes, and as many more as that affects; at: the feeds of a node after the edit.

    Raises OtherwiseError if something is wrong, or if the result depends on more than is examined.
    """
    nodes = dict.fromkeys(start)
    if not nodes:
        return Region()
    while True:
        region, more = _settled(feeds, nodes, spec_of, at)
        if not more:
            return region
        _grow(nodes, more, at)
        if len(nodes) > max(SMALL, len(feeds.graph.nodes) // 4):
            raise OtherwiseError


def _grow(nodes: dict[Node, None], more: Iterable[Node], at: Callable[[Node], Iterable[Feed]]) -> None:
    """Adds nodes, and so many of their direct and indirect readers that the region doubles."""
    room = len(nodes)
    found = dict.fromkeys(more)
    for node in (pending := list(found)):
        if len(found) > room:
            break
        for feed in at(node):
            reader = feed.target
            if feed.source is node and reader not in found and reader not in nodes and is_open(reader, feed.input):
                found[reader] = None
                pending.append(reader)
    nodes.update(found)


def _settled(
    feeds: Feeds,
    nodes: Mapping[Node, None],
    spec_of: Callable[[Node], NodeSpec],
    at: Callable[[Node], Iterable[Feed]],
) -> tuple[Region, set[Node]]:
    drafts = {node: _draft(feeds, node, spec_of(node)) for node in sorted(nodes, key=lambda node: node.index)}
    neighbours: dict[Node, Draft] = {}
    found = {feed: None for node in drafts for feed in at(node)}
    links: dict[Feed, Link] = {}
    late: dict[tuple[Node, str], Late] = {}
    for feed in sorted(found, key=lambda feed: feed.number):
        ends = []
        for node in (feed.source, feed.target):
            draft = drafts.get(node) or neighbours.get(node)
            if draft is None:
                draft = neighbours[node] = _neighbour(node)
            ends.append(draft)
        link = links[feed] = Link(ends[0], feed.output, ends[1], feed.input, None, False)
        if feed.target in drafts:
            ends[1].fed[feed.input] = link
            stage = feeds.stages.get(feed.source, {}).get(feed.output)
            if feed.source in neighbours and stage is not None and stage[0] == 1:
                type_ = feed.source.types[feed.output]
                assert type_ is not None
                late[feed.source, feed.output] = (stage, ends[0], feed.output, type_)
    for _, draft, full, _ in late.values():
        draft.types[full] = None
    run = _Resettling(list(drafts.values()), list(links.values()), neighbours.values(), list(late.values()))
    run.run()
    stages = {
        node: {f: run.stages[draft, f] for f in draft.open if (draft, f) in run.stages}
        for node, draft in drafts.items()
    }
    more = {_outside(feed, drafts) for feed in links if _concerned(feed, links[feed], drafts, feeds, run.stages)}
    if more:
        return Region(), more
    for draft in drafts.values():
        _refuse_order(draft)
    check_types(list(drafts.values()), list(links.values()), decline)
    initial = {node: initial_values(draft, feeds.shape(node.type), decline) for node, draft in drafts.items()}
    return Region(drafts, initial, stages), set()


def _draft(feeds: Feeds, node: Node, spec: NodeSpec) -> Draft:
    draft = draft_node(node.graph, spec, node.type, feeds.shape(node.type), node.index, decline)
    for full, attribute in node.added.items():
        if full not in draft.dynamic:
            draft.add(full, attribute)
    if draft.dynamic.keys() != node.added.keys():
        raise OtherwiseError
    return draft


def _neighbour(node: Node) -> Draft:
    return Draft(node, node.type, NodeSpec(node.name, node.type.id), dict(node.types), (), dict(node.added))


def _outside(feed: Feed, drafts: Mapping[Node, Draft]) -> Node:
    return feed.target if feed.source in drafts else feed.source


def _concerned(
    feed: Feed,
    link: Link,
    drafts: Mapping[Node, Draft],
    feeds: Feeds,
    stages: Mapping[tuple[Draft, str], Stage],
) -> bool:
    """Whether the neighbour at the other end of a feed has to be resolved again too."""
    if feed.source in drafts and feed.target in drafts:
        return False
    outside, full, draft = (
        (feed.target, feed.input, link.target) if feed.source in drafts else (feed.source, feed.output, link.source)
    )
    if not is_open(outside, full):
        return False
    if feeds.stages.get(outside, {}).get(full) == BACKWARDS or draft.types[full] is not outside.types[full]:
        return True
    if feed.target in drafts:
        return False
    before = feed.source.types[feed.output], feeds.stages.get(feed.source, {}).get(feed.output)
    return before != (link.source.types[feed.output], stages.get((link.source, feed.output)))


def _refuse_order(draft: Draft) -> None:
    """Raises OtherwiseError if the node's answer depends on the order in which it gets to know its inputs."""
    resolve = draft.type.resolve
    open_feeds = [
        full
        for full, link in draft.fed.items()
        if draft.types[full] is not None and is_open_link(link) and full in draft.open
    ]
    if resolve is None or not open_feeds:
        return
    kept = dict(draft.types)

    def answers(masked: Iterable[str]) -> dict[str, Any]:
        draft.types = {**kept, **dict.fromkeys(masked)}
        try:
            return {name: type_ for name, type_ in (resolve(Known(draft)) or {}).items() if type_ is not None}
        except Exception as error:
            raise OtherwiseError from error
        finally:
            draft.types = kept

    certain = answers(full for full in draft.fed if full in draft.open)
    if any(answers([full]) != certain for full in open_feeds):
        raise OtherwiseError


def is_open_link(link: Link) -> bool:
    """Whether the source's declared type is open."""
    from graph.values.types import Extended

    return isinstance(link.source.attribute(link.source_name).parsed, Extended)
