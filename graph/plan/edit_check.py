"""Whether an edit of a compiled graph is right, seen from the nodes that it concerns, so that compiling it can wait.

Accepts only edits whose effect ends at these nodes: no type, order or attribute of another node may follow from them.
All others, and all wrong ones, are left to the compiler, which sees the whole graph and reports the mistakes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from graph.base.errors import Mark
from graph.base.records import dataclass
from graph.evaluate.graph import Graph
from graph.node.declaration import NodeType
from graph.node.registry import Registry
from graph.spec.file_spec import ConnectionSpec, NodeSpec
from graph.values.conversion import converter
from graph.values.types import INTEGER_RANGES, Extended

from .compiler import NODE_NAME
from .connections import Link, Nodes, link_all
from .draft import BACKWARDS, Draft, Shape, all_names, draft_node, initial_values
from .types import settle_types

Ends = tuple[str, str]
"""The full ends of a connection, `node.outputs:x`."""


@dataclass(frozen=True, slots=True)
class EditedPart:
    """What an edit concerns, as it is after the edit."""

    nodes: Sequence[NodeSpec]
    """New nodes, and those with other values or other connections to them."""
    added: Sequence[Ends]
    cut: Sequence[Ends]
    around: Callable[[str], Iterable[ConnectionSpec]]
    """The connections from and to a node, by full ends."""


class EditCheck:
    """Checks one edit after another of a graph that is compiled later."""

    def __init__(self, graph: Graph, registry: Registry) -> None:
        self._graph = graph
        self._registry = registry
        self._shapes: dict[NodeType, Shape] = {}
        self._count = 1 + max((node.index for node in graph.members.values()), default=0)
        """Larger than the index of any node."""
        self._known: dict[str, Draft] = {}
        """The nodes that the accepted edits concern."""
        self.exact = True
        """Whether the types of all other nodes, and the way in which these get theirs, are certain."""

    def accepts(self, part: EditedPart) -> Sequence[Draft] | None:
        """The nodes that an edit concerns, with attribute names where they are new; None if it must be compiled."""
        nodes, problems = Nodes(), list[str]()

        def report(message: str, mark: Mark | None) -> None:
            problems.append(message)

        before = {node.name: self._before(node.name) for node in part.nodes}
        changed: dict[str, Draft] = {}
        for node in sorted(part.nodes, key=lambda node: old.node.index if (old := before[node.name]) else BACKWARDS):
            node_type, old = self._registry.get(node.type), before[node.name]
            index = old.node.index if old else self._count + len(changed)
            changed[node.name] = draft_node(self._graph, node, node_type, self._shape(node_type), index, report)
        connections = {id(one): one for name in changed for one in part.around(name)}.values()
        ends = [*((one.source, one.target) for one in connections), *part.cut]
        others = {name: self._before(name) for pair in ends for name in map(_owner, pair) if name not in changed}
        known = {name: draft for name, draft in others.items() if draft is not None}
        attributes = {name: len(draft.dynamic) for name, draft in known.items()}
        if len(known) < len(others) or not all(map(NODE_NAME.fullmatch, changed)):
            return None
        every = {**changed, **known}
        nodes.drafts = {draft.node.path: draft for draft in every.values()}
        links = link_all([replace(self._graph.compiled_spec, connections=tuple(connections))], nodes, report)
        settle_types([*changed.values()], links, report)
        for draft in changed.values():
            initial_values(draft, self._shape(draft.type), report)
        if (
            problems
            or any(len(known[name].dynamic) != count for name, count in attributes.items())
            or any(old and old.dynamic.keys() != changed[name].dynamic.keys() for name, old in before.items())
            or not all(_ends_here(link, before) for link in links if not link.execution)
            or any(_passes_on(pair, part) for pair in (*part.added, *part.cut))
            or any(
                _is_open_after(self._before(_owner(source)), _attribute(source), BACKWARDS) for source, _ in part.cut
            )
            or any(_leads_back(link, part) for link in links if not link.execution)
        ):
            return None
        for name, draft in changed.items():
            if before[name] is None:
                draft.node.names, draft.node.added = all_names(draft, self._shape(draft.type)), draft.dynamic
        self._known.update(every)
        self._count += len(changed)
        self.exact &= not any(map(_depends_on_order, changed.values()))
        return [*every.values()]

    def forget(self, name: str) -> None:
        """Drops what is known of a node that is removed."""
        self._known.pop(name, None)

    def _shape(self, node_type: NodeType) -> Shape:
        found = self._shapes.get(node_type)
        if found is None:
            found = self._shapes[node_type] = Shape.of(node_type)
        return found

    def _before(self, name: str) -> Draft | None:
        """A node before the edit, with its types as they are; None for a new one, and for one of another graph."""
        old = self._known.get(name) or self._graph.members.get(name)
        if old is None:
            return None
        node, added = (old.node, old.dynamic) if isinstance(old, Draft) else (old, old.added)
        spec = NodeSpec(name, node.type.id)
        return Draft(node, node.type, spec, dict(old.types), (), dict(added), late=dict(old.late))


def _owner(end: str) -> str:
    return end.rpartition(".")[0]


def _attribute(end: str) -> str:
    return end.rpartition(".")[2]


def _is_open_after(draft: Draft | None, full: str, index: int) -> bool:
    """Whether the type of an attribute is unknown, or follows from what is read at this index or later."""
    if draft is None or full not in draft.types:
        return True
    return draft.types[full] is None or draft.late.get(full, -1) >= index


def _depends_on_order(draft: Draft) -> bool:
    """Whether the types of a node may follow from the order in which it gets to know those of its sources."""
    links = [link for full, link in draft.fed.items() if full in draft.open]
    chained = (isinstance(link.source.attribute(link.source_name).parsed, Extended) for link in links)
    return draft.type.resolve is not None and len(links) > 1 and any(chained)


def _ends_here(link: Link, before: Mapping[str, Draft | None]) -> bool:
    """Whether the nodes at the ends of a data connection get nothing else from it than what is known of them now."""
    source, target = link.source.types[link.source_name], link.target.types[link.target_name]
    if _is_open_after(link.source, link.source_name, link.target.node.index):
        return False
    old = before.get(link.source.node.name)
    if old is not None and link.target.node.name not in before:
        was = old.types.get(link.source_name), old.late.get(link.source_name)
        if was != (source, link.source.late.get(link.source_name)):
            return False
    if source is None or target is None or converter(source, target) is None:
        return True
    return target.number and target.storage not in INTEGER_RANGES  # else a value may not fit


def _passes_on(pair: Ends, part: EditedPart) -> bool:
    """Whether a connection is part of a chain through an input, where it changes what nodes farther off read."""
    source, target = pair
    return any(one.target == source for one in part.around(_owner(source))) or any(
        one.source == target for one in part.around(_owner(target))
    )


def _leads_back(link: Link, part: EditedPart) -> bool:
    """Whether a new data connection may close a cycle."""
    start, end = link.source.node.name, link.target.node.name
    if (f"{start}.{link.source_name}", f"{end}.{link.target_name}") not in part.added:
        return False
    seen = {end: None}
    for name in (pending := [end]):
        fresh = [owner for one in part.around(name) if (owner := _owner(one.target)) not in seen]
        seen.update(dict.fromkeys(fresh))
        pending += fresh
    return start in seen
