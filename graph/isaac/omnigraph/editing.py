"""Edits that OmniGraph has beside those of `graph.isaac.og`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from graph.editing.graph_set import GraphSet
from graph.editing.model import Model
from graph.evaluate.omnigraph_names import AttributeOf
from graph.isaac.og import Controller, OmniGraphError, TypedValue
from graph.isaac.session import mirror
from graph.isaac.watched import tell_changed
from graph.spec.file_spec import GraphSpec

from .handle import Handle


def plain(value: Any) -> Any:
    """A value as edits take it: handles, prims and paths of any kind as text, USD's vectors and arrays as lists."""
    if isinstance(value, Handle):
        return value.path
    if hasattr(value, "GetPath") and not isinstance(value, type):
        return str(value.GetPath())
    if type(value).__name__ == "Path" and not hasattr(value, "joinpath"):
        return str(value)
    if type(value).__module__ in ("pxr.Gf", "pxr.Vt"):
        return _numbers(value)
    if isinstance(value, TypedValue):
        return TypedValue(plain(value.value), str(getattr(value.type, "name", value.type)))
    if isinstance(value, (list, tuple)) and value and not isinstance(value[0], (int, float, bool)):
        return type(value)(plain(one) for one in value) if type(value) in (list, tuple) else value
    return value


def _numbers(value: Any) -> Any:
    """USD's vectors, matrices and arrays as lists, its quaternions as x, y, z, w."""
    if hasattr(value, "imaginary"):
        return [*value.imaginary, value.real]
    if hasattr(value, "GetRow"):
        return [list(value.GetRow(i)) for i in range(value.dimension[0])]
    return [_numbers(one) for one in value] if hasattr(value, "__len__") and not isinstance(value, str) else value


def set_value(graphs: GraphSet, ours: AttributeOf, value: Any) -> bool:
    """Sets an input or state with its prim, or an output (until its node computes); calls its callback. Gives True."""
    name, node = ours.full_name, ours.node
    if name.startswith("outputs:"):
        from graph.evaluate.node import storage_place
        from graph.values.coercion import coerce

        prefix, short = storage_place(name)
        type_ = node.types.get(name)
        try:
            setattr(getattr(node.db, prefix), short, value if type_ is None else coerce(type_, plain(value)))
        except (ValueError, AttributeError) as error:
            raise OmniGraphError(f"{ours.path}: {error}") from None
    else:
        with_flag = plain(value)
        if type(with_flag) is int and with_flag in (0, 1):
            type_ = node.types.get(name)
            if type_ is not None and type_.storage == "bool":
                with_flag = bool(with_flag)
        Controller(graphs=graphs).set(ours, with_flag)
        if (prims := mirror()) is not None:
            prims.set_value(node, name)
    tell_changed(graphs, ours.path)
    return True


def connections(graphs: GraphSet, path: str) -> list[tuple[str, str]]:
    """The connections of a graph and of those that it is linked with, by the paths of both ends."""
    found: dict[tuple[str, str], None] = {}
    for one in graphs.linked_with(path):
        graph = graphs.latest(one)
        if graph is None:
            continue
        for ends in Model(graph.spec, graphs.registry).connections:
            source, target = (end if end.startswith("/") else f"{one}/{end}" for end in ends)
            found[source, target] = None
    return list(found)


def disconnect_all(graphs: GraphSet, path: str) -> None:
    """Removes every connection of an attribute."""
    owner = graphs.owner_of(path.rpartition(".")[0])
    if owner is None:
        raise OmniGraphError(f'"{path}" is not a legal attribute')
    editor = Controller(graphs=graphs)
    for source, target in connections(graphs, owner.path):
        if path in (source, target):
            editor.disconnect(source, target)


def kind_name(kind: Any) -> str:
    """The OGN name of a type given as text, as `Type` or as Sdf's value type name."""
    if not isinstance(kind, str) and hasattr(kind, "type") and hasattr(kind, "role"):
        from .types import AttributeType

        return AttributeType.type_from_sdf_type_name(kind).name
    return str(getattr(kind, "name", kind))


def remove_variable(graphs: GraphSet, path: str, name: str) -> bool:
    """Removes a variable of a graph; False if a node reads or writes it, or it is missing."""
    graph = graphs.get(path)
    if name not in graph.variables:
        return False
    try:
        respecify(
            graphs, path, lambda spec: replace(spec, variables={k: v for k, v in spec.variables.items() if k != name})
        )
    except OmniGraphError:
        return False
    return True


def rename_node(graphs: GraphSet, path: str, old: str, new: str) -> bool:
    """Gives a node another name; it keeps its values and connections, and loses its memory."""
    before, after = (str(one).removeprefix(f"{path}/") for one in (old, new))
    graph = graphs.get(path)
    if before not in graph.nodes or after in graph.nodes:
        return False

    def end(text: str) -> str:
        owner, dot, attribute = text.rpartition(".")
        return f"{after if owner == before else owner}{dot}{attribute}"

    def renamed(spec: GraphSpec) -> GraphSpec:
        return replace(
            spec,
            nodes=tuple(replace(one, name=after) if one.name == before else one for one in spec.nodes),
            connections=tuple(replace(one, source=end(one.source), target=end(one.target)) for one in spec.connections),
        )

    respecify(graphs, path, renamed)
    return True


def respecify(graphs: GraphSet, path: str, change: Callable[[GraphSpec], GraphSpec]) -> None:
    """Changes the spec of a graph by a function; its prims follow. Raises OmniGraphError for a graph that is wrong."""
    from graph.base.errors import UserError

    try:
        graphs.apply([change(graphs.current_spec(path))], {})
    except UserError as error:
        raise OmniGraphError(error.problems) from None
    follow(path)


def follow(path: str) -> None:
    """A graph was changed, not by an edit: its prims follow."""
    if (prims := mirror()) is not None:
        prims.write(path)
