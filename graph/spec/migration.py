"""Upgrades old files: type ids and attributes that have been renamed since.

The tables are data of the node library (`nodes.catalog.renames`), which the registry provides. The id of a registered
type is never changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from graph.base.errors import Mark
from graph.base.records import dataclass, field
from graph.node.registry import DEFAULT, Registry

from .file_spec import ConnectionSpec, FileSpec, GraphSpec, NodeSpec, Note


def meant_nothing(type_id: str, registry: Registry = DEFAULT) -> tuple[int, Mapping[str, Any]]:
    """First version of a type in which these values are explicit; older files wrote them for "unset"."""
    return registry.library.renames.MEANT_NOTHING.get(type_id, (0, {}))


def upgraded(
    type_id: str, version: int | None, inputs: Mapping[str, Any], registry: Registry = DEFAULT
) -> Mapping[str, Any]:
    """The inputs that a file of an older type version sets, as the present version expects them."""
    since, unset = meant_nothing(type_id, registry)
    if version is None or version >= since:
        return inputs
    return {name: value for name, value in inputs.items() if name not in unset or value != unset[name]}


@dataclass(slots=True)
class Notes:
    """Warnings of one file: each is given once, for the first place it concerns, with the number of further places."""

    first: dict[tuple[str, str], tuple[Mark | None, str]] = field(default_factory=dict)
    more: dict[tuple[str, str], int] = field(default_factory=dict)

    def add(self, code: str, message: str, mark: Mark | None, path: str) -> None:
        """Adds a warning at `mark`, or at the prim path if the file has no lines."""
        key = (code, message)
        if key in self.first:
            self.more[key] = self.more.get(key, 0) + 1
        else:
            self.first[key] = mark, path

    def all(self) -> tuple[Note, ...]:
        """All warnings, in the order in which they were added."""

        def line(key: tuple[str, str]) -> str:
            count = self.more.get(key)
            return f"{key[1]} (and {count} more)" if count else key[1]

        return tuple((key[0], str(mark or path), line(key)) for key, (mark, path) in self.first.items())


def migrated_type(type_id: str, registry: Registry = DEFAULT) -> tuple[str, str | None]:
    """The present id of a type, and a sentence if it differs from the given one; an unknown id comes back unchanged.

    If the present type is known to be absent here the new id is still given, so that messages show it.
    """
    if type_id in registry:
        return type_id, None
    new = registry.library.renames.TYPES.get(type_id) or _by_prefix(type_id, registry)
    runs = new is not None and new in registry
    if new is None or (not runs and registry.library.why_absent(new) is None):
        return type_id, None  # no present type: the message about an unknown type shows the id of the file
    if _is_ros1(type_id):
        twin = f'its ROS 2 twin "{new}" runs instead' if runs else f'its ROS 2 twin is "{new}"'
        return new, f'the ROS 1 node type "{type_id}" is gone; {twin}'
    return new, f'node type "{type_id}" is now called "{new}"{"; the new name is used" if runs else ""}'


def former_names(registry: Registry = DEFAULT) -> dict[str, set[str]]:
    """Names in old files that are still read: of types under "types", of inputs by present type id, "" for all."""
    renames = registry.library.renames
    known = [one.id for one in registry.all()]
    candidates = set(renames.TYPES)
    for old, present in renames.PREFIXES.items():
        rests = {one.removeprefix(new) for new in present for one in known if one.startswith(new)}
        bare = {rest.removeprefix("Ogn") for rest in rests if "." not in rest}
        for name in (*bare, *(rest.replace("ROS2", "ROS1") for rest in bare)):
            candidates |= {f"{old}{name}", f"{old}Ogn{name}"}
    former = {"types": {one for one in candidates if migrated_type(one, registry)[0] in registry and one not in known}}
    inputs = {"": renames.REMOVED, **renames.RENAMED}
    for type_id, table in inputs.items():
        former[type_id] = {name.removeprefix("inputs:") for name in table if name.startswith("inputs:")}
    return former


def _is_ros1(type_id: str) -> bool:
    return "ROS1" in type_id or ".ros_bridge." in type_id or ".ros1." in type_id


def _by_prefix(type_id: str, registry: Registry) -> str | None:
    prefixes = registry.library.renames.PREFIXES
    for old in sorted(prefixes, key=len, reverse=True):
        if not type_id.startswith(old):
            continue
        name = type_id[len(old) :].replace("ROS1", "ROS2")
        spellings = dict.fromkeys((name, f"Ogn{name}", name.removeprefix("Ogn")))
        candidates = [new + spelling for new in prefixes[old] for spelling in spellings]
        known = next((one for one in candidates if one in registry), None)
        likely = next((one for one in candidates if "RTX" in name and ".rtx." in one), candidates[0])
        return known or likely
    return None


def migrate(spec: FileSpec, registry: Registry = DEFAULT) -> FileSpec:
    """The file with every old id and attribute upgraded; each kind of change is noted once for the whole file."""
    notes = Notes()
    old = _OldTypes(registry)
    graphs = tuple(_graph(graph, registry, notes, old) for graph in spec.graphs)
    if all(new is old for new, old in zip(graphs, spec.graphs, strict=True)):
        return spec
    return replace(spec, graphs=graphs, notes=(*spec.notes, *old.notes().all(), *notes.all()))


class _OldTypes:
    """The nodes of a file whose types have new ids, told in one warning for each kind of change."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._found: dict[str, list[tuple[str, str, str, Mark | None, str]]] = {}

    def add(self, old: str, new: str, sentence: str, mark: Mark | None, path: str) -> None:
        """Adds a node at `path`; sentence: the warning if its type is the only one of its kind."""
        kind = "absent" if new not in self._registry else "ros1" if _is_ros1(old) else "renamed"
        self._found.setdefault(kind, []).append((old, new, sentence, mark, path))

    def notes(self) -> Notes:
        """The warnings."""
        notes = Notes()
        for kind, nodes in self._found.items():
            types = dict.fromkeys(old for old, *_ in nodes)
            if kind == "absent" or len(types) == 1:
                for _, _, sentence, mark, path in nodes:
                    notes.add("type-renamed", sentence, mark, path)
                continue
            old, new, _, mark, path = nodes[0]
            what = "have names of older versions" if kind == "renamed" else "are of ROS 1, which is gone"
            does = "the new names are used" if kind == "renamed" else "their ROS 2 twins run instead"
            counted = f"{len(nodes)} nodes of {len(types)} types {what}; {does}"
            notes.add("type-renamed", f'{counted}, such as "{new}" for "{old}"', mark, path)
        return notes


def _graph(graph: GraphSpec, registry: Registry, notes: Notes, old: _OldTypes) -> GraphSpec:
    linked = _linked(graph)
    types: dict[str, tuple[str, str | None]] = {}
    changes: dict[str, Mapping[str, str]] = {}
    nodes = []
    for node in graph.nodes:
        if node.type not in types:
            types[node.type] = migrated_type(node.type, registry)
        type_id, sentence = types[node.type]
        if sentence:
            old.add(node.type, type_id, sentence, node.mark, f"{graph.path}/{node.name}")
            node = replace(node, type=type_id)
        special = _special_type(node, registry)
        if special is not None:
            type_id, sentence, gone = special
            notes.add("type-renamed", sentence, node.mark, f"{graph.path}/{node.name}")
            changes[node.name] = dict.fromkeys(gone, "")
            node = _with_type(node, type_id, changes[node.name])
        renamed = _renamed(node, graph, linked.get(node.name, ()), registry, notes)
        if renamed:
            changes[node.name] = {**changes.get(node.name, {}), **renamed}
            node = _with_type(node, node.type, renamed)
        nodes.append(node)
    if all(new is old for new, old in zip(nodes, graph.nodes, strict=True)):
        return graph
    return replace(graph, nodes=tuple(nodes), connections=tuple(_connections(graph, changes)))


def _special_type(node: NodeSpec, registry: Registry) -> tuple[str, str, list[str]] | None:
    """The type that does now what an input's value made this one do, a sentence, and its inputs that are gone."""
    for (type_id, name), kinds in registry.library.renames.KINDS.items():
        if node.type != type_id:
            continue
        value = node.inputs.get(name, node.inputs.get(f"inputs:{name}"))
        new = kinds.get(value) if isinstance(value, str) else None
        if new is None or new not in registry:
            continue
        known = registry.get(new).inputs
        sentence = f'{type_id.rpartition(".")[2]} with {name} {value} is now a node type, "{new}", which is used'
        gone = [f"inputs:{one}" for one in (*registry.get(type_id).inputs, "viewport") if one not in known]
        return new, sentence, gone
    return None


def _with_type(node: NodeSpec, type_id: str, changes: Mapping[str, str]) -> NodeSpec:
    return replace(
        node,
        type=type_id,
        inputs=_with_names(node.inputs, changes),
        input_marks=_with_names(node.input_marks, changes),
        attributes=_with_names(node.attributes, changes),
    )


def _renamed(
    node: NodeSpec, graph: GraphSpec, linked: Sequence[str], registry: Registry, notes: Notes
) -> dict[str, str]:
    """The old and the present names of a node's attributes, "" if removed; `linked`: those with a connection."""
    renames = registry.library.renames
    table = renames.RENAMED.get(node.type, {})
    found: dict[str, str] = {}
    for key in dict.fromkeys((*node.inputs, *linked)) if table or _has_old(node, renames.REMOVED) else ():
        full = _full(key)
        change = changed_attribute(node.type, full, registry)
        if change is None:
            continue
        found[full], code, sentence = change
        notes.add(code, sentence, node.input_marks.get(key, node.mark), f"{graph.path}/{node.name}")
    return found


def changed_attribute(type_id: str, full: str, registry: Registry = DEFAULT) -> tuple[str, str, str] | None:
    """The present name of an old attribute, "" if it was removed, with a warning's code and sentence.

    None if the type has the attribute, or if the name is not known at all.
    """
    renames = registry.library.renames
    table = renames.RENAMED.get(type_id, {})
    prefix, _, name = full.partition(":")
    if full not in table and (full not in renames.REMOVED or type_id not in registry):
        return None
    if type_id in registry and registry.get(type_id).find(prefix, name) is not None:
        return None
    kind, new = type_id.rpartition(".")[2], table.get(full, "")
    if new:
        return new, "attribute-renamed", f"{kind}: {full} is now called {new}; the new name is used"
    return "", "attribute-removed", f"{kind}: {full} is gone and is left out; {renames.REMOVED.get(full, 'remove it')}"


def _has_old(node: NodeSpec, removed: Mapping[str, str]) -> bool:
    return any(f"inputs:{key}" in removed for key in node.inputs)


def _linked(graph: GraphSpec) -> Mapping[str, list[str]]:
    """The full names of the attributes that connections join, by node name."""
    found: dict[str, list[str]] = {}
    for one in graph.connections:
        for end, side in ((one.target, "inputs"), (one.source, "outputs")):
            node, _, attribute = end.rpartition(".")
            found.setdefault(node, []).append(_full(attribute, side))
    return found


def _full(written: str, side: str = "inputs") -> str:
    """The name of an attribute with its prefix."""
    return written if written.startswith(("inputs:", "outputs:", "state:")) else f"{side}:{written}"


def _with_names(values: Mapping[str, Any], renamed: Mapping[str, str]) -> dict[str, Any]:
    kept = {}
    for key, value in values.items():
        full = _full(key)
        if full not in renamed:
            kept[key] = value
        elif renamed[full]:
            kept.setdefault(renamed[full].removeprefix("inputs:") if key != full else renamed[full], value)
    return kept


def _connections(graph: GraphSpec, changes: Mapping[str, Mapping[str, str]]) -> Iterable[ConnectionSpec]:
    for connection in graph.connections:
        source = _present(connection.source, "outputs", changes)
        target = _present(connection.target, "inputs", changes)
        if (source, target) == (connection.source, connection.target):
            yield connection
        elif source and target:
            yield replace(connection, source=source, target=target)


def _present(end: str, side: str, changes: Mapping[str, Mapping[str, str]]) -> str:
    """An end of a connection with the present name of its attribute; "" if that is gone."""
    node, _, attribute = end.rpartition(".")
    new = changes.get(node, {}).get(_full(attribute, side))
    if new is None:
        return end
    return f"{node}.{new}" if new else ""
