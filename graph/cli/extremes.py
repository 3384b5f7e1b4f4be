"""`graph doctor --stability`: runs cases at the extremes on this machine, and says which meet their bounds."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from graph.base.errors import UserError

from .printing import counted, say, say_json

if TYPE_CHECKING:
    from .extreme_cases import Case


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the options of the cases."""
    parser.add_argument("--stability", action="store_true", help="run cases at the extremes, each with its bound")
    parser.add_argument("--only", metavar="TEXT", help="with --stability: the cases whose line contains it")


def run(args: argparse.Namespace) -> int:
    """Runs the cases and prints each; returns 0 if all meet their bounds, else 1.

    Raises UserError if no case is chosen.
    """
    from .extreme_cases import CASES, outcomes, row

    chosen = [case for case in CASES if not args.only or args.only in case.line]
    if not chosen:
        raise UserError(
            f"--only {args.only}: no case has this in its line; graph doctor --stability lists all that are installed; "
            "more are in tests/stability of a checkout"
        )
    if not args.json:
        return show(chosen)
    found = list(outcomes(chosen))
    keys = ("area", "case", "bound", "measured", "why")
    say_json({"cases": [{**dict(zip(keys, row(one), strict=True)), "ok": one.ok} for one in found]})
    return 0 if all(one.ok for one in found) else 1


def show(cases: Sequence[Case]) -> int:
    """Runs the cases and prints each outcome as it comes; returns 0 if all are ok, else 1."""
    from .extreme_cases import outcomes

    failed, width = 0, max(len(case.name) for case in cases)
    for one in outcomes(cases):
        state = "ok" if one.ok else "FAIL"
        failed += not one.ok
        say(f"{state:4}  {one.case.area:10}  {one.case.name:{width}}  {one.measured}  (bound {one.case.limit})")
    say(f"{failed} of {counted(len(cases), 'cases')} FAIL" if failed else f"{counted(len(cases), 'cases')}, all ok")
    return 1 if failed else 0
