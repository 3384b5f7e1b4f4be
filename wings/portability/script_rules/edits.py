"""The action graphs that a script edits by `Controller`, and rules on what its edits say."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from graph.base.records import dataclass, field
from graph.isaac.syntax import Script

from .reading import Found, argument, finds

NODE, VALUE, WIRE = "CREATE_NODES", "SET_VALUES", "CONNECT"


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of an edit. graph: its path, "" if unknown; name: of a node, an input or an output; value: as written.

    The value of a node is its type, of a connection its target, of an input what it is set to (None: only a run
    knows).
    """

    place: ast.AST
    graph: str
    name: str
    value: Any


@dataclass(slots=True)
class Edits:
    """All edits of a script, in the order of its text."""

    nodes: list[Entry] = field(default_factory=list)
    values: list[Entry] = field(default_factory=list)
    wires: list[Entry] = field(default_factory=list)
    stages: dict[str, str] = field(default_factory=dict)
    """The last word of the pipeline stage by the graph's path."""
    known: set[str] = field(default_factory=set)
    """Paths of graphs whose settings the script gives as constants."""

    @property
    def all(self) -> tuple[list[Entry], ...]:
        """Nodes, values, connections."""
        return self.nodes, self.values, self.wires


@lru_cache(maxsize=1)
def edits_of(script: Script) -> Edits:
    """What the dicts of `Controller.edit` and its methods for single edits say, wherever they stand; read once."""
    found = Edits()
    graphs: dict[int, str] = {}
    for call, name in script.called:
        last = name.rpartition(".")[2]
        if last == "edit":
            given = argument(call, 1, "edit_commands")
            given = script.values.get(given.id) if isinstance(given, ast.Name) else given
            graphs[id(given)] = _graph(script, argument(call, 0, "graph_id"), found)
        elif last in ("create_node", "connect", "set") and "Controller" in name:
            _single(script, call, last, found)
    kinds = {NODE: found.nodes, VALUE: found.values, WIRE: found.wires}
    for node in script.nodes:
        for key, value in zip(node.keys, node.values, strict=True) if isinstance(node, ast.Dict) else ():
            if isinstance(key, ast.Attribute) and key.attr in kinds:
                for place, name, second in _entries(script, value):
                    entry = Entry(place, graphs.get(id(node), ""), name, script.value_of(second))
                    if key.attr == VALUE or isinstance(entry.value, str):
                        kinds[key.attr].append(entry)
    return found


def _graph(script: Script, node: ast.expr | None, found: Edits) -> str:
    """The path of the edited graph; for one that only a run knows, a path of its own."""
    settings: dict[Any, ast.expr] = {}
    node = script.values.get(node.id, node) if isinstance(node, ast.Name) else node
    constant = isinstance(node, ast.Dict | ast.Constant | ast.JoinedStr)
    if isinstance(node, ast.Dict):
        settings = {script.value_of(key): value for key, value in zip(node.keys, node.values, strict=True)}
        node = settings.get("graph_path")
    path = script.value_of(node)
    if not isinstance(path, str) or not path.startswith("/"):
        path = f"/graph_{getattr(node, 'lineno', 0)}"
    if constant:
        found.known.add(path)
    if stage := settings.get("pipeline_stage"):
        found.stages[path] = script.name_of(stage).rpartition("_")[2]
    return path


def _single(script: Script, call: ast.Call, method: str, found: Edits) -> None:
    first, second = (script.value_of(one) for one in (*call.args[:2], None, None)[:2])
    if method == "set" and call.args and isinstance(call.args[0], ast.Call) and call.args[0].args:
        first = script.value_of(call.args[0].args[0])  # Controller.set(Controller.attribute(PATH), value)
    if not isinstance(first, str) or first.count("/") < 2:
        return
    graph, _, name = first.rpartition("/")
    if method == "set":
        found.values.append(Entry(call, graph, name, second))
    elif method == "create_node" and isinstance(second, str):
        found.nodes.append(Entry(call, graph, name, second))
    elif method == "connect" and isinstance(second, str):
        found.wires.append(Entry(call, graph, name, second.rpartition("/")[2]))


def _entries(script: Script, node: ast.expr) -> Iterator[tuple[ast.AST, str, ast.expr]]:
    given = script.values.get(node.id) if isinstance(node, ast.Name) else node
    for entry in [given] if isinstance(given, ast.Tuple) else getattr(given, "elts", []):
        if isinstance(entry, ast.Tuple | ast.List) and len(entry.elts) >= 2:
            name = script.value_of(entry.elts[0])
            if isinstance(name, str):
                yield entry, name, entry.elts[1]


@finds("type-renamed")
def _old_types(script: Script) -> Iterator[Found]:
    from graph.spec.migration import migrated_type

    for one in edits_of(script).nodes:
        present, said = migrated_type(one.value)
        if said and present != one.value:
            yield one.place, f'"{one.value}" is now called "{present}"'


CREATED = ("create_attribute", "create_attributes", "CREATE_ATTRIBUTES", "CreateAttribute")
COMPLETE = ("isaacsim.core.nodes.", "isaacsim.ros2.bridge.", "isaacsim.sensors.", "omni.graph.action.")
"""Extensions of which every node type is known here."""


def refused_by(problem: str) -> bool:
    """Whether a problem of the file that a script amounts to makes its edit fail in the product too."""
    if 'no node type "' in problem:
        return problem.partition('no node type "')[2].startswith(COMPLETE) and "did you mean" in problem
    return " has no input " in problem or " has no output " in problem


def adds_attributes(script: Script) -> bool:
    """Whether the script adds attributes to nodes: then only a run knows which they have."""
    names = {one.attr for one in script.nodes if isinstance(one, ast.Attribute)}
    return not names.isdisjoint(CREATED)


@finds("frame-skip-deprecated")
def _skipped(script: Script) -> Iterator[Found]:
    for one in edits_of(script).values:
        if one.name.endswith(":frameSkipCount") and one.value:
            yield one.place, f"{one.name} is {one.value}"
    for call, _ in script.called:
        if count := script.value_of(argument(call, 99, "frameSkipCount")):
            yield call, f"frameSkipCount is {count}"


@finds("full-scan-deprecated")
def _whole(script: Script) -> Iterator[Found]:
    yield from ((one.place, f"{one.name} is set") for one in edits_of(script).values if one.name.endswith(":fullScan"))
    yield from ((call, "fullScan is set") for call, _ in script.called if argument(call, 99, "fullScan") is not None)


@finds("joint-indices-zero")
def _joints(script: Script) -> Iterator[Found]:
    for one in edits_of(script).values:
        if one.name.endswith(".inputs:jointIndices") and one.value in ([0], (0,)):
            yield one.place, f"{one.name} is [0]"
