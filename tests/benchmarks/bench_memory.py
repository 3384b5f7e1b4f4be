"""What runs need and what they leave behind: growth of Python's memory over updates, peak memory of whole processes."""

from __future__ import annotations

import gc
import statistics
import subprocess
import sys
import tracemalloc
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

from measure import Row

from graph.sim import App

TITLE = "Memory"
GRAPHS = Path(__file__).parents[2] / "graphs"
UPDATES = 10_000


def measure(quick: bool) -> Iterator[Row]:
    """Growth over 10,000 updates, and peak sizes."""
    for name in ("arm", "quickstart"):
        yield Row(f"growth of graphs/{name}.yaml over {UPDATES:,} updates", growth(name, quick), 1.0, "KiB")
    if not sys.platform.startswith("linux"):
        return
    for name in ("quickstart", "yard"):
        peak = peak_of("run", str(GRAPHS / f"{name}.yaml"), "--updates", "30" if quick else "300")
        yield Row(f"peak of graph run graphs/{name}.yaml", peak, None, "MiB")
    imports = (
        "import numpy, mujoco; from pxr import Usd; from graph.sim.libraries import import_open3d; import_open3d()"
    )
    bare = peak_of_python(imports)
    yield Row("peak of importing mujoco, open3d and pxr", bare, None, "MiB")


def growth(name: str, quick: bool) -> float:
    """KiB of Python objects that 10,000 updates leave behind, when histories have filled: the median of three times.

    Not counted is what the interpreter's cache of methods holds: each name by which C++ asks for a method is a string
    of its own, and stays in one of the 4,096 places of the cache until another takes it.

    quick: a hundredth of the updates, too few for the histories.
    """
    updates = UPDATES // 100 if quick else UPDATES
    sizes = []
    with App.from_file(str(GRAPHS / f"{name}.yaml")) as app:
        app.play()
        tracemalloc.start()
        app.update(steps=updates)
        for _ in range(4):
            app.update(steps=updates)
            gc.collect()
            sys._clear_type_cache()
            sizes.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
    return statistics.median(after - before for before, after in pairwise(sizes)) / 1024 * UPDATES / updates


def peak_of(*arguments: str) -> float:
    """Peak resident memory [MiB] of a `graph` command that records."""
    with TemporaryDirectory() as folder:
        words = ["graph", *arguments, "--out", folder]
        return peak_of_python(f"import sys; sys.argv = {words!r}; from graph.cli.main import main; assert main() == 0")


def peak_of_python(code: str) -> float:
    """Peak resident memory [MiB] of this interpreter on `code`, in the repository's folder; as Linux reports it.

    The child reads it itself: what a parent can read of it includes the parent's own memory at the fork.
    """
    reading = (
        f"{code}\nimport sys; print(open('/proc/self/status').read().split('VmHWM:')[1].split()[0], file=sys.stderr)"
    )
    process = subprocess.run(
        [sys.executable, "-c", reading], cwd=GRAPHS.parent, capture_output=True, text=True, check=True
    )
    return int(process.stderr.split()[-1]) / 1024
