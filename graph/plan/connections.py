"""Resolves the ends of connections and checks whether they may be connected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from graph.base.errors import Mark
from graph.base.records import dataclass
from graph.base.suggest import did_you_mean, one_of
from graph.node.declaration import NodeType
from graph.spec.file_spec import ConnectionSpec, GraphSpec

from .draft import Draft, Report, no_attribute

Side = Literal["source", "target"]
MOST_SUGGESTIONS = 100
"""Most unknown nodes that get a suggestion, because each is compared with every existing node."""


@dataclass(eq=False, slots=True)
class Link:
    """One connection between two existing attributes."""

    source: Draft
    source_name: str
    target: Draft
    target_name: str
    mark: Mark | None
    execution: bool

    def __str__(self) -> str:
        ends = self.ends()
        return f"{ends[0]} -> {ends[1]}"

    def ends(self) -> tuple[str, str]:
        """Both ends as messages name them: with the graph's path if they are in two graphs."""
        local = self.source.node.graph is self.target.node.graph
        source, target = (d.node.name if local else d.node.path for d in (self.source, self.target))
        return f"{source}.{self.source_name}", f"{target}.{self.target_name}"

    def ends_with_types(self) -> tuple[str, str]:
        """Both ends with their types: the resolved ones, else the declared ones."""
        named = []
        for end, draft, name in zip(
            self.ends(), (self.source, self.target), (self.source_name, self.target_name), strict=True
        ):
            named.append(f"{end} ({draft.types[name] or draft.attribute(name).parsed})")
        return named[0], named[1]


class Nodes:
    """The nodes of all graphs by path. `broken` holds those of unknown type, so that each mistake is reported once."""

    def __init__(self) -> None:
        self.drafts: dict[str, Draft] = {}
        self.broken: set[str] = set()
        self.of_graph: dict[str, list[str]] = {}
        self.unknown: dict[str, str] = {}
        """What is wrong with each unknown type."""
        self._suggestions = MOST_SUGGESTIONS

    def find(self, graph: str, name: str) -> Draft | str | None:
        """The node that `name` means in a graph; its path if it is broken; None if it does not exist.

        An absolute name is `/Graph/node` or `/Graph.node`.
        """
        paths = [f"{graph}/{name}"]
        if name.startswith("/"):
            owner, _, node = name.rpartition(".")
            paths = [name, f"{owner}/{node}"]
        for path in paths:
            if path in self.drafts:
                return self.drafts[path]
            if path in self.broken:
                return path
        return None

    def near(self, graph: str, name: str) -> str:
        """The tail of a message about an unknown node; "" after the first hundred of a file."""
        self._suggestions -= 1
        if self._suggestions < 0:
            return ""
        if name.startswith("/"):
            return did_you_mean(name, (*self.drafts, *(path[::-1].replace("/", ".", 1)[::-1] for path in self.drafts)))
        return one_of(name, self.of_graph.get(graph, ()))


class _Meanings:
    """What names mean on nodes of a type, and which attributes may be connected, computed once for each type."""

    def __init__(self) -> None:
        self.names: dict[tuple[NodeType, str, Side], str] = {}
        """Full names of declared attributes."""
        self.meet: dict[tuple[NodeType, str, NodeType, str], bool] = {}
        """Pairs within one graph that may be connected, and whether they are execution."""


def link_all(specs: Sequence[GraphSpec], nodes: Nodes, report: Report) -> list[Link]:
    """Every valid connection, in file order; the others are reported."""
    links: list[Link] = []
    fan_in: dict[tuple[Draft, str], list[Link]] = {}
    known = _Meanings()
    for spec in specs:
        for connection in spec.connections:
            link = _link(spec.path, connection, nodes, known, report)
            if link is None or _repeats(link, fan_in, report):
                continue
            links.append(link)
            link.source.consumed.add(link.source_name)
            link.target.fed[link.target_name] = link
    return links


def _link(graph: str, connection: ConnectionSpec, nodes: Nodes, known: _Meanings, report: Report) -> Link | None:
    source = _end(graph, connection.source, "source", nodes, known, connection.mark, report)
    target = _end(graph, connection.target, "target", nodes, known, connection.mark, report)
    if source is None or target is None:
        if target is not None:
            target[0].refused.add(target[1])
        return None
    (at, output), (to, name) = source, target
    settled = not at.dynamic and not to.dynamic and at.node.graph is to.node.graph
    pair = at.type, output, to.type, name
    if settled and pair in known.meet:
        return Link(at, output, to, name, connection.mark, known.meet[pair])
    link = Link(at, output, to, name, connection.mark, to.attribute(name).is_execution)
    if not _may_meet(link, report):
        to.refused.add(name)
        return None
    if settled:
        known.meet[pair] = link.execution
    return link


def _end(
    graph: str, text: str, side: Side, nodes: Nodes, known: _Meanings, mark: Mark | None, report: Report
) -> tuple[Draft, str] | None:
    name, dot, attribute = text.rpartition(".")
    if not dot or not name or not attribute:
        report(f'"{text}" is not an end of a connection; write node.attribute', mark)
        return None
    draft = nodes.drafts.get(f"{graph}/{name}") or nodes.find(graph, name)
    if isinstance(draft, str):
        return None
    if draft is None:
        where = "" if name.startswith("/") else f" in graph {graph}"
        report(f'no node "{name}"{where}{nodes.near(graph, name)}', mark)
        return None
    if draft.dynamic:
        full = _attribute(draft, attribute, side)
    else:
        key = draft.type, attribute, side
        full = known.names.get(key) or _attribute(draft, attribute, side)
        if full is not None and not draft.dynamic:
            known.names[key] = full
    if full is None:
        kind = "output" if side == "source" else "input"
        report(f"{draft.label} {no_attribute(draft, kind, attribute.partition(':')[2] or attribute)}", mark)
        return None
    return draft, full


def _attribute(draft: Draft, written: str, side: Side) -> str | None:
    """The attribute that a short or full name means on this side of a connection."""
    prefix, _, name = written.partition(":")
    if prefix in ("inputs", "outputs", "state") and name:
        return draft.find(prefix, name)
    if side == "target":
        declared = draft.find("inputs", written, add=False) or draft.find("state", written, add=False)
        return declared or draft.find("inputs", written)
    outputs = draft.find("outputs", written)
    # A dynamic input can be a source only if it exists already: otherwise any misspelt output would be one.
    return outputs or draft.find("inputs", written, add=False) or draft.find("state", written, add=False)


def _may_meet(link: Link, report: Report) -> bool:
    """Whether the attributes may be connected; reports connections that are wrong whatever the types are."""
    source, target = link.source.attribute(link.source_name), link.target.attribute(link.target_name)
    mixed = source.is_execution != target.is_execution
    if link.target_name.startswith("outputs:"):
        message = "{target} is an output; a connection ends at an input"
    elif mixed:
        message = "{source} cannot feed {target}: execution and data do not mix"
    elif source.is_execution and not link.source_name.startswith("outputs:"):
        message = "{source} is an execution input; execution starts at an output"
    elif source.is_execution and link.source.node.graph is not link.target.node.graph:
        message = "{source} cannot start {target}: execution does not cross graphs; send a custom event"
    elif target.literal_only:
        message = "{target} cannot be connected; write its value under inputs"
    elif target.output_only:
        message = "{target} is only a source; connect from it, not to it"
    else:
        return True
    source_end, target_end = link.ends_with_types() if mixed else link.ends()
    report(message.format(source=source_end, target=target_end), link.mark)
    return False


def _repeats(link: Link, fan_in: dict[tuple[Draft, str], list[Link]], report: Report) -> bool:
    """Reports a connection that is written twice, and a second source of a data input."""
    end = link.target, link.target_name
    others = fan_in.get(end)
    if others is None:
        fan_in[end] = [link]
        return False
    for other in others:
        if (other.source, other.source_name) == (link.source, link.source_name):
            report(f"{link} is written twice; remove one", link.mark)
            return True
    if not link.execution:
        first = others[0]
        at = f" (at {first.mark})" if first.mark else ""
        source, target = link.ends()
        report(f"{target} has two sources, {first.ends()[0]}{at} and {source}; a data input takes one", link.mark)
        return True
    others.append(link)
    return False


def by_attribute(links: Sequence[Link]) -> Mapping[tuple[Draft, str], list[Link]]:
    """The links at each attribute, at either end."""
    found: dict[tuple[Draft, str], list[Link]] = {}
    for link in links:
        found.setdefault((link.source, link.source_name), []).append(link)
        found.setdefault((link.target, link.target_name), []).append(link)
    return found
