"""Stores the results of benchmarks as JSON, with the machine they come from, and finds those of the run before."""

from __future__ import annotations

import json
import os
import platform
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from measure import Row

FOLDER = Path(__file__).parents[2] / "build" / "benchmarks"
MEASURED = Path(__file__).with_name("measured.json")
"""What the manual and README show: of each group its title, rows, machine, date and command."""
PACKAGES = ("mujoco-core", "open3d", "open3d-cpu", "usd-core", "numpy")


def machine() -> dict[str, Any]:
    """What figures depend on: processor, cores that this process may use, system, Python, packages."""
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "system": platform.platform(terse=True),
        "python": platform.python_version(),
        "packages": {name: found for name in PACKAGES if (found := _version(name))},
    }


def _processor() -> str:
    """Its name, from Linux's list where there is one."""
    listed = Path("/proc/cpuinfo")
    lines = listed.read_text().splitlines() if listed.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def save(rows: dict[str, list[Row]], folder: Path = FOLDER) -> Path:
    """Write one run's rows by group into a file of its own; its path."""
    folder.mkdir(parents=True, exist_ok=True)
    now = datetime.now(UTC)
    path = folder / f"{now:%Y-%m-%dT%H-%M-%S}.json"
    groups = {name: [as_data(row) for row in group] for name, group in rows.items()}
    text = json.dumps({"date": now.isoformat(timespec="seconds"), "machine": machine(), "rows": groups}, indent=2)
    path.write_text(text + "\n")
    return path


def keep(name: str, title: str, rows: list[Row]) -> None:
    """Replace one group of the figures that the manual shows; one that has no rows on this machine stays."""
    if not rows:
        return
    groups: dict[str, Any] = json.loads(MEASURED.read_text()) if MEASURED.exists() else {}
    columns = ("what", "value", "unit", "bound", "best")
    groups[name] = {
        "title": title,
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "command": f"python tests/benchmarks/run.py {name} --keep",
        "machine": machine(),
        "rows": [{column: as_data(row)[column] for column in columns} for row in rows],
    }
    MEASURED.write_text(json.dumps(dict(sorted(groups.items())), indent=1) + "\n")


def as_data(row: Row) -> dict[str, Any]:
    """A row as JSON has it."""
    return {**vars(row), "value": float(row.value), "spread": row.spread, "kept": row.kept}


def before(folder: Path = FOLDER) -> dict[tuple[str, str], float]:
    """The last value stored for each group and row on a machine like this one; files that do not read are passed."""
    here = machine()
    values: dict[tuple[str, str], float] = {}
    for path in sorted(folder.glob("*.json")):
        try:
            run = json.loads(path.read_text())
            if run["machine"] == here:
                values |= {(name, row["what"]): row["value"] for name, group in run["rows"].items() for row in group}
        except (ValueError, KeyError, TypeError):
            continue
    return values
