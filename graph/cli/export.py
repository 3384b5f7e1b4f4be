"""`graph export`: writes a recording in the format of other tools."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from graph.base.errors import RunError
from graph.base.outputs import make_output, write

from .arguments import add_limit, check_folder
from .printing import counted, say, tell
from .progress import reading

CAMPAIGN = "campaign.json"
"""The file that makes a folder that of a campaign."""
INDEX = "runs.csv"
"""Which run of a campaign is which folder, sequence or scene."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    from graph.base.plugins import EXPORTS, loaded, names
    from graph.recording.exporting import Format

    written: dict[str, list[str]] = {}
    for plugin, form in loaded(EXPORTS, Format):
        written.setdefault(form.help, []).append(plugin.name)
    parser.add_argument(
        "run",
        metavar="RUN",
        type=Path,
        help="folder of a run (--out) or of a campaign, a .mcap or .db3 file, or a rosbag2 folder",
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
    from graph.recording.exporting import export
    from graph.recording.run_reader import open_run

    check_folder(args.out)
    if (args.run / CAMPAIGN).is_file():
        return _export_campaign(args)
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


def _export_campaign(args: argparse.Namespace) -> int:
    """Every run of a campaign that ended well: one data set as KITTI or nuScenes, else a folder for each.

    runs.csv says which is which, with the values of its point.
    """
    from graph.campaign.conduct import OK
    from graph.campaign.folder import RUNS, Folder
    from graph.campaign.points import FILE
    from graph.campaign.specification import load
    from graph.campaign.table import as_csv
    from graph.recording.exporting import export, format_of
    from graph.recording.run_reader import open_run

    campaign, folder = load(args.run), Folder(args.run)
    assert campaign is not None
    rows: list[dict[str, Any]] = []
    form = format_of(args.format)
    exporter = form.begin()
    for run, point in enumerate(campaign.points):
        name, number = campaign.name_of(run), len(rows)
        result = folder.result(name)
        if result is None or result["status"] != OK:
            tell(f"run {name} is left out: it is {result['status'] if result else 'missing'}")
            continue
        named = form.place(number) if form.place else name
        place = args.out / name if named == name else args.out
        try:
            with open_run(args.run / RUNS / name, whole=False) as recording:
                made = make_output(place, args.run)
                export(recording, args.format, made, args.topic, world=args.world, number=number, exporter=exporter)
        except OSError as error:
            raise RunError(f"{error.filename or args.out}: {error.strerror or error}") from error
        rows.append({"place": named, "run": run, **point})
    if not rows:
        raise RunError(f"{args.run}: no run of this campaign has ended well; there is nothing to export")
    columns = dict.fromkeys(("place", "run", FILE, *campaign.varied))
    try:
        exporter.finish(args.out)
        write(args.out / INDEX, as_csv([*columns], rows))
    except OSError as error:
        raise RunError(f"{error.filename or args.out}: {error.strerror}") from error
    say(f"wrote {counted(len(rows), 'runs')} into {args.out} ({args.format})")
    return 0
