"""Runs the benchmarks and prints their tables: `python tests/benchmarks/run.py [--quick] [NAME...]`.

Exits 1 if a value exceeds its bound and `--strict` is given; without it a table only says so, since other work on the
machine may be to blame.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from pathlib import Path

from measure import Row

HERE = Path(__file__).parent


def main() -> int:
    """Run what the command line names, else everything."""
    sys.path.insert(0, str(HERE.parents[1]))
    names = sorted(path.stem.removeprefix("bench_") for path in HERE.glob("bench_*.py"))
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one or more of: {', '.join(names)} (default: all)")
    parser.add_argument("--quick", action="store_true", help="fewer repetitions: does it run at all?")
    parser.add_argument("--strict", action="store_true", help="exit 1 if a bound is exceeded")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON instead of tables")
    args = parser.parse_args()
    unknown = sorted(set(args.names) - set(names))
    if unknown:
        parser.error(f"no benchmark {', '.join(unknown)}; there are: {', '.join(names)}")

    results: dict[str, list[Row]] = {}
    for name in args.names or names:
        bench = importlib.import_module(f"bench_{name}")
        if not args.json:
            print(f"\n{bench.TITLE}")
        results[name] = []
        for row in bench.measure(args.quick):
            results[name].append(row)
            if not args.json:
                print(line(row), flush=True)
    if args.json:
        print(json.dumps({name: [vars(row) for row in rows] for name, rows in results.items()}, indent=2))
    exceeded = [row for rows in results.values() for row in rows if not row.kept]
    return 1 if exceeded and args.strict else 0


def line(row: Row) -> str:
    """One row as text."""
    bound = "" if row.bound is None else f"  at most {row.bound:g} {row.unit}  {'ok' if row.kept else 'OVER'}"
    return f"  {row.what:66} {row.value:9.3f} {row.unit:3}{bound}"


if __name__ == "__main__":
    sys.exit(main())
