"""`python -m tests.support.isaac_cases FOLDER...`: how far Isaac Sim's own test cases agree with this project.

A folder is that of an extension, as the product has it: `.../exts/isaacsim.core.nodes`. Each module of tests runs in a
process of its own by `graph exec`, over the modules of this project; only modules of tests, and `--helpers`, come from
the folder and those beside it. A test case is a program with your rights.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SCRIPT = Path(__file__).with_name("script.py")
WORDS = {"agrees": "agrees", "deviates": "deviates", "absent": "out of reach", "skips": "skips itself"}


@dataclass
class Outcomes:
    """What became of each case of a module: by its name a word of `WORDS`, the message and the traceback."""

    module: str
    cases: dict[str, tuple[str, str, str]] = field(default_factory=dict)

    def count(self) -> Counter[str]:
        """The number of cases by word."""
        return Counter(word for word, _, _ in self.cases.values())


def main(arguments: list[str] | None = None) -> int:
    """Runs the cases and prints the table."""
    parser = argparse.ArgumentParser(prog="python -m tests.support.isaac_cases", description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help="folder of an extension")
    parser.add_argument("--only", default="", metavar="TEXT", help="modules and cases whose names contain it")
    parser.add_argument("--limit", type=float, default=40.0, metavar="S", help="time of a case [s] (default: 40)")
    parser.add_argument("--module-limit", type=float, default=900.0, metavar="S", help="time of a module [s]")
    parser.add_argument("--helpers", default="", metavar="NAMES", help="modules that come from the folders, too")
    parser.add_argument("--no-cuda", action="store_true", help='leave "cuda" out of the lists of devices in tests')
    parser.add_argument("--parity", default="documented", help="the profile, as in graph exec")
    parser.add_argument("--exec", default="", metavar="OPTIONS", help="options of graph exec: --exec=--rclpy")
    parser.add_argument("--trace", action="store_true", help="print tracebacks")
    options = parser.parse_args(arguments)
    folders = [folder.resolve() for folder in options.folders]
    modules = [module for folder in folders for module in modules_of(folder)]
    chosen = [one for one in modules if options.only in one] or modules
    if not chosen:
        parser.error("no folder has a module of tests: .../tests/test_*.py")
    only = "" if len(chosen) < len(modules) else options.only
    done = []
    for module in chosen:
        done.append(run(module, folders, options, only))
        print(module, dict(done[-1].count()), file=sys.stderr, flush=True)
    report([one for one in done if one.cases], trace=options.trace)
    return 0


def modules_of(folder: Path) -> Iterator[str]:
    """The names of the modules of tests of an extension."""
    for file in sorted(folder.rglob("test_*.py")):
        inside = file.relative_to(folder).with_suffix("").parts
        if "tests" in inside:
            yield ".".join(inside)


def run(module: str, folders: list[Path], options: argparse.Namespace, only: str) -> Outcomes:
    """Runs one module of tests in a process of its own, or in several."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "cases.json"
        command = [sys.executable, "-m", "graph", "exec", "--parity", options.parity, *options.exec.split()]
        for folder in folders:
            command += ["--allow", str(folder)]
        command += [str(SCRIPT), module, str(out)]
        beside = sorted({one for folder in folders for one in folder.parent.iterdir()} - {*folders})
        command += [
            str(options.limit),
            only,
            str(int(options.no_cuda)),
            options.helpers,
            *map(str, (*folders, *beside)),
        ]
        paths = os.pathsep.join(filter(None, (os.getcwd(), os.environ.get("PYTHONPATH"))))
        environment, why, cases = {**os.environ, "PYTHONPATH": paths}, "", dict[str, tuple[str, str, str]]()
        while True:  # a case that is cut off ends its process, and another one goes on with the next case
            try:
                ended = subprocess.run(
                    command,
                    cwd=place,
                    env=environment,
                    capture_output=True,
                    text=True,
                    timeout=options.module_limit,
                    check=False,
                )
                why = (ended.stderr.strip().splitlines() or ["no output"])[-1]
            except subprocess.TimeoutExpired:
                why = f"longer than {options.module_limit:g} s"
            before = len(cases)
            found: dict[str, Any] = json.loads(out.read_text()) if out.exists() else {"cases": {}, "done": False}
            cases = {name: tuple(one) for name, one in found["cases"].items()}
            if found["done"]:
                return Outcomes(module, cases)
            if len(cases) == before:
                return Outcomes(module, {**cases, "(the module)": ("deviates", why, "")})


def report(done: list[Outcomes], *, trace: bool) -> None:
    """Prints the table, what is missing, and what deviates."""
    width = max((len(one.module) for one in done), default=0)
    print(f"{'module':{width}}  {'cases':>6}" + "".join(f"  {word:>12}" for word in WORDS.values()))
    total: Counter[str] = Counter()
    for one in done:
        total += one.count()
    for name, each in [*((one.module, one.count()) for one in done), ("all", total)]:
        print(f"{name:{width}}  {each.total():>6}" + "".join(f"  {each[word]:>12}" for word in WORDS))
    absent = Counter(why for one in done for word, why, _ in one.cases.values() if word == "absent")
    for why, times in absent.most_common():
        print(f"out of reach: {times} x {why.splitlines()[0]}")
    for one in done:
        for name, (word, why, text) in one.cases.items():
            if word == "deviates":
                print(f"deviates: {one.module}.{name}: {(why.splitlines() or [''])[0]}")
            if trace and text:
                print(text)


if __name__ == "__main__":
    sys.exit(main())
