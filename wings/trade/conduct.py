"""Conducts a study: the reference and its check, then every run once for its errors, then the timed rounds.

Runs for errors are repeatable to the byte, so each is made once, several at a time. Timed runs are made one at a time,
in rounds (A B C, A B C), so that what else the machine does meets all settings alike.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from graph.base.errors import Problem, UserError
from graph.sim.fidelity import KNOBS

from .errors import Errors
from .jobs import Clock, Present
from .metrics import COSTS, METRICS
from .outcome import OK, UNFINISHED, Outcome, Row
from .reference import Found, find_reference
from .rows import measure_rows, status_of
from .study import Study, text_of
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
    present = pool.one(Present())
    total = 2 * (1 + len(study.others)) + len(study.settings) * (1 + study.repeat)
    done = 0

    def count(runs: int) -> None:
        nonlocal done
        done += runs
        progress(done, total)

    count(0)
    with tempfile.TemporaryDirectory(prefix="tickgraph-trade-", ignore_cleanup_errors=True) as folder:
        place = Path(folder)
        found = find_reference(study, present, pool, place, count)
        outcome = _begun(found)
        known, chosen = found.rows(pool), found.chosen
        try:
            measure_rows(outcome, known, present, pool, chosen.file, count)
            _time(outcome, pool, min(chosen.run.started, float(study.duration)), place, count)
        except KeyboardInterrupt:
            outcome.complete = all(row.status != UNFINISHED and row.is_timed(study.repeat) for row in outcome.rows)
    outcome.complete &= found.complete
    return outcome


def _begun(found: Found) -> Outcome:
    """The outcome before any row is measured."""
    study, chosen = found.study, found.chosen
    _check_read(study, [run for run in (chosen.run, chosen.finer) if run is not None])
    _check_budget(study, chosen.own, chosen.horizon.time)
    return Outcome(
        study,
        [Row(setting) for setting in study.settings],
        chosen.horizon,
        chosen.moved,
        tuple(chosen.own),
        chosen.run.warnings,
        refined=chosen.finer is not None,
        timed=timed_length(study, chosen.run),
        tried=tuple((one.setting, one.moved) for one in found.tried),
    )


def timed_length(study: Study, reference: Measured) -> Fraction:
    """The simulated length of each timed run [s]: the duration, or less if all runs would take more than `TIMING_S`.

    A shorter length is a whole number of the slowest sensor's periods: it has as many frames wherever it begins.
    """
    runs = len(study.settings) * study.repeat
    room = (TIMING_S / runs - reference.opening) / reference.pace - reference.started if reference.pace else math.inf
    if room >= study.duration:
        return study.duration
    period = reference.period or study.duration * LEAST_SHARE
    least = max(study.duration * LEAST_SHARE, LEAST_FRAMES * reference.period, Fraction(room))
    return min(study.duration, math.ceil(least / period) * period)


def _check_read(study: Study, runs: list[Measured]) -> None:
    """Raises UserError for knobs that neither the reference nor its refinement read."""
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


def _time(outcome: Outcome, pool: Pool, start: float, place: Path, count: Callable[[int], None]) -> None:
    study = outcome.study
    for _ in pool.results([Clock(study.reference, Fraction(0), start, place / "run.mcap")]):
        pass  # not counted: its first frames load what only recorded runs use
    for _ in range(study.repeat):
        able = [row for row in outcome.rows if row.status == OK]
        jobs = [Clock(row.setting, outcome.timed, start, place / "run.mcap") for row in able]
        for number, timed in pool.results(jobs):
            row = able[number]
            if isinstance(timed, Crashed):
                row.status, row.why = status_of(timed), timed.why
            elif timed.ended:  # beyond the measured time, for timing starts later
                row.status, row.why = "unstable", timed.ended
            else:
                row.timed.append(timed)
            count(1)
