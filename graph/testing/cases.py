"""Reads the text of a `*.test.yaml` file (or an `.ogn` file with tests) to its cases; every problem has its place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.forms import FormError
from graph.base.inputs import start_of
from graph.base.limits import most
from graph.files import file_forms, paths
from graph.files import messages as file_messages
from graph.files.build import Builder
from graph.files.loading import _parser
from graph.files.played import Played, read_played
from graph.files.source import Source, decode, file_format
from graph.files.text import described
from graph.files.tree import Location, Map, Seq, offset, without
from graph.spec.file_spec import FileSpec
from graph.spec.migration import migrate

from . import case_forms, messages
from .ogn_cases import test_tree

_JOINED = ("inputs", "pulses", "changes", "settings", "fidelity", "connect", "variables")
_GRAPH_FILES = (".yaml", ".yml", ".json", ".usda", ".usd")


@dataclass(frozen=True)
class Case:
    """One test of a file. It runs one of: `node` (a type), `file` (a graph file), `spec` alone (an inline graph).

    `spec` holds the case's own scene, clock, settings and fidelity, with the graph if it is inline.
    """

    name: str
    setup: case_forms.Case
    spec: FileSpec
    file: Path | None
    node: str | None
    tree: Map
    source: Source
    play: tuple[Path, ...] = ()
    """Files whose messages its subscribers receive."""
    messages: tuple[Played, ...] = ()
    """Messages of the case itself that they receive."""

    @property
    def mark(self) -> Mark:
        """The place of the case."""
        return self.source.mark(self.tree.at)

    def at(self, *location: str | int) -> Mark:
        """The place of a part of the case, in the case itself or among the shared keys."""
        return self.source.mark(offset(self.tree, location, key=not isinstance(location[-1], int)))


@dataclass(frozen=True)
class CaseFile:
    """A test file: its name as given, its cases, and all its problems."""

    name: str
    cases: tuple[Case, ...]
    problems: tuple[Problem, ...]


def read_cases(path: str | Path, allow: Iterable[str | Path] = ()) -> CaseFile:
    """Reads a test file, or the tests of an `.ogn` file.

    Graph files named in it lie below its folder or below one of `allow`.
    """
    name, path = str(path), Path(path)
    try:
        data = start_of(path, most(f"file.{file_format(name) or 'json'}") + 1)
    except OSError as error:
        return CaseFile(name, (), (Problem(f"{name} cannot be read: {error.strerror or error}"),))
    return parse_cases(data, name, path.absolute(), allow)


def parse_cases(data: bytes, name: str, path: Path, allow: Iterable[str | Path] = ()) -> CaseFile:
    """The cases of a text; `path` is its present or future file."""
    ogn = name.lower().endswith(".ogn")
    kind = "json" if ogn else file_format(name) or "yaml"
    problems: list[Problem] = []
    if not data.strip():
        return CaseFile(name, (), (Problem(_empty(), Mark(name, 1, 1)),))
    try:
        source = decode(data, name, kind)
        root, at = _parser(kind)(source, problems)
    except UserError as error:
        return CaseFile(name, (), (*problems, *error.problems))
    if not isinstance(root, Map):
        problems.append(source.problem(at, f"{_start()}, found {described(root)}"))
        return CaseFile(name, (), tuple(problems))
    if ogn:
        root = test_tree(source, root, problems)
        if not root["cases"]:
            return CaseFile(name, (), tuple(problems))
    if case_forms.KEY not in root and not any(key in case_forms.CaseFile.fields for key in root):
        problems.append(source.problem(at, f'this is not a test file: there is no "{case_forms.KEY}" key; {_start()}'))
        return CaseFile(name, (), tuple(problems))
    root = _valid_part(source, root, problems)
    folder = path.parent
    cases = tuple(_cases(source, root, folder, [Path(one) for one in allow], _sibling(path), problems))
    return CaseFile(name, cases, _in_order(problems))


def _start() -> str:
    return f'a test file is a mapping that starts with "{case_forms.KEY}: {case_forms.VERSION}"'


def _empty() -> str:
    return f"the file is empty; {_start()}"


def _valid_part(source: Source, root: Map, problems: list[Problem]) -> Map:
    """The tree without its mistakes, which are reported."""
    reported = False
    for _ in range(4):  # leaving a part out can leave its parent incomplete; bounded
        try:
            case_forms.CaseFile.read(root)
            return root
        except FormError as error:
            errors = error.errors
        if not reported:
            problems += messages.problems_of(errors, source, root)
            reported = True
        dropped: list[Location] = file_messages.locations_of(errors)
        root = without(root, [location for location in dropped if location != ()])
        if case_forms.KEY not in root:
            root.add(case_forms.KEY, root.at, case_forms.VERSION, root.at)
    return Map(root.at)


def _cases(
    source: Source, root: Map, folder: Path, allow: Sequence[Path], sibling: Path | None, problems: list[Problem]
) -> Iterator[Case]:
    shared = Map(root.at)
    for key, value in root.items():
        if key not in (case_forms.KEY, "cases"):
            shared.add(key, root.places[key][0], value, root.places[key][1])
    for name, written in root.get("cases", Map()).items():
        at = root["cases"].places[name][0]
        tree = _joined(shared, written if isinstance(written, Map) else Map(), at)
        found: list[Problem] = []
        case = _case(source, name, tree, folder, allow, sibling, found)
        problems += [Problem(messages.named(name, one.message), one.mark) for one in found]
        if case is not None:
            yield case


def _joined(shared: Map, own: Map, at: int) -> Map:
    """The keys that apply to a case: its own, and the shared ones that it does not set."""
    joined = Map(at)
    of_graph = "graph" in own or "node" in own
    for key, value in shared.items():
        if key not in own and not (of_graph and key in ("graph", "node")):
            joined.add(key, shared.places[key][0], value, shared.places[key][1])
    for key, value in own.items():
        before = shared.get(key)
        if key in _JOINED and isinstance(before, Map) and isinstance(value, Map):
            value = _united(before, value)
        joined.add(key, own.places[key][0], value, own.places[key][1])
    return joined


def _united(before: Map, after: Map) -> Map:
    united = Map(after.at)
    for one in (before, after):
        for key, value in one.items():
            united.add(key, one.places[key][0], value, one.places[key][1])
    return united


def _case(
    source: Source,
    name: str,
    tree: Map,
    folder: Path,
    allow: Sequence[Path],
    sibling: Path | None,
    problems: list[Problem],
) -> Case | None:
    def wrong(message: str, *location: str) -> None:
        problems.append(source.problem(offset(tree, location, key=True), message))

    setup = case_forms.Case.read(tree)
    written_out = setup.graph is not None and not isinstance(setup.graph, str)
    file: Path | None = None
    if setup.graph is not None and setup.node is not None:
        wrong("give graph or node, not both", "node")
        return None
    if isinstance(setup.graph, str):
        try:
            file = paths.confined(setup.graph, folder, allow)
        except ValueError as error:
            problems.append(source.problem(offset(tree, ("graph",)), f"graph: {error}"))
            return None
    elif setup.graph is None and setup.node is None:
        file = sibling
        if file is None:
            wrong('names neither graph nor node, and no graph file of this name stands beside; add "graph" or "node"')
            return None
    if file is not None and setup.scene is not None:
        wrong("scene: the graph file has its own; leave it out", "scene")
    for key in ("connect", "variables") if setup.node is None else ():
        if getattr(setup, key):
            wrong(f"{key}: only the test of a node takes it; leave it out", key)
    graph_file = messages.graph_tree(tree, tree["graph"] if written_out else None)
    spec = Builder(source, graph_file, problems, None, folder, allow).build(file_forms.GraphFile.read(graph_file))
    files, written = _played(source, tree, setup, folder, allow, problems)
    return Case(name, setup, migrate(spec), file, setup.node, tree, source, files, written)


def _played(
    source: Source, tree: Map, setup: case_forms.Case, folder: Path, allow: Sequence[Path], problems: list[Problem]
) -> tuple[tuple[Path, ...], tuple[Played, ...]]:
    """The files and the messages of `play`."""
    value = tree.get("play")
    places = value.item_at if isinstance(value, Seq) else [offset(tree, ("play",))] * len(setup.play)
    files: list[Path] = []
    written: list[tuple[Any, int]] = []
    for entry, at in zip(setup.play, places, strict=True):
        if not isinstance(entry, str):
            written.append((entry, at))
            continue
        try:
            files.append(paths.confined(entry, folder, allow))
        except ValueError as error:
            problems.append(source.problem(at, f"play: {error}"))
    return tuple(files), tuple(read_played(source, written, problems))


def _sibling(path: Path) -> Path | None:
    """The graph file beside a test file: NAME.yaml for NAME.test.yaml."""
    stem = path.name[: path.name.lower().rindex(".test.")] if ".test." in path.name.lower() else ""
    for suffix in _GRAPH_FILES:
        beside = path.with_name(stem + suffix)
        if stem and beside.is_file():
            return beside
    return None


def _in_order(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    return tuple(sorted(dict.fromkeys(problems), key=lambda one: (one.mark or Mark("", 0, 0), one.message)))
