"""`graph view`: one HTML page and pictures of a recorded run."""

from __future__ import annotations

import argparse
from pathlib import Path

from graph.base.errors import RunError, UserError
from graph.base.outputs import check_no_link, make_output
from graph.cli.arguments import add_limit, check_folder
from graph.cli.info import measure, said_of
from graph.cli.printing import counted, say, tell
from graph.cli.progress import reading

FOLDER = "view"
MOST_MB = 1000.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument(
        "run", metavar="RUN", type=Path, help="folder of a run (--out), a .mcap or .db3 file, or a rosbag2 folder"
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help=f"folder to write into (default: {FOLDER} in the folder of the run; for a file {FOLDER}/FILE beside it)",
    )
    parser.add_argument(
        "--topic", action="append", default=[], metavar="T", help="show this topic, * for any text; may be repeated"
    )
    parser.add_argument(
        "--size",
        type=float,
        default=25.0,
        metavar="MB",
        help="size of the page at most, about (default: 25); a larger page shows more frames",
    )
    add_limit(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    from graph.recording.exporting import named_topics
    from graph.recording.run_reader import open_run

    from .writing import PAGE, write_view

    if not 6 <= args.size <= MOST_MB:
        raise UserError(f"--size {args.size:g}: the page needs 6 to {MOST_MB:g} MB")
    source: Path = args.run if args.run.is_dir() else args.run.parent
    out = args.out or (source / FOLDER if args.run.is_dir() else source / FOLDER / args.run.name)
    check_folder(out)
    with open_run(args.run, whole=False) as recording, reading(recording):
        topics = named_topics(recording, args.topic)
        found = measure(recording)
        sizes = {name: found[name].size / max(1, found[name].messages) for name in topics}
        said = {name: said_of(recording, name, one) for name, one in found.items()}
        recorded = f" of {recording.provenance['file']}" if "file" in recording.provenance else ""
        summary = f"A recording{recorded}: {sum(one.messages for one in found.values()):,} messages"
        try:
            made = make_output(out, source)
            check_no_link(made / PAGE)
            written, problems = write_view(recording, sizes, said, summary, made, args.size)
        except OSError as error:
            raise RunError(f"{error.filename or out}: {error.strerror or error}") from error
        for line in (*recording.notes, *problems):
            tell(line)
    pictures = f" and {counted(len(written) - 1, 'pictures')}" if len(written) > 1 else ""
    say(f"wrote {written[0]} ({written[0].stat().st_size / 1e6:.1f} MB){pictures}")
    return 0
