"""How long a command takes from nothing: whole processes, against the imports that nobody can avoid."""

from __future__ import annotations

import compileall
import os
import shutil
import statistics
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from measure import Row, ratio, seconds

TITLE = "Start (whole processes)"
ROOT = Path(__file__).parents[2]
PACKAGES = ("graph", "nodes", "sensors", "wings")
IMPORTS = ("-c", "import numpy; from pxr import Usd, UsdPhysics")
ALL_IMPORTS = ("-c", f"{IMPORTS[1]}; from graph.sim.libraries import import_open3d; import_open3d()")
CHECK = ("-m", "graph", "check", str(ROOT / "graphs" / "yard.yaml"))
QUICKSTART = ("-m", "graph", "run", str(ROOT / "graphs" / "quickstart.yaml"), "--updates", "60")


def measure(quick: bool) -> Iterator[Row]:
    """The check of the yard as a multiple of the bare imports, and a short run in seconds."""
    rounds = 1 if quick else 11
    with packages(compiled=True) as ready, packages(compiled=False) as bare:
        for folder, how in ((ready, ""), (bare, ", no byte code of ours")):
            check = ratio(lambda at=folder: python(at, *CHECK), lambda at=folder: python(at, *IMPORTS), rounds, 1)
            yield Row(f"graph check graphs/yard.yaml / importing numpy and pxr{how}", check, 3.0 if how else 2.2)
        python(ready, *QUICKSTART)
        short = ratio(lambda: python(ready, *QUICKSTART), lambda: python(ready, *ALL_IMPORTS), rounds, 1)
        yield Row("graph run graphs/quickstart.yaml --updates 60 / importing numpy, pxr and open3d", short, 4.0)
        run = statistics.median(seconds(lambda: python(ready, *QUICKSTART)) for _ in range(rounds))
        yield Row("graph run graphs/quickstart.yaml --updates 60", run, 4.0, "s")
        help_ = statistics.median(seconds(lambda: python(ready, "-m", "graph", "--help")) for _ in range(rounds))
        yield Row("graph --help", help_, None, "s")
    if not quick:
        yield from first_runs()


def first_runs() -> Iterator[Row]:
    """Processor seconds of a first run beyond one that compiles nothing: on a machine, and in a second clone."""
    for name, bound in (("lidar_point_cloud", 5.0), ("yard", 15.0)):
        command = ("-m", "graph", "run", str(ROOT / "graphs" / f"{name}.yaml"), "--updates", "24")
        with packages(compiled=True) as first, packages(compiled=True) as second, TemporaryDirectory() as cache:
            cold = processor_seconds(first, cache, *command)
            warm = [processor_seconds(first, cache, *command) for _ in range(3)]
            other = [processor_seconds(second, cache, *command) for _ in range(3)]
            what = f"first run of graphs/{name}.yaml over a warm one, processor time"
            yield Row(f"{what}: nothing compiled", cold - statistics.median(warm), bound, "s")
            yield Row(f"{what}: in a second clone", statistics.median(other) - statistics.median(warm), 0.5, "s")


def processor_seconds(folder: Path, cache: str, *arguments: str) -> float:
    """Those of this interpreter on `arguments` with the packages of `folder`, and compiled loops in `cache`."""
    before = os.times()
    python(folder, *arguments, TICKGRAPH_CACHE=cache)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


@contextmanager
def packages(*, compiled: bool) -> Iterator[Path]:
    """A folder with our packages as they are, and their byte code or none, whatever the checkout has of it."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        for package in PACKAGES:
            shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__", "shipped"))
        if compiled:
            compileall.compile_dir(folder, quiet=1)
        yield folder


def python(folder: Path, *arguments: str, **more: str) -> None:
    """Run this interpreter on `arguments` with the packages of `folder` and more environment; writes no byte code."""
    settings = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", **more}
    done = subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=settings, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"python {' '.join(arguments)} ended with {done.returncode}: {done.stderr.strip()}")
