"""What a campaign costs beside its runs: against plain runs side by side, its own work, starts, further Apps."""

from __future__ import annotations

import heapq
import json
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from measure import Row

from tests.support.many_apps import further_app_mb
from wings.campaign.conduct import Limits, conduct
from wings.campaign.folder import Folder
from wings.campaign.launcher import Ended, Order
from wings.campaign.specification import Campaign
from wings.campaign.table import write_tables

TITLE = "Campaigns"
ROOT = Path(__file__).parents[2]
QUICKSTART = str(ROOT / "graphs" / "quickstart.yaml")
STARTS = """
import os, sys, time
os.sched_setaffinity(0, {0})
from wings.campaign.rehearsal import rehearse
for _ in range(2):
    began = time.process_time()
    rehearse(["run", sys.argv[1]], play=True)
    print(time.process_time() - began)
"""


def measure(quick: bool) -> Iterator[Row]:
    """The rows: plain runs over campaign, its own share, the second start, many cores by simulation, memory."""
    runs, jobs = (2, 2) if quick else (24, 2)
    name = "quickstart" if quick else "yard"
    scene = str(ROOT / "graphs" / f"{name}.yaml")
    plain, campaign = side_by_side(runs, jobs), swept(runs, jobs)
    yield Row(
        f"{runs} plain runs of quickstart, {jobs} at a time / the same campaign", plain / campaign, 0.95, best="most"
    )
    if not quick:
        yield Row("processor time of a campaign of 100 runs without them / 100 runs of 2 s", own_share(), 0.02)
    first, second = map(float, python(STARTS, scene).split())
    yield Row(f"start of a second run of the {name} in a process / the first", second / first, 0.5)
    yield Row(
        "1000 runs of 1 to 3 s on 64 cores, simulated: throughput / 64 cores", simulated(1000, 64), 0.9, best="most"
    )
    yield Row(f"memory of each further App of the {name} in a process", further_app_mb(scene), 40.0, "MB")


def python(program: str, *arguments: str) -> str:
    """What a program prints."""
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return done.stdout


def side_by_side(runs: int, jobs: int) -> float:
    """Wall time of plain commands, so many at a time [s]."""
    began, running = time.perf_counter(), list[subprocess.Popen[bytes]]()
    with TemporaryDirectory() as folder:
        for number in range(runs):
            while len([one for one in running if one.poll() is None]) >= jobs:
                time.sleep(0.005)
            command = ["run", QUICKSTART, "--updates", "60", "--seed", str(number), "--out", f"{folder}/{number}"]
            running.append(subprocess.Popen([sys.executable, "-m", "graph", *command], cwd=ROOT, stdout=-3, stderr=-3))
        for one in running:
            one.wait()
    return time.perf_counter() - began


def swept(runs: int, jobs: int) -> float:
    """Wall time of the same runs as a campaign [s]."""
    began = time.perf_counter()
    with TemporaryDirectory() as folder:
        options = ["--vary", f"seed=0..{runs - 1}", "--updates", "60", "--jobs", str(jobs), "--out", f"{folder}/c"]
        subprocess.run([sys.executable, "-m", "graph", "sweep", QUICKSTART, *options], cwd=ROOT, check=True, stdout=-3)
    return time.perf_counter() - began


class Simulated:
    """Runs that take their time on a clock of its own, and write a report."""

    def __init__(self, durations: list[float]) -> None:
        self.durations, self.now = durations, 0.0
        self._ends: list[tuple[float, int]] = []

    def start(self, order: Order) -> None:
        Path(order.folder, "report.json").write_text(json.dumps({"updates": 60, "warnings": []}))
        heapq.heappush(self._ends, (self.now + self.durations[order.number], order.number))

    def slots(self, jobs: int) -> int:
        return jobs

    def stop(self, number: int) -> None:
        """Nothing runs."""

    def wait(self, seconds: float) -> list[Ended]:
        self.now, number = heapq.heappop(self._ends)
        return [Ended(number, 0)]


def own_share() -> float:
    """Processor time of the campaign itself, over 100 runs of 2 s."""
    campaign = Campaign([{"file": "a.yaml", "seed": str(seed)} for seed in range(100)], ["seed"])
    with TemporaryDirectory() as name:
        folder = Folder(Path(name))
        began = time.process_time()
        conduct(campaign, folder, Simulated([2.0] * 100), Limits(jobs=2))
        write_tables(campaign, folder)
        return (time.process_time() - began) / 200


def simulated(runs: int, cores: int) -> float:
    """Throughput of the queue over that of so many cores."""
    lengths = random.Random(1)
    durations = [lengths.uniform(1, 3) for _ in range(runs)]
    executor = Simulated(durations)
    campaign = Campaign([{"file": "a.yaml"}] * runs)
    with TemporaryDirectory() as name:
        conduct(campaign, Folder(Path(name)), executor, Limits(jobs=cores))
    return sum(durations) / (executor.now * cores)
