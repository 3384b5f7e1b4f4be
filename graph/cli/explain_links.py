"""The connections of compiled graphs, node to node, and the order in which execution runs along them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graph.evaluate import Graph, Node
    from graph.spec.file_spec import GraphSpec


@dataclass(frozen=True, slots=True)
class Link:
    """One connection, in file order; attribute names without prefix."""

    source: Node
    output: str
    target: Node
    input: str
    execution: bool


class Links:
    """Every connection between nodes of these graphs; the ports of compounds are left out."""

    def __init__(self, specs: Iterable[GraphSpec], graphs: Mapping[str, Graph]) -> None:
        self._nodes = {node.path: node for graph in graphs.values() for node in graph.nodes.values()}
        self.all = [
            Link(*source, *target, target[0].attribute(f"inputs:{target[1]}").is_execution)
            for spec in specs
            for connection in spec.connections
            if (source := self._end(spec.path, connection.source, "outputs"))
            and (target := self._end(spec.path, connection.target, "inputs"))
        ]
        self.into: dict[Node, list[Link]] = {}
        self.out_of: dict[Node, list[Link]] = {}
        for link in self.all:
            self.into.setdefault(link.target, []).append(link)
            self.out_of.setdefault(link.source, []).append(link)

    def _end(self, graph: str, text: str, side: str) -> tuple[Node, str] | None:
        name, _, attribute = text.rpartition(".")
        owner, _, last = name.rpartition(".")
        places = (name, f"{owner}/{last}") if name.startswith("/") else (f"{graph}/{name}",)
        node = next((self._nodes[place] for place in places if place in self._nodes), None)
        short = attribute.removeprefix(f"{side}:")
        return (node, short) if node is not None and short in node.names[side] else None

    def execution_outputs(self) -> Iterator[tuple[Node, str, list[Node]]]:
        """(node, output, targets in file order) of each execution output that leads to two nodes or more."""
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
        """The data connections behind one, itself first, back through nodes that have no execution."""
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
