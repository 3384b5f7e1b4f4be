"""Problems of a test file, in the words of its format and with their places."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from graph.base.errors import Problem
from graph.base.forms import Error, Form
from graph.base.suggest import did_you_mean
from graph.files import messages as file_messages
from graph.files.source import Source
from graph.files.text import described, quoted, shown, suggestion
from graph.files.tree import Location, Map, offset, value_at

from . import case_forms

GRAPH_PATH = "/Graph"
"""The path of an inline graph of a test file."""

_FILE_SECTIONS = ("scene", "clock", "settings", "fidelity")


def problems_of(errors: Iterable[Error], source: Source, root: Map) -> list[Problem]:
    """One problem for each error of the models."""
    errors = [*errors]
    found: list[Problem] = []
    unknown = [error.location for error in errors if error.kind == "unknown"]
    of_graph_file: dict[tuple[str | None, str], list[Error]] = {}
    for error in errors:
        case, rest = split(error.location)
        if as_graph_file(setup_at(root, case), rest) is not None:
            of_graph_file.setdefault((case, str(rest[0])), []).append(error)
        elif error.kind != "missing" or not _misspelt(error.location, unknown):
            at, message = _problem(error, case, rest, root)
            found.append(source.problem(at, message))
    for (case, _), group in of_graph_file.items():
        found += _in_the_words_of_graph_files(case, group, source, root)
    return found


def _in_the_words_of_graph_files(
    case: str | None, errors: Iterable[Error], source: Source, root: Map
) -> Iterator[Problem]:
    moved: list[Error] = []
    file = root
    for error in errors:
        section = as_graph_file(setup_at(root, case), split(error.location)[1])
        if section is not None:
            file, location = section
            moved.append(error._replace(location=location))
    for one in file_messages.problems_of(moved, source, file):
        yield Problem(named(case, one.message), one.mark)


def _misspelt(missing: Location, unknown: Iterable[Location]) -> bool:
    """Whether a missing key is present with a typing error: that is one mistake, not two."""
    near = (str(other[-1]) for other in unknown if other[:-1] == missing[:-1])
    return any(did_you_mean(other, [str(missing[-1])]) for other in near)


def named(case: str | None, message: str) -> str:
    """The message, with the name of its case in front."""
    return message if case is None else f"case {quoted(case)}: {message}"


def split(location: Location) -> tuple[str | None, Location]:
    """The case that a location belongs to (None: outside the cases) and the rest of the location."""
    if len(location) > 1 and location[0] == "cases":
        return str(location[1]), tuple(location[2:])
    return None, tuple(location)


def setup_at(root: Map, case: str | None) -> Map:
    """The mapping of a case, or of the whole file for a location outside the cases."""
    found = root if case is None else value_at(root, ("cases", case))
    return found if isinstance(found, Map) else Map()


def as_graph_file(setup: Map, rest: Location) -> tuple[Map, Location] | None:
    """The part of a setup that graph files share, as a graph file's tree with the location in it, or None."""
    if rest and rest[0] in _FILE_SECTIONS and (len(rest) > 1 or isinstance(setup.get(str(rest[0])), Map)):
        return setup, rest
    if len(rest) > 1 and rest[0] == "graph":
        return graph_tree(setup, setup["graph"]), ("graphs", GRAPH_PATH, *rest[1:])
    if len(rest) > 1 and rest[0] == "variables":
        graph = Map(setup.places["variables"][0])
        graph.add("variables", *_entry(setup, "variables"))
        return graph_tree(setup, graph), ("graphs", GRAPH_PATH, *rest)
    return None


def graph_tree(setup: Map, graph: Any) -> Map:
    """A graph file's tree with this one graph and the setup's scene, clock, settings and fidelity."""
    root = Map(setup.at)
    root.add("tickgraph", setup.at, 1, setup.at)
    for section in _FILE_SECTIONS:
        if section in setup:
            root.add(section, *_entry(setup, section))
    if graph is not None:
        at = graph.at if isinstance(graph, Map) else setup.at
        graphs = Map(at)
        graphs.add(GRAPH_PATH, at, graph, at)
        root.add("graphs", at, graphs, at)
    return root


def _entry(setup: Map, key: str) -> tuple[int, Any, int]:
    key_at, value_at = setup.places[key]
    return key_at, setup[key], value_at


def _problem(error: Error, case: str | None, rest: Location, root: Map) -> tuple[int, str]:
    location = error.location
    kind, value = error.kind, value_at(root, location)
    if location == (case_forms.KEY,):
        return offset(root, location), _version(kind, value)
    if kind == "unknown":
        *parents, key = rest
        place = f" in {label(parents)}" if parents else ""
        known = suggestion(str(key), _fields(case, parents))
        return offset(root, location, key=True), named(case, f"unknown key {quoted(str(key))}{place}{known}")
    if kind == "missing":
        message = f'"{rest[-1]}" is missing; add it'
        where = f"{label(rest[:-1])}: " if rest[:-1] else ""
        return offset(root, location[:-1], key=True), named(case, where + message)
    at = offset(root, location)
    name = label(rest)
    if kind == "refused":
        text = error.detail
        return at, named(case, f"{name} {text}" if text.startswith(("must ", "is ", "names ")) else f"{name}: {text}")
    if kind == "limit":
        limit, size = error.detail
        if limit == "min_length":
            return at, named(case, f"{name} is empty; give it a value")
        bound = f"{size:,} or more" if limit == "ge" else f"at most {size:,}"
        return at, named(case, f"{name} must be {bound}, found {described(value)}")
    if kind == "choice":
        choices = " or ".join(repr(one) for one in error.detail)
        return at, named(case, f"{name} must be {choices}, found {described(value)}")
    return at, named(case, f"{name} must be {file_messages.wanted(kind)}, found {described(value)}")


def _version(kind: str, value: Any) -> str:
    if kind == "missing":
        return f'there is no "{case_forms.KEY}" key; a test file starts with "{case_forms.KEY}: {case_forms.VERSION}"'
    return f"{case_forms.KEY} must be {case_forms.VERSION}, the version of the format, found {described(value)}"


def _fields(case: str | None, parents: Sequence[str | int]) -> Mapping[str, Any]:
    """The fields of the model that describes the mapping at a location."""
    kind: type[Form] = case_forms.CaseFile if case is None else case_forms.Case
    match [*parents]:
        case ["expect"]:
            kind = case_forms.Expect
        case ["expect", "error"]:
            kind = case_forms.ExpectedError
        case ["expect", "warnings", _]:
            kind = case_forms.ExpectedWarning
    return kind.fields


def label(location: Sequence[str | int]) -> str:
    """A location in the words of the format: `expect.fired tick.tick`, `pulses wait.execIn`, `updates`."""
    parts = [shown(part) if isinstance(part, str) else str(part) for part in location]
    match parts:
        case []:
            return "the case"
        case ["expect", "warnings", _, *rest]:
            return ".".join(["a warning", *rest])
        case ["expect", "fired" | "values" | "outputs" | "computes" | "messages" | "frames" as section, name, *_]:
            return f"expect.{section} {name}"
        case ["inputs" | "pulses" | "changes" | "connect" | "tolerance" as section, name, *_]:
            return f"{section} {name}"
    return ".".join(parts)
