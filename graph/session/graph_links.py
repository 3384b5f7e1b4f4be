"""The connections of compiled graphs, node to node, and the order in which execution runs along them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from graph.evaluate.links import Link, links_of

if TYPE_CHECKING:
    from graph.evaluate import Graph, Node


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
