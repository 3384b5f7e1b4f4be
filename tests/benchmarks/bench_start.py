"""How long a command takes from nothing: whole processes, against the imports that nobody can avoid."""

from __future__ import annotations

import statistics
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from measure import Row, ratio, seconds

TITLE = "Start (whole processes)"
ROOT = Path(__file__).parents[2]
IMPORTS = ("-c", "import numpy; from pxr import Usd, UsdPhysics")
CHECK = ("-m", "graph", "check", "graphs/yard.yaml")
QUICKSTART = ("-m", "graph", "run", "graphs/quickstart.yaml", "--updates", "60")


def measure(quick: bool) -> Iterator[Row]:
    """The check of the yard as a multiple of the bare imports, and a short run in seconds."""
    rounds = 3 if quick else 11
    times = ratio(lambda: python(*CHECK), lambda: python(*IMPORTS), rounds, warm_up=1)
    yield Row("graph check graphs/yard.yaml / importing numpy and pxr", times, 3.0)
    python(*QUICKSTART)
    run = statistics.median(seconds(lambda: python(*QUICKSTART)) for _ in range(rounds))
    yield Row("graph run graphs/quickstart.yaml --updates 60", run, 4.0, "s")
    bare = statistics.median(seconds(lambda: python("-m", "graph", "--help")) for _ in range(rounds))
    yield Row("graph --help", bare, None, "s")


def python(*arguments: str) -> None:
    """Run this interpreter on `arguments`, from the repository's root."""
    done = subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"python {' '.join(arguments)} ended with {done.returncode}: {done.stderr.strip()}")
