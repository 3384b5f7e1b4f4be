"""Conducts a study: the reference and its check, then every setting once for its errors, then the timed rounds.

Runs for errors are repeatable to the byte, so each is made once, several at a time. Timed runs are made one at a time,
in rounds (A B C, A B C), so that what else the machine does meets all settings alike.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from graph.base.errors import Problem, RunError, UserError
from graph.sim.fidelity import KNOBS

from .errors import Errors
from .jobs import Clock, Compare, Judge, Keep, Present
from .metrics import COSTS, METRICS
from .outcome import CRASHED, OK, REFUSED, Outcome, Row
from .study import Study, refined, text_of
from .trial import Measured
from .workers import Crashed, Pool

TIMING_S = 90.0
"""Processor time [s] of all timed runs together beyond which each is shorter than the duration."""

LEAST_SHARE, LEAST_FRAMES = Fraction(1, 5), 2
"""The shortest timed run: this share of the duration, and so many frames of the slowest sensor."""

Progress = Callable[[int, int], None]


def conduct(study: Study, pool: Pool, progress: Progress) -> Outcome:
    """Measures everything. progress(done, total) counts runs.

    If the pool is interrupted, what was measured by then is the outcome. Raises UserError for a refused file or
    reference, for knobs that nothing reads and for a budget of metrics that the scene does not give, RunError if the
    reference fails, KeyboardInterrupt if it was interrupted before there was anything to compare with.
    """
    study = replace(study, refined=refined(study.reference, pool.one(Present())))
    total = 1 + (study.refined is not None) + len(study.settings) * (1 + study.repeat)
    done = 0

    def count(runs: int = 1) -> None:
        nonlocal done
        done += runs
        progress(done, total)

    count(0)
    with tempfile.TemporaryDirectory(prefix="tickgraph-trade-", ignore_cleanup_errors=True) as folder:
        place = Path(folder)
        outcome, reference, start = _with_reference(study, pool, place, count)
        try:
            _measure(outcome, pool, reference, count)
            _time(outcome, pool, start, place, count)
        except KeyboardInterrupt:
            outcome.complete = False
    return outcome


def _with_reference(study: Study, pool: Pool, place: Path, count: Callable[[], None]) -> tuple[Outcome, Path, float]:
    """The outcome with its horizon; the file of the reference; when timing starts [s]."""
    files = place / "reference", place / "refined"
    settings = [study.reference, *([] if study.refined is None else [study.refined])]
    jobs = [Keep(setting, study.duration, file) for setting, file in zip(settings, files, strict=False)]
    found: list[Measured | Crashed] = [Crashed("")] * len(jobs)
    for number, result in pool.results(jobs, at_once=True):
        found[number] = result
        count()
    first = found[0]
    if isinstance(first, Crashed) and first.problems:
        raise UserError(first.problems)
    if isinstance(first, Crashed) or first.status:
        why = first.why if isinstance(first, Crashed) else first.ended
        raise RunError(f"the reference ({text_of(study.reference)}) fails: {why}; choose another with --reference")
    _check_read(study, [one for one in found if isinstance(one, Measured)])
    kept = files[1] if len(found) > 1 and isinstance(found[1], Measured) else None
    horizon, moved, own = pool.one(Judge(files[0], kept))
    _check_budget(study, own, horizon.time)
    rows = [Row(setting) for setting in study.settings]
    outcome = Outcome(study, rows, horizon, moved, tuple(own), first.warnings, refined=kept is not None)
    outcome.timed = timed_length(study, first)
    for row in rows:
        if row.setting == study.reference:
            row.status, row.errors, row.warnings, row.frames = OK, own, first.warnings, first.frames
            count()
    return outcome, files[0], min(first.started, float(study.duration))


def timed_length(study: Study, reference: Measured) -> Fraction:
    """How long each timed run is [s]: the duration; of it less, if all of them would take more than `TIMING_S`.

    Then it is whole periods of the slowest sensor, for as many frames wherever it begins.
    """
    runs = len(study.settings) * study.repeat
    room = (TIMING_S / runs - reference.opening) / reference.pace - reference.started if reference.pace else math.inf
    if room >= study.duration:
        return study.duration
    period = reference.period or study.duration * LEAST_SHARE
    least = max(study.duration * LEAST_SHARE, LEAST_FRAMES * reference.period, Fraction(room))
    return min(study.duration, math.ceil(least / period) * period)


def _check_read(study: Study, runs: list[Measured]) -> None:
    """Raises UserError for knobs that nothing asked for, neither in the reference nor in its refinement."""
    read = frozenset().union(*(run.read for run in runs))
    problems = [
        Problem(f"{option} {name}: nothing in this file reads this knob at {text_of(study.reference)}; leave it out")
        for option, name in [
            *(("--vary", name) for name in study.varied),
            *(("--reference", name) for name in study.reference if name not in study.varied),
        ]
        if name in KNOBS and name not in read
    ]
    if problems:
        raise UserError(problems)


def _check_budget(study: Study, given: Errors, horizon: float) -> None:
    """Raises UserError for metrics that the reference does not give."""
    problems = [
        Problem(f"--budget {name}: this scene does not give it in {horizon:g} s; it needs {METRICS[name].needs}")
        for name in study.budget
        if name not in given and name not in COSTS
    ]
    if problems:
        raise UserError(problems)


def _measure(outcome: Outcome, pool: Pool, reference: Path, count: Callable[[], None]) -> None:
    study = outcome.study
    rows = [row for row in outcome.rows if row.status != OK]
    jobs = [Compare(row.setting, study.duration, reference, outcome.horizon) for row in rows]
    for number, found in pool.results(jobs, at_once=True):
        row = rows[number]
        if isinstance(found, Crashed):
            row.status, row.why = _status(found), found.why
        else:
            measured, errors = found
            row.status, row.why = measured.status or OK, measured.ended
            row.warnings, row.frames = measured.warnings, measured.frames
            row.errors = errors if row.status == OK else {}
        count()


def _status(found: Crashed) -> str:
    return REFUSED if found.problems else CRASHED


def _time(outcome: Outcome, pool: Pool, start: float, place: Path, count: Callable[[], None]) -> None:
    study = outcome.study
    for _ in pool.results([Clock(study.reference, Fraction(0), start, place / "run.mcap")]):
        pass  # not counted: its first frames load what only recorded runs use
    for _ in range(study.repeat):
        able = [row for row in outcome.rows if row.status == OK]
        jobs = [Clock(row.setting, outcome.timed, start, place / "run.mcap") for row in able]
        for number, timed in pool.results(jobs):
            row = able[number]
            if isinstance(timed, Crashed):
                row.status, row.why = _status(timed), timed.why
            elif timed.ended:  # beyond the measured time, for timing starts later
                row.status, row.why = "unstable", timed.ended
            else:
                row.timed.append(timed)
            count()
