"""The folder of a campaign: a folder for each finished run, which appears whole, and what is known of each.

campaign.json            the specification
runs/0017/               report.json, the recording, log.txt, result.json
campaign.csv             the table; campaign_costs.csv: what each run cost
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from graph.base.inputs import read
from graph.base.outputs import make_folder, remove_folder, rename, write

RUNS, PART, RESULT, REPORT = "runs", ".part-", "result.json", "report.json"

Result = dict[str, Any]
"""A finished run: number, status, exit, attempts, why, metrics, and seconds, processor, memory."""


class Folder:
    """The runs of a campaign on disk."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def begin(self, name: str) -> Path:
        """A new folder for an attempt at a run. Raises OSError."""
        return make_folder(self.root, RUNS, f"{PART}{name}-{secrets.token_hex(4)}").absolute()

    def commit(self, part: Path, name: str, result: Mapping[str, Any]) -> None:
        """Makes an attempt the result of its run; an earlier result is replaced. Raises OSError."""
        write(part / RESULT, json.dumps(result, indent=1, ensure_ascii=False) + "\n")
        place = self.root / RUNS / name
        remove_folder(place)
        rename(part, place)

    def drop(self, part: Path) -> None:
        """Removes an attempt."""
        with suppress(OSError):
            remove_folder(part)

    def tidy(self) -> None:
        """Removes the attempts that a campaign left when it was killed."""
        runs = self.root / RUNS
        for one in runs.glob(f"{PART}*") if runs.is_dir() else ():
            self.drop(one)

    def result(self, name: str) -> Result | None:
        """The result of a run; None if it has not finished."""
        return self._data(name, RESULT)

    def report(self, name: str) -> dict[str, Any]:
        """The report of a run; empty without one."""
        return self._data(name, REPORT) or {}

    def _data(self, name: str, file: str) -> dict[str, Any] | None:
        try:
            found = json.loads(read(self.root / RUNS / name / file, "campaign.table"))
        except (OSError, ValueError, RecursionError):
            return None
        return found if isinstance(found, dict) else None
