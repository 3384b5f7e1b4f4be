"""Turns checked connections into copies, wires and an order: everything that is decided before a run."""

from __future__ import annotations

from collections.abc import Sequence

from graph.base.records import dataclass
from graph.base.shorten import listed
from graph.evaluate.node import Node
from graph.evaluate.wire import Copy, Wire, copy_between
from graph.node.database import Database
from graph.values.conversion import Converter, converter

from .connections import Link
from .draft import Draft, Report
from .order import cycles, dependency_order

End = tuple[Draft, str]

MOST_CYCLES = 20
"""Most cycles that one report names."""


@dataclass(slots=True)
class Flow:
    """Where an attribute's value comes from, through inputs that only pass it on."""

    origin: Draft
    name: str
    convert: Converter | None
    link: Link


def flows(links: Sequence[Link], report: Report) -> dict[End, Flow]:
    """The flow into each connected data attribute; inputs that feed each other in a cycle are reported."""
    feeding = {(link.target, link.target_name): link for link in links if not link.execution}
    found: dict[End, Flow] = {}
    converters: dict[tuple[int, int], Converter | None] = {}

    def step(link: Link) -> Converter | None:
        key = id(link.source.types[link.source_name]), id(link.target.types[link.target_name])
        if key not in converters:
            converters[key] = _converter(link)
        return converters[key]

    for end, first in feeding.items():
        if (first.source, first.source_name) not in feeding:  # from an output, the usual case
            found[end] = Flow(first.source, first.source_name, step(first), first)
            continue
        chain: list[End] = []
        seen: set[End] = set()
        here = end
        while here in feeding and here not in found and here not in seen:
            seen.add(here)
            chain.append(here)
            link = feeding[here]
            here = (link.source, link.source_name)
        if here in seen:
            ring = [feeding[one] for one in chain[chain.index(here) :]]
            _report_cycle(ring[::-1], report)
            feeding_ring = set(chain)
            for one in feeding_ring:
                found[one] = Flow(one[0], one[1], None, feeding[one])
            continue
        for one in reversed(chain):
            link = feeding[one]
            behind = found.get((link.source, link.source_name))
            if behind is None:
                found[one] = Flow(link.source, link.source_name, step(link), link)
            else:
                found[one] = Flow(behind.origin, behind.name, _compose(behind.convert, step(link)), link)
    return found


def _converter(link: Link) -> Converter | None:
    source, target = link.source.types[link.source_name], link.target.types[link.target_name]
    if source is None or target is None:
        return None
    try:
        return converter(source, target)
    except TypeError:  # reported where types are settled
        return None


def _compose(first: Converter | None, second: Converter | None) -> Converter | None:
    if first is None or second is None:
        return first or second
    inner, outer = first, second
    return lambda value: outer(inner(value))


def rank(drafts: Sequence[Draft], found: dict[End, Flow], report: Report) -> None:
    """Gives every node its place in the dependency order over all graphs; reports data cycles hop by hop."""
    number = {draft: position for position, draft in enumerate(drafts)}
    readers: list[list[int]] = [[] for _ in drafts]
    hops: dict[tuple[int, int], Flow] = {}
    for (target, _), flow in found.items():
        if not flow.name.startswith("inputs:"):
            hop = (number[flow.origin], number[target])
            if hop not in hops:
                hops[hop] = flow
                readers[hop[0]].append(hop[1])
    order = dependency_order(len(drafts), readers)
    for position, index in enumerate(order):
        drafts[index].node.rank = position
    if len(order) < len(drafts):
        for cycle in cycles(len(drafts), readers, most=MOST_CYCLES):
            ring = [hops[source, target].link for source, target in zip(cycle, [*cycle[1:], cycle[0]], strict=True)]
            _report_cycle(ring, report)


def _report_cycle(ring: Sequence[Link], report: Report) -> None:
    hops = listed([*map(str, ring)])
    message = f"data goes round in a cycle: {hops}. Remove one of these connections, or pass the value on by a variable"
    report(message, ring[-1].mark)


class _Wiring:
    """The copies and neighbours of one node while they are collected."""

    __slots__ = ("passes", "pushes", "readers", "sources", "wires")

    def __init__(self) -> None:
        self.pushes: list[Copy] = []
        self.passes: dict[str, list[Copy]] = {}
        self.sources: dict[Node, None] = {}
        self.readers: dict[Node, None] = {}
        self.wires: dict[str, list[Wire]] = {}


def wire(drafts: Sequence[Draft], links: Sequence[Link], found: dict[End, Flow], report: Report) -> None:
    """Connects the built nodes: data by copies from each origin to all its readers, execution by wires.

    Every reader gets the initial value of its source; a value that does not fit is reported.
    """
    wirings = {draft: _Wiring() for draft in drafts}
    ends: dict[Wire, list[tuple[Database, str]]] = {}
    for link in links:
        if link.execution:
            wire = link.source.node.db._wires[link.source_name.partition(":")[2]]
            wirings[link.target].wires.setdefault(link.target_name, []).append(wire)
            ends.setdefault(wire, []).append((link.target.node.db, link.target_name.partition(":")[2]))
    for (target, name), flow in found.items():
        copy = _copy(flow, target, name)
        origin = wirings[flow.origin]
        origin.readers[target.node] = None
        if flow.name.startswith("inputs:"):
            origin.passes.setdefault(flow.name, []).append(copy)
        else:
            origin.pushes.append(copy)
            wirings[target].sources[flow.origin.node] = None
            if _needs_telling(flow.origin.node, target.node):
                origin.pushes.append(_teller(target.node))
        _start(copy, flow, target, report)
    for draft, wiring in wirings.items():
        draft.node.connect(
            frozenset(draft.fed),
            frozenset(draft.consumed),
            tuple(wiring.sources),
            tuple(wiring.readers),
            wiring.pushes,
            wiring.passes,
            wiring.wires,
            draft.unset,
        )
    for wire, targets in ends.items():  # in file order, after all nodes are connected
        wire.lead_to(targets)


def _start(copy: Copy, flow: Flow, target: Draft, report: Report) -> None:
    """Makes a copy for the first time, and has both graphs repeat it when they start again."""
    origin_graph, target_graph = flow.origin.node.graph, target.node.graph
    if origin_graph is not target_graph:
        origin_graph.linked.add(target_graph.path)
        target_graph.linked.add(origin_graph.path)
    if flow.origin.types[flow.name] is None:
        return
    try:
        copy()
    except ValueError as error:
        source, reader = flow.link.ends()
        report(f"{source} cannot feed {reader}: {error}", flow.link.mark)
    target_graph.starts[copy] = None
    if origin_graph is not target_graph:
        origin_graph.starts[copy] = None


def _copy(flow: Flow, target: Draft, name: str) -> Copy:
    source_prefix, _, source_name = flow.name.partition(":")
    target_prefix, _, target_name = name.partition(":")
    source, sink = getattr(flow.origin.node.db, source_prefix), getattr(target.node.db, target_prefix)
    return copy_between(source, source_name, sink, target_name, flow.convert)


def _needs_telling(source: Node, reader: Node) -> bool:
    """Whether the reader's graph must be notified of new values: it is lazy and not the source's own graph."""
    return reader.graph is not source.graph and reader.graph.evaluator == "dirty_push"


def _teller(reader: Node) -> Copy:
    # Through its db: an edit hands the db of a newly compiled node to the existing Node object.
    db = reader.db
    return lambda: db._node.graph.touched(db._node)
