"""What differs between two states of a graph: as nodes to write to the stage, and as edits that lead to the second."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace
from typing import Any

from graph.base.records import dataclass
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec


@dataclass(frozen=True, slots=True)
class Change:
    """Names of nodes that are new or different, or whose sources are; names of those that are gone.

    links: whether connections differ.
    """

    nodes: Set[str]
    gone: Set[str]
    links: bool


def change_of(before: GraphSpec, now: GraphSpec) -> Change | None:
    """What to write of a graph that was written as `before`; None if more than nodes and connections differ."""
    if before.compounds or now.compounds or not _same_settings(before, now):
        return None
    old, new = ({one.name: one for one in spec.nodes} for spec in (before, now))
    if any("/" in name for name in new.keys() ^ old.keys()) or [one for one in new if one in old] != [
        one for one in old if one in new
    ]:
        return None
    changed = {name for name, one in new.items() if name not in old or not _same_node(old[name], one)}
    links = before.connections != now.connections
    if links:
        first, second = (set(map(_ends, spec.connections)) for spec in (before, now))
        changed |= {target.rpartition(".")[0] for _, target in first ^ second}
        # The order of the sources of an attribute counts.
        both = first & second
        kept = ([one for one in map(_ends, spec.connections) if one in both] for spec in (before, now))
        for pair in zip(*kept, strict=True):
            if pair[0] != pair[1]:
                changed |= {target.rpartition(".")[0] for _, target in pair}
    return Change(changed & new.keys(), old.keys() - new.keys(), links)


def _ends(link: ConnectionSpec) -> tuple[str, str]:
    return link.source, link.target


def _same_settings(before: GraphSpec, now: GraphSpec) -> bool:
    names = ("evaluator", "pipeline_stage", "evaluation_mode", "saved", "unfinished")
    same = all(getattr(before, name) == getattr(now, name) for name in names)
    held = before.instances is now.instances or not now.instances
    return same and held and _same(before.variables, now.variables)


def _same_node(before: NodeSpec, now: NodeSpec) -> bool:
    if before is now:
        return True
    return before.type == now.type and before.attributes == now.attributes and _same(before.inputs, now.inputs)


def _same(before: Any, now: Any) -> bool:
    if before is now:
        return True
    try:
        return bool(before == now)
    except ValueError:  # arrays
        return False


def with_short_names(spec: GraphSpec, names: Set[str] | None = None) -> GraphSpec:
    """The spec with inputs of nodes named as in files, `x` for `inputs:x`; names: of which nodes (None: all)."""
    nodes = (
        replace(one, inputs={key.removeprefix("inputs:"): value for key, value in one.inputs.items()})
        if names is None or one.name in names
        else one
        for one in spec.nodes
    )
    return replace(spec, nodes=tuple(nodes))


def differences(before: GraphSpec, now: GraphSpec) -> Iterator[dict[str, Any]]:
    """What makes the second of the first, as edits; each may fail without the others."""
    from graph.isaac.og import Keys

    old, new = {one.name: one for one in before.nodes}, {one.name: one for one in now.nodes}
    gone = [name for name, one in old.items() if name not in new or new[name].type != one.type]
    if gone:
        yield {Keys.DELETE_NODES: gone}
    for name, one in now.variables.items():
        if name not in before.variables:
            yield {Keys.CREATE_VARIABLES: [(name, one.type, one.value)]}
    cut = {(one.source, one.target) for one in before.connections} - {
        (one.source, one.target) for one in now.connections
    }
    for source, target in sorted(cut):
        if not {source.rpartition(".")[0], target.rpartition(".")[0]} & set(gone):
            yield {Keys.DISCONNECT: [(source, target)]}
    for name, node in new.items():
        fresh = name not in old or name in gone
        if fresh:
            yield {Keys.CREATE_NODES: [(name, node.type)]}
        known: dict[str, Any] = {} if fresh else dict(old[name].attributes)
        for full, kind in node.attributes.items():
            if full not in known:
                yield {Keys.CREATE_ATTRIBUTES: [(f"{name}.{full}", kind)]}
        yield from set_values(None if fresh else old[name], node)
    linked = {(one.source, one.target) for one in before.connections}
    for link in now.connections:
        if (link.source, link.target) not in linked:
            yield {Keys.CONNECT: [(link.source, link.target)]}


def set_values(before: NodeSpec | None, now: NodeSpec) -> Iterator[dict[str, Any]]:
    """The edits that give a node its new values."""
    from graph.isaac.og import Keys

    values = {} if before is None else before.inputs
    for key, value in now.inputs.items():
        if key not in values or not _same(values[key], value):
            full = key if ":" in key else f"inputs:{key}"
            yield {Keys.SET_VALUES: [(f"{now.name}.{full}", value)]}
