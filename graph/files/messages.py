"""Turns errors of the models into problems: where in the file, what is wrong, what to do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from graph.base.errors import Problem
from graph.base.forms import KEY, Error, Form
from graph.base.suggest import did_you_mean

from . import file_forms
from .source import Source
from .text import described, quoted, shown, suggestion
from .tree import Location, Map, offset, value_at

WANTED = {
    "mapping": "a mapping",
    "list": "a list",
    "text": "text",
    "whole": "a whole number",
    "number": "a number",
    "truth": "true or false",
}
_NO_VERSION = 'there is no "tickgraph" key; a graph file starts with "tickgraph: 1"'


def problems_of(errors: Iterable[Error], source: Source, root: Map) -> list[Problem]:
    """One problem for each error of the models, in the order of the file."""
    errors = [*errors]
    unknown: dict[Location, list[str]] = {}
    for error in errors:
        if error.kind == "unknown":
            unknown.setdefault(error.location[:-1], []).append(str(error.location[-1]))
    placed = [_problem(error, root) for error in errors if not _only_misspelt(error, unknown)]
    return [source.problem(at, message) for at, message in sorted(placed)]


def _only_misspelt(error: Error, unknown: Mapping[Location, Sequence[str]]) -> bool:
    """Whether a missing key is present with a typing error: that is one mistake, not two."""
    if error.kind != "missing":
        return False
    *parent, name = error.location
    return any(did_you_mean(other, [str(name)]) for other in unknown.get(tuple(parent), ())[:100])


def locations_of(errors: Iterable[Error]) -> list[Location]:
    """What must be left out to make the tree valid: the value of each error, or the parent of a missing value."""
    return [error.location[:-1] if error.kind == "missing" else _tree_location(error.location)[0] for error in errors]


def _problem(error: Error, root: Map) -> tuple[int, str]:
    location, about_key = _tree_location(error.location)
    kind = error.kind
    if location == ("tickgraph",):
        return offset(root, location), _version(kind, value_at(root, location))
    if kind == "unknown":
        return offset(root, location, key=True), _unknown_key(location)
    if kind == "missing":
        parent, name = location[:-1], location[-1]
        return offset(root, parent, key=True), f'{label(parent)}: "{name}" is missing; add it'
    value = value_at(root, location)
    name = label(location)
    at = offset(root, location, key=about_key)
    if kind == "refused":
        text = error.detail
        return at, f"{label(location[:-1])}: {text}" if about_key else _joined(name, text)
    if kind == "choice":
        return at, f"{name}: {_choice(value, error.detail)}"
    if kind == "limit":
        limit, size = error.detail
        return (
            at,
            f"{name} is empty; give it a value" if limit == "min_length" else f"{name} has more than {size:,} keys",
        )
    return at, f"{name} must be {wanted(kind)}, found {described(value)}"


def wanted(kind: str) -> str:
    """What must stand there, in words: of one type, or of one of several."""
    return " or ".join(dict.fromkeys(WANTED[one] for one in kind.split(" or ")))


def _joined(name: str, text: str) -> str:
    return f"{name} {text}" if text.startswith(("must ", "is ")) else f"{name}: {text}"


def _tree_location(location: Sequence[str | int]) -> tuple[Location, bool]:
    """The part of an error's location that exists in the tree, and whether the error is about the key itself."""
    if location and location[-1] == KEY:
        return tuple(location[:-1]), True
    return tuple(location), False


def _version(kind: str, value: Any) -> str:
    if kind == "missing":
        return _NO_VERSION
    return f"tickgraph must be {file_forms.VERSION}, the version of the file format, found {described(value)}"


def _unknown_key(location: Location) -> str:
    *parents, key = location
    place = f" in {label(parents)}" if parents else ""
    return f"unknown key {quoted(str(key))}{place}{suggestion(str(key), _fields(parents))}"


def _choice(value: Any, allowed: Sequence[Any]) -> str:
    choices = [str(choice) for choice in allowed]
    if isinstance(value, str):
        return f"{quoted(value)} is not a choice{suggestion(value, choices, listed='choose one of')}"
    return f"found {described(value)}; choose one of {', '.join(choices)}"


def _fields(location: Sequence[str | int]) -> Mapping[str, Any]:
    """The fields of the model that describes the mapping at a location."""
    kind: type[Form] = file_forms.GraphFile
    match [*location]:
        case ["scene"]:
            kind = file_forms.Scene
        case ["clock"]:
            kind = file_forms.Clock
        case ["record"]:
            kind = file_forms.Record
        case ["graphs", _]:
            kind = file_forms.Graph
        case ["graphs", _, "nodes", _]:
            kind = file_forms.Node
        case ["graphs", _, "variables", _]:
            kind = file_forms.Variable
    return kind.fields


def label(location: Sequence[str | int]) -> str:
    """A location in the words of the format: `clock.loop_hz`, `node "wait": inputs`, `graph /World/G: evaluator`."""
    parts = [shown(part) if isinstance(part, str) else str(part) for part in location]
    match parts:
        case []:
            return "the file"
        case ["graphs", _, "connections", _]:
            return "a connection"
        case ["graphs", _, "nodes", name, *rest]:
            return _path(f'node "{name}"', rest)
        case ["graphs", _, "variables", name, *rest]:
            return _path(f'variable "{name}"', rest)
        case ["graphs", path, *rest]:
            return _path(f"graph {path}", rest)
        case ["scene", "prims", path, *rest]:
            return _path(f"prim {path}", rest)
        case ["settings" | "fidelity" | "randomize" as section, key]:
            return f"{section}: {key}"
    return ".".join(parts)


def _path(whole: str, rest: Sequence[str]) -> str:
    return f"{whole}: {'.'.join(rest)}" if rest else whole
