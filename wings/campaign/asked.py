"""What `graph sweep` is asked for: the campaign of its command line and of a campaign file."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from graph.base.errors import Problem, UserError
from graph.files import examine
from graph.files.kinds import kind_of
from graph.session.varied import read_varied, word_of

from .file import KIND, Asked, read_campaign
from .measuring import parsed
from .points import FILE, check_key, check_value, points_of, read_table
from .specification import Campaign, hashes_of
from .table import TAKEN, taken


def new_campaign(args: argparse.Namespace) -> Campaign:
    """The campaign of a command line. Raises UserError with every mistake, OverLimit for too many runs."""
    asked = _asked(args)
    points = points_of(asked.files, asked.varied, asked.rows, asked.fixed, asked.seed)
    keys = dict.fromkeys(key for point in points for key in point)
    named = {one.name for one in asked.varied}
    varied = [key for key in keys if len({point.get(key) for point in points}) > 1 or key in named]
    common, read = _common(args)
    scenes = [scene for file in asked.files for scene in _scenes(Path(file))]
    hashes = hashes_of([*asked.files, *scenes, *asked.read, *read])
    varied = [key for key in varied if key != FILE or len(asked.files) > 1]
    return Campaign(points, varied, common, dict(asked.metrics), hashes)


def _asked(args: argparse.Namespace) -> Asked:
    """What the options and the campaign file ask for together. Raises UserError with every mistake."""
    of_file = [file for file in args.files if file.is_file() and kind_of(file) == KIND]
    if of_file and len(args.files) > 1:
        raise UserError(f"{of_file[0]} is a campaign file, which names its graph files; give it alone")
    asked = (
        read_campaign(of_file[0], args.allow) if of_file else Asked(tuple(map(str, args.files)), seed=args.vary_seed)
    )
    problems: list[Problem] = []
    varied = {one.name: one for one in asked.varied}
    files = asked.files
    for option in args.vary:
        name, equals, text = option.partition("=")
        try:
            if not equals:
                raise ValueError("write it as KEY=V1,V2,...")
            check_key(name)
            if name in varied:
                raise ValueError("the key is varied twice; give all its values in one --vary")
            found = read_varied(name, text, asked.seed)
            for value in found.values:
                check_value(name, value)
            if name == FILE:
                files = (*files, *found.values)
            else:
                varied[name] = found
        except ValueError as error:
            problems.append(Problem(f"--vary {option}: {error}"))
    metrics = dict(asked.metrics)
    for option in args.metric:
        name, equals, text = option.partition("=")
        try:
            if not equals or not name:
                raise ValueError("write it as NAME=EXPR")
            if name in metrics:
                raise ValueError("the metric is given twice; name one of them differently")
            parsed(text)
            metrics[name] = text
        except ValueError as error:
            problems.append(Problem(f"--metric {option}: {error}"))
    rows, read = asked.rows, asked.read
    if args.points is not None:
        try:
            rows, read = tuple(read_table(args.points)), (*read, args.points)
            if FILE in rows[0] and files:
                problems.append(Problem(f"--points {args.points} names its own files; give no other FILE"))
        except UserError as error:
            problems += error.problems
    named = taken(metrics, [*varied, *(key for row in rows for key in row)])
    problems += [Problem(f"--metric {name}: {TAKEN}") for name in named]
    clash = {key for row in rows for key in row if key in varied}
    problems += [Problem(f"--points: {key} is varied too; leave it out of one of them") for key in sorted(clash)]
    files = (*dict.fromkeys([*files, *(row[FILE] for row in rows if FILE in row)]),)
    for file in files:
        if not Path(file).is_file():
            problems.append(Problem(f"{file}: there is no such file"))
    if problems:
        raise UserError(problems)
    return replace(asked, files=files, varied=tuple(varied.values()), rows=rows, metrics=metrics, read=read)


def _scenes(file: Path) -> Iterator[Path]:
    """The scene's file of a graph file, which decides about results as well."""
    spec = examine(file).spec
    if spec is not None:
        yield from (one for one in (spec.scene.usd, spec.scene.mjcf) if one is not None and one.is_file())


def _common(args: argparse.Namespace) -> tuple[list[str], list[Path]]:
    """The options of `graph run` that all runs have, and the files that they name."""
    found: list[str] = []
    for flag, values in (
        ("set", args.set), ("fidelity", args.fidelity), ("limit", args.limit), ("asset-root", args.asset_root),
        ("allow", args.allow), ("nodes", args.node_files), ("play", args.play),
    ):  # fmt: skip
        for value in values:
            found += [f"--{flag}", str(value)]
    for flag in ("skip_unknown", "skip_outside", "allow_scripts"):
        found += [f"--{flag.replace('_', '-')}"] if getattr(args, flag) else []
    for flag in ("duration", "updates"):
        found += [f"--{flag}", str(getattr(args, flag))] if getattr(args, flag) is not None else []
    found += [f"--{path}={word_of(value)}" for path, value in args.settings.items()]
    return found, [*args.node_files, *(one for one in args.play if one.is_file())]
