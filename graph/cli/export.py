"""`graph export`: writes a recording in the format of other tools."""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path

from graph.base.errors import RunError
from graph.base.outputs import make_output
from graph.base.plugins import EXPORTS, FILES, loaded, names, shipped

from .arguments import add_limit, check_folder
from .printing import say, tell
from .progress import reading


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    from graph.recording.exporting import Format

    several = "".join(f" or of a {name}" for name in shipped(FILES))
    written: dict[str, list[str]] = {}
    for plugin, form in loaded(EXPORTS, Format):
        written.setdefault(form.help, []).append(plugin.name)
    parser.add_argument(
        "run",
        metavar="RUN",
        type=Path,
        help=f"folder of a run (--out){several}, a .mcap or .db3 file, or a rosbag2 folder",
    )
    parser.add_argument(
        "--format",
        required=True,
        choices=names(EXPORTS),
        help="; ".join(f"{', '.join(some)}: {text}" for text, some in written.items()),
    )
    parser.add_argument("--out", required=True, type=Path, metavar="DIR", help="folder to write into")
    parser.add_argument(
        "--topic", action="append", default=[], metavar="T", help="export this topic, * for any text; may be repeated"
    )
    parser.add_argument(
        "--world", action="store_true", help="points of pcd, ply, las in the root frame of the recorded transforms"
    )
    add_limit(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    from graph.files.kinds import file_kind, kind_of_folder
    from graph.recording.exporting import export
    from graph.recording.run_reader import open_run

    check_folder(args.out)
    if kind := kind_of_folder(args.run):
        return int(import_module(file_kind(kind).module).export(args))
    source: Path = args.run if args.run.is_dir() else args.run.parent
    with open_run(args.run, whole=False) as recording:
        for note in recording.notes:
            tell(note)
        try:
            with reading(recording):
                out = make_output(args.out, source)
                lines = export(recording, args.format, out, args.topic, world=args.world)
        except OSError as error:
            raise RunError(f"{error.filename or args.out}: {error.strerror or error}") from error
    for line in lines:
        say(line)
    return 0
