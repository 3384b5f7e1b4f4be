"""The table of a campaign: a row for each run, the same bytes however many workers there were.

What differs between equal runs (times, memory) is a second table.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from graph.base.outputs import replacing, write

from .folder import Folder
from .measuring import metrics_of
from .points import FILE
from .specification import Campaign

CSV, COSTS, PARQUET = "campaign.csv", "campaign_costs.csv", "campaign.parquet"
MISSING = "missing"
RUN, STATUS, EXIT, ATTEMPTS, WHY = "run", "status", "exit", "attempts", "why"
TAKEN = "the table has a column of this name; choose another"
FIRST = (RUN, STATUS, EXIT, ATTEMPTS, WHY)
_COUNTS = ("updates", "physics_steps", "simulation_time")
_OF_SENSOR, _OF_TOPIC = ("frames", "missed", "elements"), ("messages",)

Row = dict[str, Any]


def rows_of(campaign: Campaign, folder: Folder) -> list[Row]:
    """A row for each run: varied values, state, counts of its report and metrics; by column."""
    rows = []
    for number, point in enumerate(campaign.points):
        name = campaign.name_of(number)
        result = folder.result(name)
        row: Row = {RUN: number, **{key: point.get(key, "") for key in campaign.varied}}
        if result is None:
            rows.append({**row, STATUS: MISSING, EXIT: None, ATTEMPTS: 0, WHY: ""})
            continue
        row |= {key: result[key] for key in (STATUS, EXIT, ATTEMPTS, WHY)}
        found = metrics_of(folder.root / "runs" / name).items()
        metrics = {f"metric.{one}" if one in row else one: value for one, value in found}
        rows.append({**row, **metrics, **{**dict(_counts(folder.report(name))), **metrics}})
    return rows


def taken(metrics: Iterable[str], keys: Iterable[str]) -> list[str]:
    """The names that no metric may have: other columns have them, in a table whose points set these keys."""
    return sorted({*FIRST, FILE, *keys}.intersection(metrics))


def columns_of(campaign: Campaign, rows: Sequence[Row]) -> list[str]:
    """The columns: first the point and the state, then metrics, then counts, in the order of the runs."""
    first = [RUN, *campaign.varied, STATUS, EXIT, ATTEMPTS, WHY]
    return [*dict.fromkeys([*first, *campaign.metrics, *(name for row in rows for name in row)])]


def write_tables(campaign: Campaign, folder: Folder) -> list[Path]:
    """Writes the tables, Parquet if pyarrow is installed; returns their files. Raises OSError."""
    rows = rows_of(campaign, folder)
    columns = columns_of(campaign, rows)
    files = {CSV: as_csv(columns, rows), COSTS: as_csv(*_costs(campaign, folder))}
    for name, content in files.items():
        write(folder.root / name, content)
    written = [folder.root / name for name in files]
    if write_parquet(folder.root / PARQUET, columns, rows):
        written.append(folder.root / PARQUET)
    return written


def as_csv(columns: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> str:
    """The table as CSV; a value that a run does not have is an empty cell."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow([cell(row.get(name)) for name in columns])
    return stream.getvalue()


def cell(value: Any) -> str:
    """A value as text: numbers by their shortest form."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


def write_parquet(path: Path, columns: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> bool:
    """Writes the table as Parquet; False without pyarrow. A column is numbers if all its values are, else text."""
    try:
        import pyarrow as arrow
        from pyarrow import parquet
    except ImportError:
        return False
    found = {}
    for name in columns:
        values = [row.get(name) for row in rows]
        found[name] = arrow.array(*_typed(arrow, values))
    with replacing(path) as stream:
        parquet.write_table(arrow.table(found), stream)
    return True


def _typed(arrow: Any, values: Sequence[Any]) -> tuple[list[Any], Any]:
    present = [value for value in values if value is not None and value != ""]
    for kind, convert in ((arrow.int64(), _whole), (arrow.float64(), _number)):
        converted = [None if value is None or value == "" else convert(value) for value in values]
        if present and sum(one is not None for one in converted) == len(present):
            return converted, kind
    return [None if value is None else cell(value) for value in values], arrow.string()


def _whole(value: Any) -> int | None:
    try:
        return int(value) if not isinstance(value, bool | float) and abs(int(value)) < 2**63 else None
    except (ValueError, TypeError):
        return None


def _number(value: Any) -> float | None:
    try:
        return float(value) if not isinstance(value, bool) else None
    except (ValueError, TypeError):
        return None


def _counts(report: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """What a report counts that equal runs have in common, by column."""
    yield from ((name, report[name]) for name in _COUNTS if name in report)
    for path, sensor in report.get("sensors", {}).items():
        yield from ((f"{path}.{name}", sensor[name]) for name in _OF_SENSOR if name in sensor)
    for topic, counts in report.get("topics", {}).items():
        yield from ((f"{topic}.{name}", counts[name]) for name in _OF_TOPIC if name in counts)
    if "warnings" in report:
        yield "warnings", sum(one.get("count", 1) for one in report["warnings"])
    for target, value in report.get("randomized", {}).get("values", {}).items():
        values = value if isinstance(value, list) else [value]
        for index, one in enumerate(values):
            if not isinstance(one, float) or math.isfinite(one):
                yield f"randomized.{target}{f'[{index}]' if isinstance(value, list) else ''}", one


def _costs(campaign: Campaign, folder: Folder) -> tuple[list[str], list[Row]]:
    names = ("seconds", "processor", "memory")
    rows = []
    for number in range(len(campaign.points)):
        result = folder.result(campaign.name_of(number)) or {}
        rows.append({RUN: number, **{name: result.get(name) for name in names}})
    return [RUN, *names], rows
