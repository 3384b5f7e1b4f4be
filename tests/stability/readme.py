"""The table of cases at the extremes in the README: measured again, and written.

python -m tests.stability.readme [--slow]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from graph.stability.table import CASES, HEADINGS, markdown, outcomes
from tests.support.places import ROOT

COMMAND = ".venv/bin/python -m tests.stability.readme"
HEAD = f"| {' | '.join(HEADINGS)} |"


def table_of(page: Path) -> list[str]:
    """The lines of the page's table; empty for a page without it."""
    lines = page.read_text(encoding="utf8").splitlines()
    if HEAD not in lines:
        return []
    start = lines.index(HEAD)
    end = next((number for number in range(start, len(lines)) if not lines[number].startswith("|")), len(lines))
    return lines[start:end]


def main(arguments: Sequence[str] | None = None) -> int:
    """Writes the table; a slow case keeps its measured value unless it is asked for."""
    slow = "--slow" in (sys.argv[1:] if arguments is None else arguments)
    page = ROOT / "README.md"
    before = table_of(page)
    kept = {line.split(" | ")[1]: line for line in before[2:]}
    run = {one.case.name: one for one in outcomes(case for case in CASES if slow or not case.slow)}
    lines = markdown(run.values()).splitlines()
    rows = dict(zip(run, lines[2:], strict=True))
    whole = [*lines[:2], *(rows.get(case.name) or kept[case.name] for case in CASES)]
    text = page.read_text(encoding="utf8").replace("\n".join(before), "\n".join(whole))
    page.write_text(text, encoding="utf8")
    return 0 if all(one.ok for one in run.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
