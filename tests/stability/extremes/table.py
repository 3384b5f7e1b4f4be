"""The table of all cases at the extremes: those of `graph doctor --stability`, and those that only a checkout has.

python -m tests.stability.extremes.table [--only TEXT] [--slow]
"""

import argparse

from graph.cli import extreme_cases
from graph.cli.extremes import show
from tests.stability.extremes import attributes, bodies, clocks, divergence, inputs, rays, sensing

AREAS = ("bodies", "divergence", "rays", "sensors", "clocks", "not finite")
MODULES = (bodies, divergence, rays, sensing, clocks, inputs, attributes)
HEADINGS = ("of", "case", "bound", "measured", "because")
CASES = tuple(
    sorted(
        (
            *extreme_cases.CASES,
            *(
                case
                for module in (bodies, divergence, rays, sensing, clocks, inputs, attributes)
                for case in module.CASES
            ),
        ),
        key=lambda case: AREAS.index(case.area),
    )
)

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", metavar="TEXT", default="", help="the cases whose line contains it")
    parser.add_argument("--slow", action="store_true", help="also those that need minutes or gigabytes")
    args = parser.parse_args()
    raise SystemExit(show([case for case in CASES if args.only in case.line and (args.slow or not case.slow)]))
