"""Runs the benchmarks and prints their tables: `python tests/benchmarks/run.py [--quick | --keep] [NAME...]`.

Each run is stored with the machine's description in build/benchmarks, and its values stand beside those stored before.
`--keep` also puts its groups into measured.json and writes the manual and README again. Exits 1 if a value misses its
bound; with `--quick`, which measures too little to judge, only a failure counts.
"""

from __future__ import annotations

import argparse
import importlib
import json
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import record
from measure import Row

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def main() -> int:
    """Run what the command line names, else everything."""
    sys.path.insert(0, str(ROOT))
    names = sorted(path.stem.removeprefix("bench_") for path in HERE.glob("bench_*.py"))
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one or more of: {', '.join(names)} (default: all)")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--quick", action="store_true", help="fewer repetitions: does it run at all? nothing is stored")
    how.add_argument("--keep", action="store_true", help="show these values in the manual and in README")
    parser.add_argument("--half", type=int, choices=(1, 2), help="every second one, from the first or the second on")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON instead of tables")
    args = parser.parse_args()
    unknown = sorted(set(args.names) - set(names))
    if unknown:
        parser.error(f"no benchmark {', '.join(unknown)}; there are: {', '.join(names)}")

    before = record.before()
    results: dict[str, list[Row]] = {}
    chosen = args.names or names
    for name in chosen[args.half - 1 :: 2] if args.half else chosen:
        bench = importlib.import_module(f"bench_{name}")
        if not args.json:
            print(f"\n{bench.TITLE}")
        results[name] = []
        for row in bench.measure(args.quick):
            results[name].append(row)
            if not args.json:
                print(line(row, before.get((name, row.what))), flush=True)
        if args.keep:
            keep(name, bench.TITLE, results[name], getattr(bench, "NEEDS", ()))
    if args.json:
        print(json.dumps({name: [record.as_data(row) for row in rows] for name, rows in results.items()}, indent=2))
    elif not args.quick:
        print_bounds(results)
    if args.quick:
        return 0
    record.save(results)
    if args.keep:
        subprocess.run([sys.executable, "-m", "tests.support.manual"], cwd=ROOT, check=True)
    return 0 if all(row.kept for rows in results.values() for row in rows) else 1


def keep(name: str, title: str, rows: list[Row], needs: Sequence[str]) -> None:
    """Keep a group's rows, unless one that it compares with is not installed."""
    missing = [module for module in needs if find_spec(module) is None]
    if missing:
        print(f"  {name}: the figures of before are kept, as {', '.join(missing)} is not installed", file=sys.stderr)
    else:
        record.keep(name, title, rows)


def line(row: Row, before: float | None) -> str:
    """One row as text: value, quartiles, value of the run before."""
    spread = "" if row.spread is None else f"  {row.spread[0]:.3f} to {row.spread[1]:.3f}"
    return (
        f"  {row.what:76} {row.value:9.3f} {row.unit:7}{spread:18}{'' if before is None else f'  before {before:.3f}'}"
    )


def print_bounds(results: dict[str, list[Row]]) -> None:
    """Every row that has a bound: name, value, bound, whether it holds."""
    bounded = [row for rows in results.values() for row in rows if row.bound is not None]
    if bounded:
        print("\nBounds")
    for row in bounded:
        side = "at least" if row.best == "most" else "at most"
        print(f"  {row.what:76} {row.value:9.3f}  {side} {row.bound:g} {row.unit:7} {'ok' if row.kept else 'MISS'}")


if __name__ == "__main__":
    sys.exit(main())
