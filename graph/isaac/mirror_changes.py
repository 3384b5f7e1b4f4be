"""What a stage says of a graph, and the edits that lead from one such state to another."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from graph.base.records import dataclass
from graph.spec.file_spec import GraphSpec, NodeSpec

Ends = tuple[str, str]
"""A connection by both full ends: `tick.outputs:tick`, absolute for a node of another graph."""


@dataclass(slots=True)
class State:
    """A graph at one moment.

    rest: its spec without nodes and connections. nodes: by name, inputs named as in files, `x` for `inputs:x`. links:
    the connections into each node that has any, in order.
    """

    rest: GraphSpec
    nodes: dict[str, NodeSpec]
    links: dict[str, dict[Ends, None]]

    def part(self, names: set[str]) -> State:
        """The state of these nodes alone."""
        nodes = {name: self.nodes[name] for name in names if name in self.nodes}
        return State(self.rest, nodes, {name: self.links[name] for name in nodes if name in self.links})

    def ends(self) -> dict[Ends, None]:
        """All connections."""
        return {ends: None for links in self.links.values() for ends in links}


def owner(end: str) -> str:
    """The node of a connection's end."""
    return end.rpartition(".")[0]


def same(before: Any, now: Any) -> bool:
    """Whether two values are equal; arrays are compared by identity alone."""
    if before is now:
        return True
    try:
        return bool(before == now)
    except ValueError:
        return False


Default = Callable[[NodeSpec, str], Any]
"""Gives the default of an attribute of a node by full name; None without one."""


def edits(before: State, now: State, default: Default) -> Iterator[dict[str, Any]]:
    """What makes the second of the first, as edits; each may fail without the others."""
    from graph.isaac.og import Keys

    gone = [name for name, one in before.nodes.items() if name not in now.nodes or now.nodes[name].type != one.type]
    lost = set(gone)
    if gone:
        yield {Keys.DELETE_NODES: gone}
    for name, one in now.rest.variables.items():
        if name not in before.rest.variables:
            yield {Keys.CREATE_VARIABLES: [(name, one.type, one.value)]}
    old, new = before.ends(), now.ends()
    for source, target in old:
        if (source, target) not in new and not {owner(source), owner(target)} & lost:
            yield {Keys.DISCONNECT: [(source, target)]}
    for name, node in now.nodes.items():
        was = None if name in lost else before.nodes.get(name)
        if was is node:
            continue
        if was is None:
            yield {Keys.CREATE_NODES: [(name, node.type)]}
        for full, kind in node.attributes.items():
            if was is None or full not in was.attributes:
                yield {Keys.CREATE_ATTRIBUTES: [(f"{name}.{full}", kind)]}
        for full, value in _values(was, node, default):
            yield {Keys.SET_VALUES: [(f"{name}.{full}", value)]}
    for source, target in new:
        if (source, target) not in old or {owner(source), owner(target)} & lost:
            yield {Keys.CONNECT: [(source, target)]}


def _values(before: NodeSpec | None, now: NodeSpec, default: Default) -> Iterator[tuple[str, Any]]:
    """Full names of attributes with new values, and these; one that has lost its value gets its default."""
    values: Mapping[str, Any] = {} if before is None else before.inputs
    for key in dict.fromkeys((*values, *now.inputs)):
        full = key if ":" in key else f"inputs:{key}"
        if key not in now.inputs:
            if (value := default(now, full)) is not None:
                yield full, value
        elif key not in values or not same(values[key], now.inputs[key]):
            yield full, now.inputs[key]
