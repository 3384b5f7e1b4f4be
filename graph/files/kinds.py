"""Kinds of files beside graph files. A plug-in brings each; its name is the first key of such a file."""

from __future__ import annotations

from pathlib import Path

from graph.base.errors import UserError
from graph.base.plugins import FILES, names, required
from graph.base.records import dataclass

GRAPH = "tickgraph"
"""The key of a graph file."""


@dataclass(frozen=True, slots=True)
class FileKind:
    """A kind of YAML file, declared in the entry point group `tickgraph.files` under the key that such a file has.

    A folder with a file NAME.json holds what a file of the kind NAME produced, in several runs.

    help: what these files are, in a few words. advice: what to do with one, for who takes it for a graph file.
    module: the one with `check(file, allow, **options) -> Checked`, `schema() -> dict` and `export(args) -> int`, for
    the commands of these names; imported when a command needs it.
    """

    help: str
    advice: str
    module: str


def kind_of(path: Path) -> str | None:
    """The kind of a YAML file; None for a graph file, another format, or a file that cannot be read."""
    from .source import read  # the start of the command does without it

    if path.suffix.lower() not in (".yaml", ".yml"):
        return None
    try:
        keys = {line.partition(":")[0] for line in read(path, str(path)).text.splitlines()}
    except UserError:
        return None
    if GRAPH in keys:
        return None
    return next((name for name in names(FILES) if name in keys), None)


def kind_of_folder(path: Path) -> str | None:
    """The kind of file whose runs a folder holds; None for the folder of one run."""
    return next((name for name in names(FILES) if (path / f"{name}.json").is_file()), None)


def file_kind(name: str) -> FileKind:
    """The kind of a name. Raises UserError for one that cannot be used."""
    return required(FILES, name, FileKind, "kind of file")
