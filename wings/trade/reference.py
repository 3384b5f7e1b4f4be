"""The reference of a study, which is taken as exact: chosen by convergence where no table decides, checked by refining.

Candidates differ in choices such as `physics.integrator`, of which each is the best in scenes of its own. All of them
approach the same motion as they are refined, so that the one that refining changes least is the nearest to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from graph.base.errors import RunError, UserError
from graph.sim.fidelity import Fidelity

from .errors import Errors, Horizon
from .jobs import Judge, Keep, Match
from .metrics import METRICS, ranking
from .outcome import NO_DIFFERENCE, Row
from .study import Setting, Study, refined, text_of
from .trial import Measured
from .workers import Crashed, Pool


@dataclass(frozen=True, slots=True)
class Judged:
    """A candidate that ran, and its check. finer: its refinement; None without one that ran.

    moved: by how much refining changes each metric. own: its errors against itself, which tell the metrics it gives.
    """

    setting: Setting
    file: Path
    run: Measured
    finer: Measured | None
    horizon: Horizon
    moved: Errors
    own: Errors


@dataclass(frozen=True, slots=True)
class Found:
    """The chosen reference. study: with it and its refinement. tried: all candidates that ran, the chosen one first.

    complete: False if it was interrupted before all of them ran.
    """

    study: Study
    chosen: Judged
    tried: tuple[Judged, ...]
    complete: bool

    def rows(self, pool: Pool) -> list[Row]:
        """The runs made so far, each with its errors."""
        found = [_row(self.chosen.setting, self.chosen.run, self.chosen.own)]
        if self.chosen.finer is not None and self.study.refined is not None:
            found.append(_row(self.study.refined, self.chosen.finer, self.chosen.moved))
        for one in self.tried[1:]:
            errors = pool.one(Match(one.file, self.chosen.file, self.chosen.horizon))
            found.append(_row(one.setting, one.run, errors))
        return found


def find_reference(study: Study, present: Fidelity, pool: Pool, place: Path, count: Callable[[int], None]) -> Found:
    """Runs the candidates, which keep their runs in the folder `place`, and their refinements.

    If the pool is interrupted after a candidate has run, that is the reference. Raises UserError if it is refused,
    RunError if it fails.
    """
    candidates = (study.reference, *study.others)
    finer = [refined(setting, present) for setting in candidates]
    plan = [(place / f"reference{number}", setting) for number, setting in enumerate(candidates)]
    plan += [(place / f"refined{number}", setting) for number, setting in enumerate(finer) if setting is not None]
    found: dict[Path, Measured | Crashed] = {}
    complete = True
    count(2 * len(candidates) - len(plan))
    try:
        jobs = [Keep(setting, study.duration, file) for file, setting in plan]
        for number, result in pool.results(jobs, at_once=True):
            found[plan[number][0]] = result
            count(1)
    except KeyboardInterrupt:
        complete = False
    judged = []
    for number, setting in enumerate(candidates):
        file, beside = place / f"reference{number}", place / f"refined{number}"
        run, check = found.get(file), found.get(beside)
        if isinstance(run, Measured) and not run.status:
            checked = check if isinstance(check, Measured) else None
            horizon, moved, own = pool.one(Judge(file, None if checked is None else beside))
            judged.append(Judged(setting, file, run, checked, horizon, moved, own))
    if not judged:
        _fail(study.reference, found.get(place / "reference0"))
    order = ranking(study.budget)
    tried = sorted(judged, key=lambda one: _convergence(one, order))
    chosen = tried[0]
    checked_by = finer[next(number for number, one in enumerate(candidates) if one is chosen.setting)]
    return Found(study.referring_to(chosen.setting, checked_by), chosen, tuple(tried), complete)


def _convergence(one: Judged, order: list[str]) -> tuple[float, ...]:
    """Sort key; the candidate that converges best comes first: checked, then agreeing longest, then changed least."""
    moves = (METRICS[name].error(value) for name in order if (value := one.moved.get(name)) is not None)
    return (one.finer is None, *(round(value / NO_DIFFERENCE) * NO_DIFFERENCE for value in (-one.horizon.time, *moves)))


def _fail(setting: Setting, found: Measured | Crashed | None) -> None:
    if found is None:
        raise KeyboardInterrupt
    if isinstance(found, Crashed) and found.problems:
        raise UserError(found.problems)
    why = found.why if isinstance(found, Crashed) else found.ended
    raise RunError(f"the reference ({text_of(setting)}) fails: {why}; choose another with --reference")


def _row(setting: Setting, run: Measured, errors: Errors) -> Row:
    row = Row(setting)
    row.take(run, errors)
    return row
