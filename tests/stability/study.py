"""The study: the error of every oracle with every integrator at ten rates, and the order that it follows.

    python -m tests.stability.study [--quick] [--only NAME] [--fidelity K=V] [--out DIR]

Prints a table; with --out also writes `study.json`, all errors by case, integrator and rate. --quick: five rates, and
not the pile of 216 balls.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.errors import RunError

from . import chains, contacts, free_bodies, joints
from .case import INTEGRATORS, Case, Knobs

CASES = (*free_bodies.CASES, *joints.CASES, *chains.CASES, *contacts.CASES)
SHOWN = (60, 240, 960)
"""The rates of the table [Hz]."""

QUICK = (30, 60, 120, 240, 960)


@dataclass(frozen=True)
class Result:
    """The errors of a case with an integrator by rate; inf where it diverges."""

    case: Case
    integrator: str
    errors: Mapping[int, float]

    @property
    def order(self) -> float:
        """The power of the step that the errors follow: the slope in a log-log plot; NaN below three errors.

        Errors below the case's floor are those of float32 inputs or of rounding.
        """
        known = [(1 / hz, error) for hz, error in self.errors.items() if self.case.floor < error < math.inf]
        if len(known) < 3:
            return math.nan
        steps, errors = np.log(np.array(known).T)
        return float(np.polyfit(steps, errors, 1)[0])


def measured(case: Case, integrator: str, rates: Sequence[int], knobs: Knobs) -> Result:
    """The errors of a case; knobs: besides the integrator, without `physics.`."""
    errors = {}
    for hz in rates:
        try:
            errors[hz] = case.error(hz, {**knobs, "integrator": integrator})
        except RunError:
            errors[hz] = math.inf
    return Result(case, integrator, errors)


def lines(results: Sequence[Result]) -> Iterator[str]:
    """The rows of a table of Markdown."""
    yield "| oracle | integrator | " + " | ".join(f"{hz} Hz" for hz in SHOWN) + " | order | theory |"
    yield "|---|---|---|---|---|---|---|"
    for result in results:
        unit = f" [{result.case.unit}]" if result.case.unit else ""
        shown = " | ".join(_word(result.errors.get(hz)) for hz in SHOWN)
        order, theory = result.order, result.case.orders.get(result.integrator, "")
        text = "" if math.isnan(order) else f"{order:.2f}"
        yield f"| {result.case.name}{unit} | {result.integrator} | {shown} | {text} | {theory} |"


def _word(error: float | None) -> str:
    if error is None:
        return ""
    return "unstable" if math.isinf(error) else f"{error:.2g}"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m tests.stability.study", description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="five rates, and not the pile of 216 balls")
    parser.add_argument("--only", metavar="NAME", help="the oracles whose names contain it")
    parser.add_argument("--fidelity", action="append", default=[], metavar="K=V", help="a knob of physics")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write study.json")
    args = parser.parse_args(arguments)
    knobs = dict(pair.removeprefix("physics.").split("=", 1) for pair in args.fidelity)
    results = []
    for case in CASES:
        if (args.quick and case.name == "666") or (args.only and args.only not in case.name):
            continue
        rates = [hz for hz in case.rates if not args.quick or hz in QUICK]
        for integrator in INTEGRATORS:
            results.append(measured(case, integrator, rates, knobs))
            print(f"\r{case.name}, {integrator}".ljust(60), end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    print("\n".join(lines(results)))
    if args.out:
        args.out.mkdir(parents=True, exist_ok=True)
        data: list[dict[str, Any]] = [
            {"oracle": one.case.name, "integrator": one.integrator, "unit": one.case.unit, "errors": dict(one.errors)}
            for one in results
        ]
        (args.out / "study.json").write_text(json.dumps(data, indent=1), encoding="utf8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
