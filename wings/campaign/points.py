"""The points of a campaign: the values that differ between runs, and the command line of each run."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.inputs import read_text
from graph.base.limits import check
from graph.session.varied import Varied, drawn_at
from graph.sim.fidelity import KNOBS

FILE = "file"
JOIN = "+"
OPTIONS = ("seed", "duration", "updates")
"""Keys that are options of `graph run`."""

Point = Mapping[str, str]
"""Values as text by key; `file` is the graph file."""


def points_of(
    files: Sequence[str], varied: Sequence[Varied], rows: Sequence[Point], fixed: Point, seed: int
) -> list[dict[str, str]]:
    """Every point, in order: files, then rows of the table, then combinations of values, the last key fastest.

    Rows that name their own file are not combined with others. A key of the fixed values has one value in every point,
    unless a row has another. Raises OverLimit for too many.
    """
    grid = [one for one in varied if not one.draw]
    begun = [(row[FILE], row) for row in rows] if rows and FILE in rows[0] else [*product(files, rows or [{}])]
    number = len(begun) * math.prod(len(one.values) for one in grid)
    check("campaign.runs", number, f"a campaign of {number:,} runs")
    found: list[dict[str, str]] = []
    for file, row in begun:
        for values in product(*(one.values for one in grid)):
            chosen = dict(zip((one.name for one in grid), values, strict=True))
            at = len(found)
            point = {one.name: chosen.get(one.name) or drawn_at(one, seed, at) for one in varied}
            found.append({FILE: file, **fixed, **row, **point})
    return found


def arguments_of(point: Point, common: Sequence[str]) -> list[str]:
    """The command line of `graph` that runs one point by itself, with the same result as in the campaign."""
    found = ["run", point[FILE], *common]
    for key, value in point.items():
        if key == FILE:
            continue
        for one in key.split(JOIN):
            if one in OPTIONS:
                found += [f"--{one}", value]
            elif one in KNOBS:
                found += ["--fidelity", f"{one}={value}"]
            elif is_setting(one):
                found.append(f"--{one.removeprefix('--')}={value}")
            else:
                found += ["--set", f"{one}={value}"]
    return found


def is_setting(key: str) -> bool:
    """Whether a key is a path of the settings tree: `/a/b`, or `--/a.b/c` where it has a dot."""
    return key.startswith("--/") or (key.startswith("/") and "." not in key.rpartition("/")[2])


def check_key(key: str) -> None:
    """Raises ValueError for a key that no run can set."""
    from graph.base.suggest import did_you_mean

    for one in key.split(JOIN):
        owner, dot, attribute = one.rpartition(".")
        if one in (*OPTIONS, FILE) or one in KNOBS or is_setting(one) or (dot and owner and attribute):
            continue
        near = did_you_mean(one, [*KNOBS, *OPTIONS, FILE])
        forms = "; a key is seed, duration, updates, file, a fidelity knob, NODE.ATTR, /PRIM/PATH.ATTR, clock.KEY"
        raise ValueError(f'"{one}" is nothing that a run can set{near or f"{forms}, scene.KEY or a setting"}')


def check_value(key: str, value: str) -> None:
    """Raises ValueError for a value that a fidelity knob, `seed` or `updates` cannot have."""
    for one in key.split(JOIN):
        if one in KNOBS:
            KNOBS[one].checked(value)
        elif one in ("seed", "updates"):
            try:
                int(value)
            except ValueError:
                raise ValueError(f"{value} is not a whole number") from None


def read_table(path: Any) -> list[dict[str, str]]:
    """The points of a CSV file: a row each, a column for each key; an empty cell sets nothing.

    Raises UserError with line and column of each mistake.
    """
    try:
        text = read_text(path, "campaign.table")
    except OSError as error:
        raise UserError(f"--points {path}: {error.strerror}; name a CSV file") from None
    lines = csv.reader(io.StringIO(text), strict=True)
    problems: list[Problem] = []
    rows: list[dict[str, str]] = []
    keys: list[str] = []
    try:
        for cells in lines:
            where = lines.line_num
            cells = [cell.strip() for cell in cells]
            if not keys:
                keys = cells
                problems += _key_problems(str(path), keys)
            elif any(cells):
                if len(cells) != len(keys):
                    wrong = f"{len(cells)} cells, but there are {len(keys)} keys in the first line"
                    problems.append(Problem(wrong, Mark(str(path), where, 1)))
                if FILE in keys and not dict(zip(keys, cells, strict=False)).get(FILE):
                    problems.append(Problem("the cell of file is empty; name a graph file", Mark(str(path), where, 1)))
                rows.append({key: cell for key, cell in zip(keys, cells, strict=False) if cell})
    except csv.Error as error:
        problems.append(Problem(f"this is not CSV: {error}", Mark(str(path), lines.line_num, 1)))
    if not rows and not problems:
        problems.append(
            Problem("there is no point; write the keys in the first line, a point in each other", Mark(str(path), 1, 1))
        )
    if problems:
        raise UserError(problems)
    return rows


def _key_problems(name: str, keys: Sequence[str]) -> Iterator[Problem]:
    for column, key in enumerate(keys, 1):
        place = Mark(name, 1, column)
        if key in keys[: column - 1]:
            yield Problem(f'the key "{key}" is there twice', place)
        try:
            check_key(key)
        except ValueError as error:
            yield Problem(f"column {column}: {error}", place)
