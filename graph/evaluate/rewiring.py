"""Changes of a compiled graph in place: connections, values and types of its nodes, one at a time.

The callers have checked the edit (`graph.plan.patch`). Attributes are named in full (`inputs:x`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from graph.values.types import Type

from .node import Node, refusing, storage_place
from .wire import Copy, all_of


def lead_wire(source: Node, output: str, target: Node, name: str) -> None:
    """Adds a wire, after all others of its execution output, to another node's input."""
    _add_connection(source, output, target, name)
    wire = source.db._wires[output.partition(":")[2]]
    wire.add(target.db, name.partition(":")[2])
    target.wires_in = {**target.wires_in, name: [*target.wires_in.get(name, ()), wire]}


def cut_wire(source: Node, output: str, target: Node, name: str) -> None:
    """Removes a wire from an execution output to another node's input."""
    wire = source.db._wires[output.partition(":")[2]]
    wire.remove(target.db, name.partition(":")[2])
    left = list(target.wires_in[name])
    left.remove(wire)
    if left:
        target.wires_in = {**target.wires_in, name: left}
    else:
        target.wires_in = {one: wires for one, wires in target.wires_in.items() if one != name}
        target.fed_names -= {name}
    if not wire.targets:
        source.consumed_names -= {output}


def lead_data(source: Node, output: str, target: Node, name: str, copy: Copy) -> None:
    """Adds a connection: `copy` writes an output, or a set input, to another node's input."""
    _add_connection(source, output, target, name)
    source.readers = tuple(dict.fromkeys((*source.readers, target)))
    if output.startswith("inputs:"):
        source.passes.setdefault(output, []).append(copy)
    else:
        target.sources = tuple(dict.fromkeys((*target.sources, source)))
        source.pushes.append(copy)
        renew_pushes(source)
        _pull_anew(target)


def replace_copy(source: Node, output: str, before: Copy, copy: Copy) -> None:
    """Replaces the function that copies an output, or a set input, along a connection."""
    copies = source.passes[output] if output.startswith("inputs:") else source.pushes
    copies[copies.index(before)] = copy
    if copies is source.pushes:
        renew_pushes(source)


def cut_data(source: Node, output: str, target: Node, name: str, copy: Copy, *, last: bool) -> None:
    """Removes what `lead_data` added; last: whether nothing else is connected to the output now."""
    target.fed_names -= {name}
    if last:
        source.consumed_names -= {output}
    if output.startswith("inputs:"):
        source.passes[output].remove(copy)
    else:
        source.pushes.remove(copy)
        renew_pushes(source)


def set_readers(node: Node, readers: Iterable[Node]) -> None:
    """Sets the nodes that read a node's outputs, after connections were removed."""
    node.readers = tuple(dict.fromkeys(readers))


def set_sources(node: Node, sources: Iterable[Node]) -> None:
    """Sets the nodes from which a node gets values, after connections were removed."""
    node.sources = tuple(dict.fromkeys(sources))
    _pull_anew(node)


def retype(node: Node, types: Mapping[str, Type | None], initial: Mapping[str, Any]) -> None:
    """Gives a node other types and initial values; outputs and state keep their values if their types stay."""
    db = node.db
    parts = {"inputs": db.inputs, "outputs": db.outputs, "state": db.state}
    for full, value in initial.items():
        prefix, name = storage_place(full)
        if prefix == "inputs" or node.types[full] is not types[full]:
            setattr(parts[prefix], name, value)
    node.types, node.initial_values = types, initial


def start_with(node: Node, full: str, value: Any) -> None:
    """Gives an unconnected input its initial value, now and at every start."""
    node.initial_values = {**node.initial_values, full: value}
    prefix, name = storage_place(full)
    setattr(getattr(node.db, prefix), name, value)


def specialize(node: Node, unset: str) -> None:
    """Chooses the compute for a node's types; unset: why it cannot compute, "" if it can."""
    db = node.db
    own = None if unset or node.type.specialize is None else node.type.specialize(db)
    db._compute = refusing(unset) if unset else own or node.type.compute
    _renew_wires(node)


def renew_pushes(node: Node) -> None:
    """Makes the function that copies all outputs of a node again: its `pushes` have changed."""
    node.db._push = all_of(node.pushes)
    _renew_wires(node)


def _renew_wires(node: Node) -> None:
    for wires in node.wires_in.values():
        for wire in wires:
            wire.renew()


def _pull_anew(changed: Node) -> None:
    """Makes the readers that compute a node on demand search for its sources again."""
    changed.db._set_pulls(True if changed.sources else ())
    seen, pending = {changed}, [changed] if changed.graph.evaluator == "execution" else []
    while pending:
        node = pending.pop()
        node.db._set_pulls(True if node.sources else ())
        if not node.type.has_execution:
            fresh = [reader for reader in node.readers if reader not in seen]
            seen.update(fresh)
            pending += fresh


def _add_connection(source: Node, output: str, target: Node, name: str) -> None:
    source.consumed_names |= {output}
    target.fed_names |= {name}
