"""The table of all cases, and its rows."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from . import attributes, bodies, clocks, divergence, inputs, rays, sensing
from .case import Case, Outcome

CASES: tuple[Case, ...] = (
    *bodies.CASES,
    *divergence.CASES,
    *rays.CASES,
    *sensing.CASES,
    *clocks.CASES,
    *inputs.CASES,
    *attributes.CASES,
)

HEADINGS = ("of", "case", "bound", "measured", "because")


def outcomes(cases: Iterable[Case]) -> Iterator[Outcome]:
    """Runs cases, one after the other; what they warn of is not shown."""
    with _silence():
        for case in cases:
            yield case.run()


def row(outcome: Outcome) -> tuple[str, str, str, str, str]:
    """The cells of an outcome, as `HEADINGS` names them."""
    case = outcome.case
    return case.area, case.name, case.limit, outcome.measured, case.why


def markdown(found: Iterable[Outcome]) -> str:
    """The table as Markdown."""
    lines = [HEADINGS, ("---",) * len(HEADINGS), *map(row, found)]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines).replace("| --- ", "|---").replace("--- |", "---|")


@contextmanager
def _silence() -> Iterator[None]:
    log = logging.getLogger("tickgraph")
    before = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(before)
