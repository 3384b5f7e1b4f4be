"""The result of a trade: cost and errors of each setting, which of them pay, and the cheapest within the budget."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from graph.session.meter import PARTS, Cost

from .errors import Errors, Horizon
from .float32 import Float32
from .metrics import COSTS, ERRORS, LEADING, METRICS
from .study import Setting, Study
from .trial import Measured, Timed

OK, UNSTABLE, FAILED, REFUSED = "ok", "unstable", "failed", "refused"
CRASHED, UNFINISHED = "crashed", "unfinished"

OWN_ERROR = 2.0
"""The reference's own error, in differences between it and its refinement.

An error in proportion to the step h is C h, that at half the step C h / 2: so is their difference, and the reference is
off by twice that. At order n it is off by 2^n / (2^n - 1) differences, which is less: twice is a bound.
"""

RESOLVED = 0.95
"""The share of the reference's own error from which on a difference is resolved.

Below 1: an error in proportion to the step makes the next coarser setting (2 h) differ by C h, the own error itself.
"""

NO_DIFFERENCE = 1e-9
"""Errors that differ by less, absolutely or in proportion, are the same: sums in another order differ as much."""


@dataclass(slots=True, eq=False)
class Row:
    """One run: its errors and timed runs. status: one of those above; why: the reason for another than "ok".

    also: other settings that are the same run, for they agree in every knob that it reads. warnings: codes of the
    warnings of its run. frames: of all its sensors, per simulated second. read: the knobs that it reads. float32: see
    `Measured`.
    """

    setting: Setting
    status: str = UNFINISHED
    why: str = ""
    errors: Errors = field(default_factory=dict)
    timed: list[Timed] = field(default_factory=list)
    warnings: tuple[str, ...] = ()
    frames: float | None = None
    also: list[Setting] = field(default_factory=list)
    read: frozenset[str] = frozenset()
    float32: Float32 | None = None

    @property
    def settings(self) -> tuple[Setting, ...]:
        """Its setting and those that are the same run."""
        return self.setting, *self.also

    def take(self, run: Measured, errors: Errors) -> None:
        """Takes the figures of a measured run."""
        self.status, self.why = run.status or OK, run.ended
        self.errors = errors if self.status == OK else {}
        self.warnings, self.frames, self.read, self.float32 = run.warnings, run.frames, run.read, run.float32

    def copy(self, other: Row) -> None:
        """Takes the figures of another row that is the same run."""
        self.status, self.why, self.errors = other.status, other.why, other.errors
        self.warnings, self.frames, self.read, self.float32 = other.warnings, other.frames, other.read, other.float32

    def is_timed(self, repeat: int) -> bool:
        """Whether nothing is left to be timed."""
        return self.status != OK or len(self.timed) >= repeat

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

    def as_cheap(self, other: Row) -> bool:
        """Whether the processor times of both lie within their spreads: their order may be chance."""
        one, two = self.cost, other.cost
        if self is other or one is None or two is None:
            return self is other
        spreads = sum(row.spread.cpu * cost.cpu for row, cost in ((self, one), (other, two)) if row.spread)
        return abs(one.cpu - two.cpu) <= spreads

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
    interrupted. tried: where the reference was chosen by convergence (`conduct`), each setting that ran and by how much
    refining it moves each metric, the chosen one first.
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
    tried: tuple[tuple[Setting, Errors], ...] = ()

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
    def leverage(self) -> dict[str, float]:
        """Groups of knobs (`group_of`) by the share of the processor time that they act on, the largest first.

        Of the reference, or of the first run that was timed. Groups overlap: rays are cast for sensors.
        """
        timed = [row for row in self.rows if row.timed]
        row = next((one for one in timed if self.study.reference in one.settings), timed[0] if timed else None)
        if row is None or row.cost is None or not row.cost.cpu > 0:
            return {}
        parts = row.parts
        times = {
            "physics": parts["physics"].cpu,
            "mesh": parts["builds"].cpu + parts["casts"].cpu,
            "loop_hz": parts["graph"].cpu + parts["io"].cpu,
            **{
                kind: statistics.median(one.sensors.get(kind, 0.0) for one in row.timed)
                for kind in sorted({kind for one in row.timed for kind in one.sensors})
            },
        }
        shares = {name: time / row.cost.cpu for name, time in times.items()}
        return dict(sorted(shares.items(), key=lambda one: -one[1]))

    @property
    def knobs(self) -> tuple[str, ...]:
        """The varied keys, the one with the most leverage first."""
        leverage = self.leverage
        return tuple(sorted(self.study.varied, key=lambda name: -leverage.get(group_of(name), 0.0)))

    @property
    def idle(self) -> dict[str, bool]:
        """The knobs whose values change no error that the reference resolves; True for those that change none at all.

        Settings that differ in nothing else have the same errors.
        """
        found = {name: self._effects(name) for name in self.study.varied}
        return {name: effects == {0} for name, effects in found.items() if effects and 2 not in effects}

    def _effects(self, knob: str) -> set[int]:
        """The effects of a knob where it alone differs: 0 no error changes, 1 no resolved one, 2 some resolved one."""
        alike: dict[tuple[Any, ...], list[Row]] = {}
        for row in self.rows:
            for setting in row.settings:
                others = tuple(value for name, value in setting.items() if name != knob)
                alike.setdefault(others, []).append(row)
        return {self._difference(first, row) for first, *rows in alike.values() for row in rows}

    def _difference(self, one: Row, other: Row) -> int:
        if one is other and one.errors:
            return 0
        if one.status != OK or other.status != OK or not one.errors or one.errors.keys() != other.errors.keys():
            return 2
        if all(_same(one.errors[name], other.errors[name]) for name in one.errors):
            return 0
        return 1 if all(_same(self.error(one, name), self.error(other, name)) for name in one.errors) else 2

    def doubt(self, metric: str) -> float:
        """The reference's own error, `OWN_ERROR` times what refining it changes: smaller errors mean nothing.

        0 for costs, and for metrics of a run alone.
        """
        moved, about = self.moved.get(metric), METRICS[metric]
        if moved is None or about.alone or not self.refined:
            return 0.0
        own = OWN_ERROR * about.error(moved)
        own = min(own, 1.0) if about.more else own
        return own if own > NO_DIFFERENCE else 0.0

    def error(self, row: Row, metric: str) -> float | None:
        """The error or cost of a setting; None if it was not measured.

        An unresolved error counts as `doubt`, so that all of these are equal; a resolved one is larger than that.
        """
        value = row.value(metric)
        if value is None:
            return None
        error, doubt = METRICS[metric].error(value), self.doubt(metric)
        if doubt == 0:
            return error
        return doubt if error < RESOLVED * doubt else max(error, math.nextafter(doubt, math.inf))

    def unresolved(self, row: Row, metric: str) -> bool:
        """Whether the setting's difference from the reference is smaller than the reference's own error."""
        value = row.value(metric)
        return value is not None and METRICS[metric].error(value) < RESOLVED * self.doubt(metric)

    def front(self, metric: str) -> list[Row]:
        """The settings that pay, by rising cost: no other has both less cost and less error (`error`).

        Cost is processor time: other work on the machine changes it least. Of settings that are as cheap as the
        cheapest (`Row.as_cheap`) the one of least error pays, of equal ones the first.
        """
        left = [(row, cost.cpu, error) for row in self._able() if (error := self.error(row, metric)) is not None
                and (cost := row.cost)]  # fmt: skip
        front: list[tuple[Row, float, float]] = []
        while left:
            cheapest = min(left, key=lambda one: one[1])[0]
            best = min((one for one in left if one[0].as_cheap(cheapest)), key=lambda one: one[2])
            front = [*(one for one in front if one[1] < best[1]), best]
            left = [one for one in left if one[2] < best[2]]
        return [row for row, *_ in front]

    def _able(self) -> list[Row]:
        """The settings that ran to their end and were timed."""
        return [row for row in self.rows if row.status == OK and row.timed]

    @property
    def sought(self) -> str:
        """What the answer minimises: processor time, or the first differing error if the budget bounds only costs."""
        errors = self.shown if all(name in COSTS for name in self.study.budget) else ()
        return errors[0] if errors else "cost.cpu"

    @property
    def recommended(self) -> Row | None:
        """The setting that keeps the budget with the least of `sought`; None without a budget, or if none keeps it."""
        able = [row for row in self._able() if self.excess(row) <= 1] if self.study.budget else []
        return (
            self._least(able, lambda row: self.error(row, self.sought)) if self.sought in ERRORS else self._cheap(able)
        )

    @property
    def nearest(self) -> Row | None:
        """The setting that exceeds the budget least, by the worst ratio of a value and its bound; of equal ones the
        cheapest.
        """
        return self._least(self._able(), self.excess)

    def excess(self, row: Row, *, errors_only: bool = False) -> float:
        """The worst ratio of an error and its bound; above 1 the budget is not known to be kept."""
        worst = 0.0
        for name, bound in self.study.budget.items():
            if errors_only and name in COSTS:
                continue
            error, allowed = self.error(row, name), METRICS[name].error(bound)
            if error is None:
                return math.inf
            worst = max(worst, error / allowed if allowed > 0 else (math.inf if error > 0 else 0.0))
        return worst

    def _least(self, rows: Sequence[Row], value: Callable[[Row], float | None]) -> Row | None:
        """The row with the smallest value; among equal ones the cheapest."""
        found = [(one, row) for row in rows if (one := value(row)) is not None]
        least = min((one for one, _ in found), default=0.0)
        return self._cheap([row for one, row in found if one == least])

    def _cheap(self, rows: Sequence[Row]) -> Row | None:
        """The cheapest row; of those as cheap, the one farthest within the bounds of errors; then the first."""
        cheapest = min(rows, key=lambda row: row.cost.cpu if row.cost else math.inf, default=None)
        if cheapest is None:
            return None
        return min((row for row in rows if row.as_cheap(cheapest)), key=lambda row: self.excess(row, errors_only=True))


def group_of(knob: str) -> str:
    """The group of a knob: `lidar` of `lidar.motion`."""
    return knob.partition(".")[0]


def _median(costs: Iterable[Cost]) -> Cost:
    found = [*costs]
    return Cost(statistics.median(one.wall for one in found), statistics.median(one.cpu for one in found))


def _same(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return math.isclose(one, other, rel_tol=NO_DIFFERENCE, abs_tol=NO_DIFFERENCE)


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
