"""`graph doctor --stability`: runs the cases at the extremes on this machine, and says which meet their bounds."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from graph.base.errors import UserError

from .printing import counted, say, say_json

if TYPE_CHECKING:
    from graph.stability.case import Case, Outcome


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the options of the cases."""
    parser.add_argument("--stability", action="store_true", help="run the cases at the extremes, each with its bound")
    parser.add_argument("--only", metavar="TEXT", help="with --stability: the cases whose line contains it")
    parser.add_argument(
        "--slow", action="store_true", help="with --stability: also those that need minutes or gigabytes"
    )
    parser.add_argument("--markdown", action="store_true", help="with --stability: print the table as Markdown")


def run(args: argparse.Namespace) -> int:
    """Runs the cases and prints each; returns 0 if all meet their bounds, else 1."""
    from graph.stability.table import markdown, outcomes, row

    chosen = _chosen(args)
    found = outcomes(chosen)
    if args.markdown or args.json:
        whole = list(found)
        if args.json:
            keys = ("area", "case", "bound", "measured", "why")
            say_json({"cases": [{**dict(zip(keys, row(one), strict=True)), "ok": one.ok} for one in whole]})
        else:
            for line in markdown(whole).splitlines():
                say(line)
    else:
        whole = list(_shown(found, max(len(case.name) for case in chosen)))
    failed = sum(not one.ok for one in whole)
    if not (args.markdown or args.json):
        say(f"{failed} of {counted(len(whole), 'cases')} FAIL" if failed else f"{counted(len(whole), 'cases')}, all ok")
    return 1 if failed else 0


def _chosen(args: argparse.Namespace) -> list[Case]:
    """The cases that the options name. Raises UserError if no case matches."""
    from graph.stability.table import CASES

    chosen = [case for case in CASES if args.slow or not case.slow]
    if args.only:
        chosen = [case for case in chosen if args.only in f"{case.area} {case.name} {case.why}"]
    if not chosen:
        raise UserError(f"--only {args.only}: no case has this in its line; graph doctor --stability lists them all")
    return chosen


def _shown(found: Iterator[Outcome], width: int) -> Iterator[Outcome]:
    """Prints each outcome as it comes."""
    for one in found:
        state = "ok" if one.ok else "FAIL"
        say(f"{state:4}  {one.case.area:10}  {one.case.name:{width}}  {one.measured}  (bound {one.case.limit})")
        yield one
