"""Measures the errors of every setting; settings that are the same run are made once.

A run depends on the knobs that it reads and on nothing else: settings that agree in these are the same run, as
`lidar.bins=8` and `lidar.bins=16` are with `lidar.motion=frozen`.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from pathlib import Path

from graph.sim.fidelity import KNOBS, Fidelity

from .jobs import Compare
from .outcome import CRASHED, REFUSED, UNFINISHED, Outcome, Row
from .study import Setting
from .trial import CLOCKS
from .workers import Crashed, Pool

CHOICES = CLOCKS | {name for name, knob in KNOBS.items() if knob.kind in ("choice", "switch")}
"""Knobs that decide which others are read, and those that every run reads."""


def measure_rows(
    outcome: Outcome, known: list[Row], present: Fidelity, pool: Pool, reference: Path, count: Callable[[int], None]
) -> None:
    """Measures the unfinished rows against the kept reference. known: runs made so far; present: the file's knobs.

    A row that is the same run as another one is merged into it.
    """
    while left := _adopt(outcome, known, present, count):
        wave = _apart(left, known, present)
        jobs = [Compare(row.setting, outcome.study.duration, reference, outcome.horizon) for row in wave]
        for number, found in pool.results(jobs, at_once=True):
            row = wave[number]
            if isinstance(found, Crashed):
                row.status, row.why = status_of(found), found.why
            else:
                measured, errors = found
                row.take(measured, errors)
                known.append(row)
            count(1)


def status_of(found: Crashed) -> str:
    """The status of a run that failed."""
    return REFUSED if found.problems else CRASHED


def _adopt(outcome: Outcome, known: list[Row], present: Fidelity, count: Callable[[int], None]) -> list[Row]:
    """Merges the unfinished rows that a known run covers; returns the others."""
    left, rows = [], []
    for row in outcome.rows:
        if row.status != UNFINISHED:
            rows.append(row)
            continue
        twin = next((one for one in known if same_run(one, row.setting, present)), None)
        if twin is None:
            left.append(row)
            rows.append(row)
        elif any(one is twin for one in outcome.rows):
            twin.also.append(row.setting)
            count(1 + outcome.study.repeat)
        else:  # a run that was made for the reference
            row.copy(twin)
            known.insert(0, row)  # before the twin
            rows.append(row)
            count(1)
    outcome.rows = rows
    return left


def same_run(known: Row, setting: Setting, present: Fidelity) -> bool:
    """Whether a setting is the same run as a known one. present: the knobs of the file, for those it does not have."""
    names = {*known.setting, *setting}
    return _values(known.setting, names, known.read, present) == _values(setting, names, known.read, present)


def _apart(left: list[Row], known: list[Row], present: Fidelity) -> list[Row]:
    """One row of each group that may be the same run, judged by the knobs that similar runs have read."""
    found: dict[Hashable, Row] = {}
    for row in left:
        names, read = {*row.setting}, CHOICES
        choices = _values(row.setting, names, CHOICES, present)
        for one in known:
            if _values(one.setting, names, CHOICES, present) == choices:
                read = CHOICES | one.read
                break
        found.setdefault(_values(row.setting, names, read, present), row)
    return [*found.values()]


def _values(setting: Setting, names: Iterable[str], read: frozenset[str], present: Fidelity) -> Hashable:
    """The values of the attributes and of the read knobs among `names`."""
    kept = sorted(name for name in names if name not in KNOBS or name in read)
    return tuple(
        (name, setting[name] if name in setting else present[name] if name in KNOBS else None) for name in kept
    )
