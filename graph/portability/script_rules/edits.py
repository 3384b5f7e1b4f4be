"""Rules on the action graphs that a script edits by `Controller`."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any

from graph.portability.syntax import Script
from graph.portability.wiring import REPLACED, last_part

from .reading import Found, argument, finds


@finds("node-deprecated")
def _nodes(script: Script) -> Iterator[Found]:
    for node, _, kind in _created(script):
        if instead := REPLACED.get(last_part(kind)):
            yield node, f"{last_part(kind)} gives way to {instead}"


@finds("type-renamed")
def _old_types(script: Script) -> Iterator[Found]:
    from graph.spec.migration import migrated_type

    for node, _, kind in _created(script):
        present, said = migrated_type(kind)
        if said and present != kind:
            yield node, f'"{kind}" is now called "{present}"'


@finds("frame-skip-deprecated")
def _skipped(script: Script) -> Iterator[Found]:
    yield from (
        (node, f"{name} is {value}") for node, name, value in _set(script) if name.endswith(":frameSkipCount") and value
    )


@finds("full-scan-deprecated")
def _whole(script: Script) -> Iterator[Found]:
    yield from ((node, f"{name} is set") for node, name, _ in _set(script) if name.endswith(":fullScan"))


@finds("gate-step-zero")
def _gates(script: Script) -> Iterator[Found]:
    gates = {name for _, name, kind in _created(script) if last_part(kind) == "IsaacSimulationGate"}
    for node, name, value in _set(script):
        if value == 0 and name.endswith(".inputs:step") and name.rpartition(".")[0] in gates:
            yield node, f"{name} is 0"


@finds("joint-indices-zero")
def _joints(script: Script) -> Iterator[Found]:
    for node, name, value in _set(script):
        if name.endswith(".inputs:jointIndices") and value in ([0], (0,)):
            yield node, f"{name} is [0]"


@finds("timeline-stamp")
def _stamps(script: Script) -> Iterator[Found]:
    kinds = {name: last_part(kind) for _, name, kind in _created(script)}
    for node, source, target in _pairs(script, "CONNECT"):
        kind = kinds.get(source.rpartition(".")[0], "")
        other_clock = source.endswith((":time", ":timeSinceStart", ":absoluteSimTime"))
        if other_clock and target.endswith(".inputs:timeStamp") and kind in ("OnPlaybackTick", "OnTick", "ReadTime"):
            yield node, f"{target} gets {source}"


def _created(script: Script) -> Iterator[tuple[ast.AST, str, str]]:
    """The nodes that edits create: place, name, type."""
    yield from _pairs(script, "CREATE_NODES")
    for call, name in script.called:
        if name.endswith("Controller.create_node"):
            kind = script.value_of(argument(call, 1, "node_type_id"))
            if isinstance(kind, str):
                yield call, str(script.value_of(argument(call, 0, "node_id"))), kind


def _pairs(script: Script, key: str) -> Iterator[tuple[ast.AST, str, str]]:
    """The entries of a key of Controller.edit that are two texts."""
    for node, first, second in _entries(script, key):
        if isinstance(text := script.value_of(second), str):
            yield node, first, text


def _set(script: Script) -> Iterator[tuple[ast.AST, str, Any]]:
    """The values that edits set: place, NODE.inputs:NAME, value."""
    for node, name, value in _entries(script, "SET_VALUES"):
        yield node, name, script.value_of(value)


def _entries(script: Script, key: str) -> Iterator[tuple[ast.AST, str, ast.expr]]:
    """The entries (text, expression) below a key of Controller.edit."""
    for node in script.nodes:
        if not isinstance(node, ast.Dict):
            continue
        for name, value in zip(node.keys, node.values, strict=True):
            if isinstance(name, ast.Attribute) and name.attr == key:
                entries = [value] if isinstance(value, ast.Tuple) else getattr(value, "elts", [])
                for entry in entries:
                    if isinstance(entry, ast.Tuple | ast.List) and len(entry.elts) >= 2:
                        first = script.value_of(entry.elts[0])
                        if isinstance(first, str):
                            yield entry, first, entry.elts[1]
