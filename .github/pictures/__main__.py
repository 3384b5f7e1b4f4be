"""Makes the pictures of the README from shipped graphs, with the commands that its readers have: `make pictures`.

    python .github/pictures [NAME ...] [--runs DIR]

plays the graphs into DIR (default out/pictures; a run that is there is used again) and draws .github/images/NAME.png.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from drawing import ROOT, Runs
from gallery import campaign, clocks, depth_labels, lidar, radar, trade
from live import live
from yard import yard

DRAWINGS: dict[str, Callable[[Runs], None]] = {
    "yard": yard,
    "lidar": lidar,
    "radar": radar,
    "depth-labels": depth_labels,
    "clocks": clocks,
    "trade": trade,
    "campaign": campaign,
    "live": live,
}


def main() -> None:
    """Draws the pictures that the command line names, or all."""
    parser = argparse.ArgumentParser(description="Makes the pictures of the README.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(DRAWINGS)} (default: all)")
    parser.add_argument("--runs", type=Path, default=ROOT / "out" / "pictures", help="folder of the runs")
    asked = parser.parse_args()
    for name in asked.names or DRAWINGS:
        DRAWINGS[name](Runs(asked.runs))


if __name__ == "__main__":
    main()
