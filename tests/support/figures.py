"""The figures of `tests/benchmarks/measured.json` as the tables that the manual and README show.

`python tests/benchmarks/run.py --keep [NAME...]` measures them, stores them and writes the pages.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from tests.support.places import ROOT

MEASURED = ROOT / "tests" / "benchmarks" / "measured.json"
ORDER = ("lidar", "camera", "radar", "multitick", "peers", "update", "engine", "nodes", "files", "start")
"""Groups that come first on the page; others follow."""
UNITS = {"x": "×", "us": "µs"}
CASES = "python tests/benchmarks/run.py"


@dataclass(frozen=True)
class Figure:
    """A row of README: what was measured, the sentence around the value, and where the value comes from.

    group: of the benchmarks; "" for a case of `graph doctor --stability`. row: a part of the row's name, of no other's.
    """

    what: str
    said: str
    group: str
    row: str


SHOWN = (
    Figure("a sensor's ticks at 0.001 to 100,000 Hz", "stamps within {}", "", "ticks at"),
    Figure("a lidar's range to a wall at 1e-6 to 1e6 m", "within {}", "", "a wall at"),
    Figure("a fall, up to 1e8 m from the origin", "within {}", "", "a fall 0"),
    Figure(
        "a lidar of 32 × 1800 rays in the yard",
        "{} its bare ray casts",
        "lidar",
        "yard, robot turns: one second, one lidar at 10 Hz, point cloud only",
    ),
    Figure(
        "100 moving bodies, over mujoco-lidar (Warp, CPU)",
        "{} as fast",
        "peers",
        "mujoco-lidar (Warp): 100 moving boxes and spheres",
    ),
)
"""The figures of README."""


def measured() -> dict[str, dict[str, Any]]:
    """The groups of benchmarks: title, rows, machine, date and command."""
    groups: dict[str, dict[str, Any]] = json.loads(MEASURED.read_text(encoding="utf8"))
    return {name: groups[name] for name in sorted(groups, key=lambda name: (*ORDER, name).index(name))}


def sections() -> Iterator[tuple[str, str, list[tuple[str, str, str]]]]:
    """Of each group a heading, a line of what it is (or ""), and rows: case, result, goal."""
    for group in measured().values():
        heading, _, of = group["title"].partition(": ")
        yield (
            _capital(heading),
            of and f"{_capital(of)}.",
            [(row["what"], result(row), goal(row)) for row in group["rows"]],
        )


def result(row: dict[str, Any]) -> str:
    """A value with its unit, to three digits."""
    value = _number(row["value"])
    return f"{value} {UNITS.get(row['unit'], row['unit'])}"


def goal(row: dict[str, Any]) -> str:
    """What the value has to be; "" if it has no bound."""
    if row["bound"] is None:
        return ""
    most = row["best"] == "most"
    kept = row["value"] >= row["bound"] if most else row["value"] <= row["bound"]
    return f"{'at least' if most else 'at most'} {_number(row['bound'])}{'' if kept else ' (missed)'}"


def origins() -> Iterator[str]:
    """Where the figures come from: a line for each day and machine, with its groups."""
    found: dict[str, list[str]] = {}
    for name, group in measured().items():
        machine = group["machine"]
        packages = ", ".join(f"{package} {version}" for package, version in machine.get("packages", {}).items())
        parts = (
            machine["processor"],
            f"{machine['cores']} cores",
            f"Python {machine['python']}" if "python" in machine else "",
            packages,
        )
        where = ", ".join(part for part in parts if part)
        found.setdefault(f"Measured {group['date']} on {where}", []).append(f"`{name}`")
    return (f"{where}: {', '.join(names)}." for where, names in found.items())


def shown(stability: Iterable[list[str]]) -> Iterator[tuple[str, str, str]]:
    """The rows of README: what was measured, the result, the command. stability: the rows of the manual's table."""
    cases = {cells[1]: _value(cells[3]) for cells in stability}
    for one in SHOWN:
        if one.group:
            rows = {row["what"]: result(row) for row in measured()[one.group]["rows"]}
            command = f"{CASES} {one.group}"
        else:
            rows, command = cases, f'graph doctor --stability --only "{one.row}"'
        [value] = [value for name, value in rows.items() if one.row in name]
        yield one.what, one.said.format(value), f"`{command}`"


def _value(measured: str) -> str:
    """A measured value of the stability table with its unit, without the place of the worst: `2e-08 m at 1e+08`."""
    return re.sub(r" at .*$", "", measured)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _number(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
