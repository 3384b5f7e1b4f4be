"""`graph test`: runs the cases of *.test.yaml files and prints expected and actual results."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graph.base.errors import Mark, Problem, UserError

from .arguments import add_allow, add_nodes
from .printing import say

if TYPE_CHECKING:
    from graph.testing.cases import CaseFile
    from graph.testing.running import Options, Outcome


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.epilog = f"What a test file may say: python -m pydoc graph.testing.case_forms. {parser.epilog or ''}"
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        type=Path,
        help="test file (*.test.yaml), .ogn file with tests, or a folder of the former",
    )
    parser.add_argument(
        "-k", metavar="TEXT", dest="text", help="only cases whose file or name holds TEXT (upper or lower case)"
    )
    parser.add_argument("--junit", metavar="PATH", type=Path, help="write the results as JUnit XML to PATH")
    add_nodes(parser)
    add_allow(parser)
    parser.add_argument(
        "--allow-scripts", action="store_true", help="run Python code that graph files bring (ScriptNode)"
    )
    parser.add_argument("-q", "--quiet", action="store_true", help="print only failures and the closing line")


def run(args: argparse.Namespace) -> int:
    """Runs the command; returns 1 if any case failed. Raises UserError, before any case runs, for wrong test files."""
    from graph.testing.cases import read_cases
    from graph.testing.checking import check_cases
    from graph.testing.running import Options

    # A case reports the warnings that it did not expect.
    logging.getLogger("tickgraph").propagate = False
    logging.getLogger("tickgraph").addHandler(logging.NullHandler())
    files = [read_cases(path, args.allow) for path in test_files(args.files)]
    problems: list[Problem] = []
    for file in files:
        found = (*file.problems, *check_cases(file.cases, args.allow))
        problems += sorted(found, key=lambda one: one.mark or Mark("", 0, 0))
    if problems:
        raise UserError(problems)
    if args.junit is not None and args.junit.is_dir():
        raise UserError(f"--junit {args.junit} is a folder; name a file in it")
    options = Options(tuple(args.allow), args.settings, args.allow_scripts)
    outcomes = {file.name: list(_outcomes(file, args, options)) for file in files}
    every = [outcome for group in outcomes.values() for outcome in group]
    if not every:
        raise UserError(f"-k {args.text}: no case has that in its name; leave out -k to run all")
    if args.junit is not None:
        _write_junit(args.junit, outcomes)
    failed = sum(not outcome.passed for outcome in every)
    say(f"{len(every) - failed} passed, {failed} failed")
    return 1 if failed else 0


def test_files(paths: Sequence[Path]) -> list[Path]:
    """The test files that the given files and folders contain, subfolders included, each once, in order.

    Raises UserError with every path that is not a test file or a folder.
    """
    from graph.testing.names import is_test_file

    found: list[Path] = []
    problems: list[Problem] = []
    for path in paths:
        if path.is_dir():
            below = sorted(one for one in path.rglob("*.test.*") if is_test_file(one) and one.is_file())
            found += below
            if not below:
                problems.append(Problem(f"{path}: there is no test file (*.test.yaml) in this folder"))
        elif not path.exists():
            problems.append(Problem(f"{path}: no such file or folder"))
        elif not is_test_file(path) and path.suffix.lower() != ".ogn":
            problems.append(Problem(f"{path} is not a test file; {_advice(path)}"))
        else:
            found.append(path)
    if problems:
        raise UserError(problems)
    return list(dict.fromkeys(found))


def _advice(path: Path) -> str:
    beside = path.with_name(f"{path.stem}.test.yaml")
    return f"did you mean {beside}?" if beside.is_file() else "its name ends in .test.yaml"


def _outcomes(file: CaseFile, args: argparse.Namespace, options: Options) -> Iterator[Outcome]:
    from graph.testing.running import run_case

    for case in file.cases:
        if args.text and args.text.lower() not in f"{file.name}: {case.name}".lower():
            continue
        outcome = run_case(case, options)
        if not outcome.passed or not args.quiet:
            word = "ok    " if outcome.passed else "FAILED"
            say(f"{word} {file.name}: {case.name} ({outcome.seconds:.2f} s)")
        for failure in outcome.failures:
            say(f"       {failure}")
        sys.stdout.flush()
        yield outcome


def _write_junit(path: Path, outcomes: dict[str, list[Outcome]]) -> None:
    from graph.testing.junit import write_junit

    try:
        write_junit(path, outcomes)
    except OSError as error:
        raise UserError(f"--junit {path}: {error.strerror}; name a file that can be written") from None
