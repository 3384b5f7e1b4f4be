"""Loads graph files: from a path or a text to a `FileSpec`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from types import FunctionType
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.forms import FormError
from graph.base.gc_pause import collector_paused
from graph.base.plugins import FILES, READERS, names, required
from graph.base.records import dataclass
from graph.spec.file_spec import FileSpec, GraphSpec

from . import file_forms, json_text, messages, tree
from .build import Builder
from .kinds import file_kind
from .source import Source, decode, file_format, is_usd, read
from .text import described


@dataclass(frozen=True, slots=True)
class Examined:
    """What could be read of a file, and everything that is wrong with it.

    `spec` leaves out what is wrong (and the connections of left-out nodes), so that later stages can report mistakes in
    the rest; it is None if the text itself could not be parsed.
    """

    spec: FileSpec | None
    problems: tuple[Problem, ...]
    layers: Any = None
    """Keeps the layers of a USD file in memory, so that opening the scene does not read them again."""


def load(path: str | Path, *, allow: Iterable[str | Path] = ()) -> FileSpec:
    """Reads a graph file (.yaml, .yml, .json, or a USD scene with OmniGraph prims: .usda, .usd, .usdc).

    Files named in it must lie below its own folder or below one of `allow`. Raises UserError with every problem.
    """
    return _complete(examine(path, allow=allow))


def loads(
    text: str | bytes, *, name: str = "<text>", folder: str | Path | None = None, allow: Iterable[str | Path] = ()
) -> FileSpec:
    """Reads a graph file from its text. `name` is used in messages; it ends in `.json` if the text is JSON.

    File names in the text are relative to `folder` (default: the current one). Raises UserError with every problem.
    """
    folder = Path.cwd() if folder is None else Path(folder)
    return _complete(migrated(examine_text(text, name, folder, [Path(root) for root in allow])))


def examine(path: str | Path, *, allow: Iterable[str | Path] = (), skip_outside: bool = False) -> Examined:
    """Like `load`, but returns both the valid part and the problems, for a command that reports several stages.

    skip_outside: files outside these folders that a USD file refers to are left out with a note instead of a problem.
    """
    name, roots = str(path), [Path(root) for root in allow]
    if is_usd(name) and Path(path).is_file():
        reader = required(READERS, "usd", FunctionType, "reader")  # it upgrades old ids itself
        found: Examined = reader(Path(path).absolute(), name, roots, skip_outside=skip_outside)
        return found
    return migrated(_examined(Path(path), name, roots))


def migrated(examined: Examined) -> Examined:
    """The same file with old type ids and attributes upgraded."""
    from graph.spec.migration import migrate

    return examined if examined.spec is None else replace(examined, spec=migrate(examined.spec))


def _examined(path: Path, name: str, allow: Sequence[Path]) -> Examined:
    try:
        source = read(path, name)
    except UserError as error:
        return Examined(None, error.problems)
    # The folder of the name as given, also for a symbolic link: its neighbours are the files that the user sees.
    path = path.absolute()
    return _examine(source, file_format(name) or "yaml", path, path.parent, allow)


def examine_text(text: str | bytes, name: str, folder: Path, allow: Sequence[Path] = ()) -> Examined:
    """Like `loads`, but returns both the valid part and the problems; old ids stay as they are."""
    kind = file_format(name) or "yaml"
    try:
        source = decode(text, name, kind)
    except UserError as error:
        return Examined(None, error.problems)
    return _examine(source, kind, None, folder.absolute(), allow)


def parse_value(text: str) -> Any:
    """The value of a YAML text such as `1e3`, `[1, 2]` or `on`, as plain data. Raises UserError."""
    problems: list[Problem] = []
    source = Source("<value>", text)
    if not text.strip():
        return text
    value, _ = _parser("yaml")(source, problems)
    if problems:
        raise UserError(problems)
    return value


def _complete(examined: Examined) -> FileSpec:
    if examined.problems or examined.spec is None:
        raise UserError(examined.problems)
    return examined.spec


def _parser(kind: str) -> Any:
    if kind == "json":
        return json_text.parse
    from . import yaml_text

    return yaml_text.parse


@collector_paused()
def _examine(source: Source, kind: str, path: Path | None, folder: Path, allow: Sequence[Path]) -> Examined:
    problems: list[Problem] = []
    try:
        root, at = _parser(kind)(source, problems)
    except UserError as error:
        return Examined(None, (*problems, *error.problems))
    if not isinstance(root, tree.Map):
        found = described(root)
        problems.append(source.problem(at, f'a graph file is a mapping that starts with "tickgraph: 1", found {found}'))
        return Examined(None, tuple(problems))
    if other := _another_format(root):
        problems.append(source.problem(tree.offset(root, ("tickgraph",)), other))
        return Examined(None, tuple(problems))
    file, valid, dropped = _validated(source, root, problems)
    if file is None:
        return Examined(None, _in_order(problems))
    spec = Builder(source, valid, problems, path, folder, allow).build(file)
    return Examined(_without_followers(spec, dropped), _in_order(problems))


def _another_format(root: tree.Map) -> str | None:
    """Why no key can be checked: the file is not a graph file at all, or has a newer format."""
    version = root.get("tickgraph")
    if "tickgraph" not in root and not any(key in file_forms.GraphFile.fields for key in root):
        if name := next((one for one in names(FILES) if one in root), None):
            return f"this is a {name} file, not a graph file; {file_kind(name).advice}"
        return 'this is not a graph file: there is no "tickgraph" key; a graph file starts with "tickgraph: 1"'
    if isinstance(version, int) and not isinstance(version, bool) and version > file_forms.VERSION:
        number = described(version).removeprefix("number ")
        return f"format {number} is newer than this tickgraph reads ({file_forms.VERSION}); update it"
    return None


def _validated(
    source: Source, root: tree.Map, problems: list[Problem]
) -> tuple[file_forms.GraphFile | None, tree.Map, list[tree.Location]]:
    """The validated file; invalid parts are reported and left out, and the rest is validated without them."""
    dropped: list[tree.Location] = []
    for _ in range(4):  # leaving a part out can leave its parent incomplete; bounded
        try:
            return file_forms.GraphFile.read(root), root, dropped
        except FormError as error:
            errors = error.errors
        if not dropped:
            told = {problem.mark for problem in problems}  # the value of an unreadable scalar is unknown
            problems += [one for one in messages.problems_of(errors, source, root) if one.mark not in told]
        locations = messages.locations_of(errors)
        dropped += locations
        root = tree.without(root, locations)
        if "tickgraph" not in root:
            root.add("tickgraph", root.at, file_forms.VERSION, root.at)
    return None, root, dropped


def _without_followers(spec: FileSpec, dropped: Iterable[tree.Location]) -> FileSpec:
    """The spec without connections to nodes that were left out: a second message about them would mislead."""
    lost = {(location[1], location[3]) for location in dropped if len(location) == 4 and location[2] == "nodes"}
    if not lost:
        return spec

    def stands(end: str, graph: GraphSpec) -> bool:
        node = end.rpartition(".")[0]
        path, _, name = node.rpartition("/") if node.startswith("/") else (graph.path, "", node)
        return (path, name) not in lost

    graphs = [
        replace(g, connections=tuple(c for c in g.connections if stands(c.source, g) and stands(c.target, g)))
        for g in spec.graphs
    ]
    return replace(spec, graphs=tuple(graphs))


def _in_order(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    """Problems in the order of the file, those without a place first."""
    return tuple(sorted(problems, key=lambda problem: (problem.mark or Mark("", 0, 0), problem.message)))
