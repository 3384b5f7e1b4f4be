"""Ratios measured side by side in one process, so that a busy machine slows both sides alike.

A benchmark is a file `bench_NAME.py` in this folder with `TITLE` and `measure(quick)`, which yields `Row`s.
"""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One line of a table: what was measured, its value, the bound it has to keep (None: shown for information)."""

    what: str
    value: float
    bound: float | None = None
    unit: str = "x"

    @property
    def kept(self) -> bool:
        """Whether the value is within its bound."""
        return self.bound is None or self.value <= self.bound


def ratio(subject: Callable[[], object], baseline: Callable[[], object], rounds: int = 15, warm_up: int = 2) -> float:
    """Median over `rounds` of time(subject) / time(baseline), the two alternating and swapping who goes first."""
    for _ in range(warm_up):
        baseline()
        subject()
    ratios = []
    for index in range(rounds):
        if index % 2:
            over, under = seconds(subject), seconds(baseline)
        else:
            under, over = seconds(baseline), seconds(subject)
        ratios.append(over / under)
    return statistics.median(ratios)


def seconds(call: Callable[[], object]) -> float:
    """Wall time of one call [s]; the garbage collector waits until it is over."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        start = time.perf_counter()
        call()
        return time.perf_counter() - start
    finally:
        if collecting:
            gc.enable()
