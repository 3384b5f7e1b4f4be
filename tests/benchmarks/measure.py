"""Ratios measured side by side in one process, so that a busy machine slows both sides alike.

A benchmark is a file `bench_NAME.py` in this folder with `TITLE` and `measure(quick)`, which yields `Row`s.
"""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass


class Median(float):
    """The median of some samples, with the quartiles `low` and `high` around it."""

    low: float
    high: float

    def __new__(cls, samples: Sequence[float]) -> Median:
        """Of at least one sample."""
        self = super().__new__(cls, statistics.median(samples))
        several = samples if len(samples) > 1 else [*samples, *samples]
        self.low, _, self.high = statistics.quantiles(several, method="inclusive")
        return self


@dataclass(frozen=True)
class Row:
    """One line of a table: what was measured, its value, the bound it has to keep (None: shown for information).

    best: the good side of the bound; "most" for what has to be at least the bound, as the lead over a peer.
    """

    what: str
    value: float
    bound: float | None = None
    unit: str = "x"
    best: str = "least"

    @property
    def kept(self) -> bool:
        """Whether the value is within its bound."""
        if self.bound is None:
            return True
        return self.value >= self.bound if self.best == "most" else self.value <= self.bound

    @property
    def spread(self) -> tuple[float, float] | None:
        """The quartiles of the samples, where the value is a `Median`."""
        return (self.value.low, self.value.high) if isinstance(self.value, Median) else None


def ratio(
    subject: Callable[[], object],
    baseline: Callable[[], object],
    rounds: int = 15,
    warm_up: int = 2,
    clock: Callable[[], float] = time.perf_counter,
) -> Median:
    """Median over `rounds` of time(subject) / time(baseline), the two alternating and swapping who goes first.

    clock: `time.process_time` for processor time, which other processes on the machine hardly change.
    """
    for _ in range(min(warm_up, rounds)):
        baseline()
        subject()
    ratios = []
    for index in range(rounds):
        if index % 2:
            over, under = seconds(subject, clock), seconds(baseline, clock)
        else:
            under, over = seconds(baseline, clock), seconds(subject, clock)
        ratios.append(over / under)
    return Median(ratios)


def added(
    subject: Callable[[], object], plain: Callable[[], object], unit: Callable[[], object], rounds: int = 15
) -> float:
    """How much longer a call takes than a plain one, in times of a third; of the medians of the three in turn."""
    times = [[seconds(call) for call in (subject, plain, unit)] for _ in range(rounds + 1)][1:]
    longer, shorter, one = (statistics.median(each) for each in zip(*times, strict=True))
    return (longer - shorter) / one


def seconds(call: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Time of one call [s], wall time by default; the garbage collector waits until it is over."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        start = clock()
        call()
        return clock() - start
    finally:
        if collecting:
            gc.enable()
