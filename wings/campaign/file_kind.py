"""Campaign files and folders in `graph check`, `graph schema` and `graph export`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from graph.base.errors import Problem, RunError, UserError
from graph.base.outputs import make_output, write
from graph.cli.check import Checked
from graph.cli.check import check as check_graph
from graph.cli.main import split_settings
from graph.cli.printing import counted, say, tell
from graph.spec.file_spec import Note

from .conduct import OK
from .file import CampaignFile, read_campaign
from .folder import RUNS, Folder
from .points import FILE, arguments_of, points_of
from .specification import load
from .table import as_csv

INDEX = "runs.csv"
"""Which run of a campaign is which folder, sequence or scene."""


def schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of campaign files, for editors."""
    about = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "TickGraph campaign file"}
    return {**about, **CampaignFile.schema()}


def check(file: str, allow: Sequence[Path], **options: Any) -> Checked:
    """Checks a campaign file, and each of its graph files with the values of its first run."""
    try:
        asked = read_campaign(Path(file), allow)
        points = points_of(asked.files, asked.varied, asked.rows, asked.fixed, asked.seed)
    except UserError as error:
        return Checked(file, None, tuple(error.problems))
    problems: list[Problem] = []
    notes: list[Note] = []
    for point in {point[FILE]: point for point in reversed(points)}.values():
        rest, settings = split_settings(arguments_of(point, ()))
        overrides = dict(text.partition("=")[::2] for flag, text in pairwise(rest) if flag == "--set")
        one = check_graph(point[FILE], allow=allow, settings=settings, overrides=overrides, **options)
        problems += one.problems
        notes += one.notes
    return Checked(file, None, tuple(problems), tuple(dict.fromkeys(notes)), {"runs": len(points)})


def export(args: argparse.Namespace) -> int:
    """Every run of a campaign that ended well: one data set as KITTI or nuScenes, else a folder for each.

    runs.csv says which is which, with the values of its point.
    """
    from graph.recording.exporting import export as export_run
    from graph.recording.exporting import format_of
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
                export_run(recording, args.format, made, args.topic, world=args.world, number=number, exporter=exporter)
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
