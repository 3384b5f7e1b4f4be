"""The result of a trade: cost and errors of each setting, which of them pay, and the cheapest within the budget."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from .errors import Errors, Horizon
from .meter import PARTS, Cost
from .metrics import COSTS, ERRORS, LEADING, METRICS
from .study import Setting, Study
from .trial import Timed

OK, UNSTABLE, FAILED, REFUSED = "ok", "unstable", "failed", "refused"
CRASHED, UNFINISHED = "crashed", "unfinished"


@dataclass(slots=True)
class Row:
    """One setting: its errors and timed runs. status: one of those above; why: the reason for another than "ok".

    warnings: codes of the warnings of its run. frames: of all its sensors, per simulated second.
    """

    setting: Setting
    status: str = UNFINISHED
    why: str = ""
    errors: Errors = field(default_factory=dict)
    timed: list[Timed] = field(default_factory=list)
    warnings: tuple[str, ...] = ()
    frames: float | None = None

    @property
    def cost(self) -> Cost | None:
        """Medians of wall and processor time per simulated second; None before it was timed."""
        wholes = [one.whole for one in self.timed]
        return _median(wholes) if wholes else None

    @property
    def spread(self) -> Cost | None:
        """Half the range of the times, as a share of their median; None before it was timed twice."""
        if len(self.timed) < 2:
            return None
        wholes = [one.whole for one in self.timed]
        return Cost(_spread([one.wall for one in wholes]), _spread([one.cpu for one in wholes]))

    @property
    def parts(self) -> dict[str, Cost]:
        """Medians of each part."""
        return {name: _median([one.parts[name] for one in self.timed]) for name in PARTS} if self.timed else {}

    @property
    def start(self) -> float | None:
        """Median of the wall time until each sensor had given a frame [s]."""
        return statistics.median(one.start for one in self.timed) if self.timed else None

    def value(self, metric: str) -> float | None:
        """The value of a metric; None if it was not measured."""
        if metric in ERRORS:
            return self.errors.get(metric)
        if metric == "cost.frames":
            return self.frames
        cost = self.cost
        if cost is None:
            return None
        if metric in ("cost.wall", "cost.cpu"):
            return cost.wall if metric == "cost.wall" else cost.cpu
        return self.start if metric == "cost.start" else self.parts[metric.removeprefix("cost.")].wall


@dataclass
class Outcome:
    """Everything that was measured. moved: by how much refining the reference moves each metric.

    given: the metrics that the scene gives. timed: simulated time of each timed run [s]. complete: False if it was
    interrupted.
    """

    study: Study
    rows: list[Row]
    horizon: Horizon
    moved: Errors
    given: tuple[str, ...]
    reference_warnings: tuple[str, ...] = ()
    refined: bool = True
    timed: Fraction = Fraction(0)
    complete: bool = True

    @cached_property
    def shown(self) -> tuple[str, ...]:
        """The errors of the budget, then those that differ between settings, the leading ones first."""
        first = [*self.study.budget, *LEADING]
        order = sorted(ERRORS, key=lambda name: first.index(name) if name in first else len(first))
        return tuple(name for name in order if name in self.given and (name in self.study.budget or self._varies(name)))

    def _varies(self, metric: str) -> bool:
        values = {value for row in self.rows if (value := row.errors.get(metric)) is not None}
        return len(values) > 1

    @property
    def idle(self) -> tuple[str, ...]:
        """The knobs whose values change no error: settings that differ in nothing else have the same errors."""
        return tuple(name for name in self.study.varied if self._changes_nothing(name))

    def _changes_nothing(self, knob: str) -> bool:
        alike: dict[tuple[Any, ...], list[Errors]] = {}
        for row in self.rows:
            others = tuple(value for name, value in row.setting.items() if name != knob)
            alike.setdefault(others, []).append(row.errors if row.status == OK else {})
        compared = [errors for errors in alike.values() if len(errors) > 1]
        return bool(compared) and all(first and one == first for first, *others in compared for one in others)

    def doubt(self, metric: str) -> float:
        """By how much the reference differs from its refinement: smaller errors mean nothing.

        0 for costs, and for metrics of a run alone.
        """
        moved, about = self.moved.get(metric), METRICS[metric]
        return 0.0 if moved is None or about.alone or not self.refined else about.error(moved)

    def error(self, row: Row, metric: str) -> float | None:
        """The error or cost of a setting as far as it is known: at least the doubt; None if it was not measured."""
        value = row.value(metric)
        return None if value is None else max(METRICS[metric].error(value), self.doubt(metric))

    def unresolved(self, row: Row, metric: str) -> bool:
        """Whether the setting differs from the reference by less than the reference is known to."""
        value = row.value(metric)
        return value is not None and METRICS[metric].error(value) < self.doubt(metric)

    def front(self, metric: str) -> list[Row]:
        """The settings that pay, by rising cost: none other has both less cost and less error, as far as it is known.

        Cost is processor time: other work on the machine changes it least.
        """
        able = [(row, row.cost, self.error(row, metric)) for row in self.rows if row.status == OK]
        front: list[Row] = []
        best = math.inf
        priced = [(cost.cpu, error, row) for row, cost, error in able if cost and error is not None]
        for _, error, row in sorted(priced, key=lambda one: one[:2]):
            if error < best:
                best = error
                front.append(row)
        return front

    @property
    def sought(self) -> str:
        """What the answer has least of: processor time; if only costs are bounded, the first error that differs."""
        errors = self.shown if all(name in COSTS for name in self.study.budget) else ()
        return errors[0] if errors else "cost.cpu"

    @property
    def recommended(self) -> Row | None:
        """The setting that keeps the budget with the least of `sought`; None without a budget, or if none keeps it."""
        able = [row for row in self._ranked(self.sought) if self.excess(row) <= 1] if self.study.budget else []
        return able[0] if able else None

    @property
    def nearest(self) -> Row | None:
        """The setting that exceeds the budget least, by the worst ratio of a value and its bound; of equal ones the
        cheapest.
        """
        return min(self._ranked("cost.cpu"), key=self.excess, default=None)

    def excess(self, row: Row) -> float:
        """The worst ratio of an error and its bound; above 1 the budget is not known to be kept."""
        worst = 0.0
        for name, bound in self.study.budget.items():
            error, allowed = self.error(row, name), METRICS[name].error(bound)
            if error is None:
                return math.inf
            worst = max(worst, error / allowed if allowed > 0 else (math.inf if error > 0 else 0.0))
        return worst

    def _ranked(self, metric: str) -> list[Row]:
        """The settings that ran to their end, those with less of the metric first, of equal ones the cheaper."""
        able = [(self.error(row, metric), row.cost, row) for row in self.rows if row.status == OK]
        order = [(error, cost.cpu, row) for error, cost, row in able if error is not None and cost]
        return [row for *_, row in sorted(order, key=lambda one: one[:2])]


def _median(costs: Iterable[Cost]) -> Cost:
    found = [*costs]
    return Cost(statistics.median(one.wall for one in found), statistics.median(one.cpu for one in found))


def _spread(times: Sequence[float]) -> float:
    return (max(times) - min(times)) / 2 / statistics.median(times)


def unit_of(metric: str) -> str:
    """The metric's unit as a suffix: " m", or "" for shares."""
    unit = {**ERRORS, **COSTS}[metric].unit
    return f" {unit}" if unit else ""


def columns_of(outcome: Outcome) -> tuple[str, ...]:
    """Every error that the scene gives, in the order of the table of metrics."""
    return tuple(name for name in ERRORS if name in outcome.given)


def bounds_of(budget: Mapping[str, float]) -> str:
    """A budget in words: `lidar.range_p99 <= 0.02 m`."""
    return ", ".join(
        f"{name} {'>=' if METRICS[name].more else '<='} {bound:g}{unit_of(name)}" for name, bound in budget.items()
    )
