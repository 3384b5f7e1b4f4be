"""Small edits of a compiled graph, made in place: what they do not concern is not looked at.

New nodes, connections behind all that there are and values have their effect where they are made, as long as no open
type, no order of computing and no other graph depends on them. Whatever else an edit does, or does wrong, is left to
the compiler, which sees the whole graph and says what is wrong.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from graph.conversion import converter, convertible
from graph.errors import UserError
from graph.evaluate import Graph, Node
from graph.evaluate.instances import with_target
from graph.evaluate.wire import Copy, copy_between
from graph.registry import Registry
from graph.spec import ConnectionSpec, NodeSpec
from graph.types import Extended
from graph.untyped import typed_value
from graph.values import coerce

from .compiler import compile_graphs


@dataclass(frozen=True)
class Patch:
    """New nodes, connections with both ends in full (`node.outputs:x`), values by node and full attribute name."""

    nodes: Sequence[NodeSpec] = ()
    connections: Sequence[ConnectionSpec] = ()
    values: Sequence[tuple[str, str, Any]] = ()


class _OtherwiseError(Exception):
    """The edit is not one that can be made in place."""


@dataclass(frozen=True, slots=True)
class _Lead:
    """A connection to be added; `copy` brings the value of a data connection, whose source may be a set input."""

    source: Node
    output: str
    target: Node
    input: str
    copy: Copy | None


def apply_patch(graph: Graph, patch: Patch, registry: Registry) -> bool:
    """Makes the edit in a graph that is not being evaluated; False, and nothing is changed, if it must be compiled."""
    if graph.linked or graph.instances or graph.spec.instances or graph.observed:
        return False
    if graph.evaluator == "dirty_push" and graph.evaluator_state is not None:
        return False  # it knows what has changed since it ran
    try:
        fresh, starts, apart = _compiled(graph, patch, registry)
        leads = _leads(graph, fresh, () if apart else patch.connections)
        values = [_settable(graph, *one) for one in patch.values]
    except (_OtherwiseError, UserError):
        return False
    fed = {(lead.target, lead.input) for lead in leads}
    if any((node, full) in fed for node, full, _ in values):
        return False
    graph.add(fresh, starts)
    for node, full, value in values:
        node.set(full, value)
    for lead in leads:
        if lead.copy is None:
            lead.source.lead_wire(lead.output, lead.target, lead.input)
        else:
            lead.source.lead_data(lead.output, lead.target, lead.input, lead.copy)
    graph.evaluator_state = None
    return True


def _compiled(graph: Graph, patch: Patch, registry: Registry) -> tuple[dict[str, Node], Sequence[Copy], bool]:
    """The new nodes, behind all others; their copies; whether all connections are among them, and made already."""
    names = {node.name for node in patch.nodes}
    ends = [end.rpartition(".")[0] for one in patch.connections for end in (one.source, one.target)]
    apart = bool(names) and names.issuperset(ends)
    if not names:
        return {}, (), False
    connections = tuple(patch.connections) if apart else ()
    spec = replace(graph.spec, nodes=tuple(patch.nodes), connections=connections, compounds={})
    alone = compile_graphs([spec], registry)[0]
    if alone.notes:
        raise _OtherwiseError
    last = next(reversed(graph.nodes.values()), None)
    for node in alone.nodes.values():
        node.index += last.index + 1 if last else 0
        node.rank += graph.ranks
    return alone.nodes, alone.starts, apart


def _leads(graph: Graph, fresh: Mapping[str, Node], connections: Iterable[ConnectionSpec]) -> list[_Lead]:
    fed: set[tuple[Node, str]] = set()
    passed: set[tuple[Node, str]] = set()
    leads = []
    for connection in connections:
        (source, output), (target, name) = (_end(graph, fresh, end) for end in (connection.source, connection.target))
        leads.append(_lead(source, output, target, name, fed, passed))
    return leads


def _lead(
    source: Node, output: str, target: Node, name: str, fed: set[tuple[Node, str]], passed: set[tuple[Node, str]]
) -> _Lead:
    """The connection, if it can be added; `fed` and `passed` are the inputs that this edit feeds and reads."""
    at_source, at_target = source.attribute(output), target.attribute(name)
    out = output.startswith("outputs:")
    if not name.startswith("inputs:") or at_target.deprecated or at_source.is_execution != at_target.is_execution:
        raise _OtherwiseError
    if at_source.is_execution:
        if not out:
            raise _OtherwiseError
        return _Lead(source, output, target, name, None)
    if not out and (not output.startswith("inputs:") or output in source._fed or (source, output) in fed):
        raise _OtherwiseError
    first, second = source.types[output], target.types[name]
    end = target, name
    taken = name in target._fed or end in fed or name in target._passes or end in passed or end == (source, output)
    barred = at_target.literal_only or at_target.output_only
    late = out and source.rank >= target.rank
    if first is None or second is None or taken or barred or late or _has_open(target):
        raise _OtherwiseError
    if not convertible(first, second):
        raise _OtherwiseError
    fed.add(end)
    passed.add((source, output))
    convert = converter(first, second)
    if convert is not None:
        try:
            for value in (source.initial(output), source.get(output)):
                convert(value)
        except ValueError as error:
            raise _OtherwiseError from error
    part, _, short = output.partition(":")
    copy = copy_between(getattr(source.db, part), short, target.db.inputs, name.partition(":")[2], convert)
    return _Lead(source, output, target, name, copy)


def _end(graph: Graph, fresh: Mapping[str, Node], end: str) -> tuple[Node, str]:
    name, _, full = end.rpartition(".")
    node = fresh.get(name) or graph.nodes.get(name)
    if node is None or full not in node.types:
        raise _OtherwiseError
    return node, full


def _settable(graph: Graph, name: str, full: str, value: Any) -> tuple[Node, str, Any]:
    node, full = _end(graph, {}, f"{name}.{full}")
    attribute, type_ = node.attribute(full), node.types[full]
    if full.startswith("outputs:") or attribute.is_execution or full in node._fed or attribute.deprecated:
        raise _OtherwiseError
    if type_ is None or _has_open(node) or with_target(value, graph.target) is not value:
        raise _OtherwiseError
    try:
        right = typed_value(value) is None and not attribute.check(coerce(type_, value))
    except ValueError as error:
        raise _OtherwiseError from error
    if not right:
        raise _OtherwiseError
    return node, full, value


def _has_open(node: Node) -> bool:
    """Whether anything about the node's types depends on its values and connections."""
    kinds = (one.parsed for _, one in node.attributes())
    return node.type.resolve is not None or any(isinstance(kind, Extended) for kind in kinds)
