"""What differs between two states of a graph: as nodes to write to the stage, and as edits that lead to the second."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from graph.base.records import dataclass
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec

Ends = tuple[str, str]


@dataclass(slots=True)
class State:
    """A graph at one moment: its nodes by name, and its spec for all the rest."""

    spec: GraphSpec
    nodes: dict[str, NodeSpec]

    @classmethod
    def of(cls, spec: GraphSpec) -> State:
        """The state that a spec describes."""
        return cls(spec, {one.name: one for one in spec.nodes})


@dataclass(frozen=True, slots=True)
class Change:
    """What is new or different, and what is gone.

    fed: names of nodes that have other sources, or the same in another order. rest: whether anything beside nodes and
    connections differs, or the order of the nodes.
    """

    nodes: Mapping[str, NodeSpec]
    gone: list[str]
    cut: list[Ends]
    linked: list[Ends]
    fed: set[str]
    rest: bool


def change_of(before: State, now: State) -> Change:
    """What leads from one state to the next. Equal objects cost nothing but their comparison by identity."""
    old, new = before.nodes, now.nodes
    nodes = {
        name: one
        for name, one in new.items()
        if (was := old.get(name)) is not one and (was is None or not _same_node(was, one))
    }
    gone = [name for name in old if name not in new]
    cut: list[Ends] = []
    linked: list[Ends] = []
    fed: set[str] = set()
    if before.spec.connections != now.spec.connections:
        first, second = (dict.fromkeys(map(_ends, state.spec.connections)) for state in (before, now))
        cut = [one for one in first if one not in second]
        linked = [one for one in second if one not in first]
        fed = {owner(target) for _, target in (*cut, *linked)}
        both = zip((one for one in first if one in second), (one for one in second if one in first), strict=True)
        fed |= {owner(two[1]) for one, two in both if one != two}
    moved = len(new) + len(gone) != len(old) or bool(gone)
    rest = not _same_settings(before.spec, now.spec) or (
        moved and [one for one in new if one in old] != [one for one in old if one in new]
    )
    return Change(nodes, gone, cut, linked, fed, rest)


def owner(end: str) -> str:
    """The node of a connection's end."""
    return end.rpartition(".")[0]


def _ends(link: ConnectionSpec) -> Ends:
    return link.source, link.target


def _same_settings(before: GraphSpec, now: GraphSpec) -> bool:
    if before.compounds or now.compounds:
        return False
    names = ("evaluator", "pipeline_stage", "evaluation_mode", "saved", "unfinished")
    same = all(getattr(before, name) == getattr(now, name) for name in names)
    held = before.instances is now.instances or not now.instances
    return same and held and _same(before.variables, now.variables)


def _same_node(before: NodeSpec, now: NodeSpec) -> bool:
    return before.type == now.type and before.attributes == now.attributes and _same(before.inputs, now.inputs)


def _same(before: Any, now: Any) -> bool:
    if before is now:
        return True
    try:
        return bool(before == now)
    except ValueError:  # arrays
        return False


def with_short_names(spec: GraphSpec, nodes: Iterable[NodeSpec]) -> GraphSpec:
    """The spec with these nodes, whose inputs are named as in files, `x` for `inputs:x`."""
    return replace(
        spec,
        nodes=tuple(
            replace(one, inputs={key.removeprefix("inputs:"): value for key, value in one.inputs.items()})
            for one in nodes
        ),
    )


def edits(before: State, now: State) -> Iterator[dict[str, Any]]:
    """What makes the second of the first, as edits; each may fail without the others."""
    from graph.isaac.og import Keys

    change = change_of(before, now)
    old = before.nodes
    gone = [*change.gone, *(name for name, one in change.nodes.items() if name in old and old[name].type != one.type)]
    if gone:
        yield {Keys.DELETE_NODES: gone}
    for name, one in now.spec.variables.items():
        if name not in before.spec.variables:
            yield {Keys.CREATE_VARIABLES: [(name, one.type, one.value)]}
    for source, target in sorted(change.cut):
        if not {owner(source), owner(target)} & set(gone):
            yield {Keys.DISCONNECT: [(source, target)]}
    for name, node in change.nodes.items():
        was = None if name in gone else old.get(name)
        if was is None:
            yield {Keys.CREATE_NODES: [(name, node.type)]}
        known: Mapping[str, Any] = {} if was is None else was.attributes
        for full, kind in node.attributes.items():
            if full not in known:
                yield {Keys.CREATE_ATTRIBUTES: [(f"{name}.{full}", kind)]}
        for full, value in set_values(was, node):
            yield {Keys.SET_VALUES: [(f"{name}.{full}", value)]}
    for ends in change.linked:
        yield {Keys.CONNECT: [ends]}


def set_values(before: NodeSpec | None, now: NodeSpec) -> Iterator[tuple[str, Any]]:
    """Full names of attributes with new values, and these."""
    values: Mapping[str, Any] = {} if before is None else before.inputs
    for key, value in now.inputs.items():
        if key not in values or not _same(values[key], value):
            yield key if ":" in key else f"inputs:{key}", value
