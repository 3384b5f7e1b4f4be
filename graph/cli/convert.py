"""`graph convert`: writes one graph file in another format (YAML, JSON, USD), with the same content."""

from __future__ import annotations

import argparse
import os
import shlex
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from graph.base.errors import UserError
from graph.base.inputs import start_of
from graph.base.outputs import write
from graph.base.shorten import listed
from graph.spec.file_spec import GraphSpec, Note

from .arguments import add_allow, add_nodes, add_skip_outside
from .printing import note_line, tell

_FORMATS = {".yaml": "yaml", ".yml": "yaml", ".json": "json", ".usda": "usd", ".usd": "usd", ".usdc": "usd"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("source", metavar="IN", help="graph file (.yaml, .json, .usda, .usd, .usdc)")
    parser.add_argument("target", metavar="OUT", help="file to write (or overwrite); its name's ending says the format")
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    if Path(args.target).resolve() == Path(args.source).resolve():
        raise UserError(f"{args.target} is the file to convert; name another one to write")
    for note in convert(args.source, args.target, allow=args.allow, skip_outside=args.skip_outside):
        tell(note_line(note))
    return 0


def convert(source: str, target: str, *, allow: Sequence[Path] = (), skip_outside: bool = False) -> tuple[Note, ...]:
    """Writes the graph file `source` as `target`, in the format of its extension; returns warnings.

    If anything is wrong nothing is written: raises UserError with every problem of the file itself. Graphs are not
    compiled, so a file with unknown node types can be converted too.
    """
    kind = _FORMATS.get(Path(target).suffix.lower())
    if kind is None:
        raise UserError(f"{target}: unknown extension; use one of {', '.join(_FORMATS)}")
    folder = Path(target).absolute().parent
    if not folder.is_dir():
        raise UserError(f"{target}: there is no folder {folder}; make it first")
    from graph.files import examine
    from graph.session.partial_compile import without_untyped

    examined = examine(source, allow=allow, skip_outside=skip_outside)
    if examined.problems or examined.spec is None:
        raise UserError(examined.problems)
    spec = without_untyped(examined.spec)
    if spec.scene.usd is not None and spec.scene.usd.resolve() == Path(target).resolve():
        raise UserError(f"{target} is the scene of {source}; name another file to write")
    if _FORMATS.get(Path(source).suffix.lower()) == "usd":
        document, comments, text = _of_usd(source, spec)
    else:
        document, comments, text = _of_text(source)
    moved = _relocated(document, Path(source).absolute().parent, folder)
    if kind == "usd":
        from graph.usd_files.writing import layer_of

        layer = layer_of(spec, moved, folder, comments, allow=allow, skip_outside=skip_outside)
        _write_usd(Path(target), layer)
    else:
        from graph.files.writing import json_document, yaml_document

        same_format = kind == _FORMATS.get(Path(source).suffix.lower()) and moved == document
        whole = text if same_format and text is not None else None
        written = whole or (json_document(moved) if kind == "json" else yaml_document(moved, comments))
        _write(Path(target), written.encode("utf-8", "surrogatepass"))
    return (*spec.notes, *_flattened(spec.graphs), *_outside(moved, target))


def _flattened(graphs: Sequence[GraphSpec]) -> Iterator[Note]:
    """A warning for each graph with compounds, which the graph file format does not have."""
    for graph in graphs:
        inside = {one: [n.name for n in graph.nodes if n.name.startswith(f"{one}/")] for one in graph.compounds}
        names = [one for one, nodes in inside.items() if nodes]
        if names:
            example = inside[names[0]][0]
            message = (
                f"{graph.path}: the nodes in {listed(names)} become its own, such as {example}; the ports are gone"
            )
            yield "compound-flattened", str(graph.mark or graph.path), message


def _outside(document: Mapping[str, Any], target: str) -> Iterator[Note]:
    """A warning if the written file names files outside its own folder, which commands read only with `--allow`."""
    from graph.files.document import named_files

    folder = Path(target).absolute().parent.resolve()
    out = [name for name in named_files(document) if not (folder / name).resolve().is_relative_to(folder)]
    if out:
        folders = {Path(os.path.relpath((folder / name).resolve().parent)).as_posix(): None for name in out}
        allow = " ".join(f"--allow {shlex.quote(each)}" for each in folders)
        message = f"it names {listed(out)}, outside its folder; give {allow} with it, or move the files"
        yield "files-outside", target, message


def _of_text(source: str) -> tuple[dict[str, Any], dict[str, str], str | None]:
    """A YAML or JSON file as written: document, comments, text."""
    from graph.files.comments import comments_of
    from graph.files.document import parsed, simple

    root, text = parsed(Path(source), source)
    comments = comments_of(root, text) if _FORMATS[Path(source).suffix.lower()] == "yaml" else {}
    return simple(root), comments, text


def _of_usd(source: str, spec: Any) -> tuple[dict[str, Any], dict[str, str], None]:
    from graph.files.document import graph_document, simple
    from graph.usd_files.reading import documentation, whole_document

    document = whole_document(Path(source), {graph.path: graph_document(graph) for graph in spec.graphs})
    return simple(document), documentation(Path(source), spec), None


def _relocated(document: Mapping[str, Any], old: Path, new: Path) -> dict[str, Any]:
    from graph.files.document import relocated

    return relocated(document, old, new)


def _write_usd(target: Path, layer: Any) -> None:
    if target.suffix.lower() == ".usda":
        _write(target, layer.ExportToString().encode())
        return
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / f"layer{target.suffix}"
        try:
            layer.Export(str(made))
        except Exception as error:  # the text in which USD writes it
            reason = " ".join(str(error).split())[-120:]
            raise UserError(f"{target} cannot be written: {reason}") from None
        _write(target, start_of(made, made.stat().st_size))


def _write(target: Path, data: bytes) -> None:
    try:
        write(target, data)
    except OSError as error:
        raise UserError(f"{target} cannot be written: {error.strerror}") from None
