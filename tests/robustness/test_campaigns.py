"""Campaigns of many runs while their processes are killed at random, the disk fills and the cluster restarts.

    pytest tests/robustness/test_campaigns.py --campaign-runs 200 --seed 3

No run is lost, none is made twice once its result is there, and the table is the same bytes whatever happened, but for
the column `attempts`, which counts the repetitions.
"""

from __future__ import annotations

import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from random import Random

import pytest

from graph.cli.main import main
from tests.support.dask import Dask
from tests.support.disks import in_a_disk
from tests.support.places import ROOT
from tests.support.without_wing import needs_wing

pytestmark = needs_wing("campaign")

CLOCK = """\
tickgraph: 1
clock: {loop_hz: 10, physics_hz: 10}
randomize:
  speed.value: uniform(1, 2)
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      speed: {type: ConstantDouble, inputs: {value: 0.0}}
      metric: {type: example.Metric, inputs: {name: speed}}
      clock: ROS2PublishClock
      time: IsaacReadSimulationTime
    connections:
      - tick.tick -> [metric.execIn, clock.execIn]
      - speed.value -> metric.value
      - time.simulationTime -> clock.timeStamp
"""


@pytest.fixture(scope="module")
def number(request):
    return request.config.getoption("--campaign-runs", default=12)


@pytest.fixture(scope="module")
def clock(tmp_path_factory):
    file = tmp_path_factory.mktemp("clock") / "clock.yaml"
    file.write_text(CLOCK)
    return file


@pytest.fixture
def random(request):
    return Random(request.config.getoption("--seed", default=0))


def options(clock, number):
    metric = ("--metric", "ticks=count(topic('clock'))")
    return ["sweep", str(clock), "--vary", f"seed=0..{number - 1}", "--updates", "3", *metric]


@pytest.fixture(scope="module")
def undisturbed(clock, number, tmp_path_factory):
    """The table of one job."""
    out = tmp_path_factory.mktemp("undisturbed")
    assert main([*options(clock, number), "--jobs", "1", "--out", str(out)]) == 0
    return out / "campaign.csv"


def rows(table):
    with table.open() as stream:
        return list(csv.DictReader(stream))


def without_attempts(table):
    return [{key: value for key, value in row.items() if key != "attempts"} for row in rows(table)]


class Watched:
    """A campaign in a process of its own, gone on with until every run has ended; which results it had is noted."""

    def __init__(self, out, *more):
        self.out, self.more = out, more
        self.starts, self.kept = 0, {}
        self.process = None

    def start(self, arguments):
        command = [sys.executable, "-m", "graph", *arguments, "--out", str(self.out), *self.more]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        self.process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.starts += 1

    def note(self):
        """Notes new results; one that was there is the same file."""
        for name in [one.name for one in (self.out / "runs").glob("[0-9]*")]:
            found = (self.out / "runs" / name / "result.json").stat()
            assert self.kept.setdefault(name, (found.st_ino, found.st_mtime_ns)) == (found.st_ino, found.st_mtime_ns)

    def until_done(self, arguments, hurt, random):
        """Runs it; `hurt` is called now and then, and may end it: then it is resumed."""
        self.start(arguments)
        while True:
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(timeout=random.uniform(0.05, 0.4))
            self.note()
            if self.process.poll() is None:
                hurt(self)
            elif self.process.returncode == -signal.SIGKILL or not (self.out / "campaign.json").exists():
                begun = (self.out / "campaign.json").exists()
                self.start(["sweep", "--resume"] if begun else arguments)
            else:
                assert self.process.returncode in (0, 1)
                return


def children(process):
    """The processes that a process started."""
    with suppress(OSError):
        return [int(one) for one in Path(f"/proc/{process}/task/{process}/children").read_text().split()]
    return []


def killed(process):
    with suppress(OSError):
        os.kill(process, signal.SIGKILL)


def test_the_table_is_the_same_bytes_with_two_and_three_jobs(clock, number, undisturbed, tmp_path):
    for jobs in ("2", "3"):
        assert main([*options(clock, number), "--jobs", jobs, "--out", str(tmp_path / jobs)]) == 0
        assert (tmp_path / jobs / "campaign.csv").read_bytes() == undisturbed.read_bytes()


@pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc")
def test_runs_their_server_and_the_campaign_are_killed(clock, number, undisturbed, tmp_path, random):
    """A run whose process was killed twice is a row that says so, and `--retries` makes it."""
    out = tmp_path / "c"
    deaths = dict.fromkeys(("run", "server", "campaign"), 0)

    seen = [0]

    def hurt(campaign):
        servers = children(campaign.process.pid)
        runs = [run for server in servers for run in children(server)]
        if not runs or deaths["run"] > 1 + len(campaign.kept) / 3:
            return
        what, found = "run", runs
        if len(campaign.kept) >= seen[0] + max(3, number // 12):
            seen[0] = len(campaign.kept)
            what = random.choice(("server", "campaign"))
            found = servers if what == "server" else [campaign.process.pid]
        killed(random.choice(found))
        deaths[what] += 1
        if what == "campaign":
            campaign.process.wait()

    campaign = Watched(out, "--jobs", "3")
    campaign.until_done(options(clock, number), hurt, random)
    print(deaths, "starts", campaign.starts)
    assert {row["status"] for row in rows(out / "campaign.csv")} <= {"ok", "killed"}
    if number >= 100:
        assert all(deaths.values())
    main(["sweep", "--resume", "--retries", "9", "--out", str(out)])
    assert without_attempts(out / "campaign.csv") == without_attempts(undisturbed)
    repeated = sum(int(row["attempts"]) - 1 for row in rows(out / "campaign.csv"))
    assert repeated <= deaths["run"] + 3 * deaths["server"]  # what dies with the campaign is not counted
    assert sorted(one.name for one in (out / "runs").iterdir()) == [f"{run:04d}" for run in range(number)]


def test_a_disk_that_fills_stops_it_until_there_is_space(clock, number, undisturbed, tmp_path, random):
    """Twice the disk has room for a part of the runs alone; then for all."""
    if shutil.which("unshare") is None or in_a_disk(1 << 20, tmp_path / "disk", "true").returncode:
        pytest.skip("no user namespace with a tmpfs on this system")
    disk, kept = tmp_path / "disk", tmp_path / "kept"
    kept.mkdir()
    run = f"{sys.executable} -m graph"
    first = " ".join(f'"{one}"' for one in options(clock, number))
    each = sum(one.stat().st_blocks for one in undisturbed.parent.glob("runs/0000/**/*")) * 512
    shares = random.randint(30, 45), random.randint(55, 80)
    sizes = [4096 * (each * number * share // 100 // 4096) for share in shares]
    script = (
        f"{run} {first} --jobs 2 --out {disk}/c 2> {kept}/1; echo $? >> {kept}/codes;"
        f"ls {disk}/c/runs > {kept}/runs;"
        f"mount -o remount,size={sizes[1]} {disk};"
        f"{run} sweep --resume --jobs 2 --out {disk}/c 2> {kept}/2; echo $? >> {kept}/codes;"
        f"mount -o remount,size=1g {disk};"
        f"{run} sweep --resume --jobs 3 --out {disk}/c 2> {kept}/3; echo $? >> {kept}/codes;"
        f"cp {disk}/c/campaign.csv {kept}; ls {disk}/c/runs > {kept}/all"
    )
    in_a_disk(sizes[0], disk, script)
    said = [(kept / name).read_text() for name in "123"]
    assert (kept / "codes").read_text().split() == ["1", "1", "0"], said
    assert all("make space and go on with --resume" in text and "Traceback" not in text for text in said[:2]), said
    print(len((kept / "runs").read_text().split()), "of", number, "runs before the disk was full")
    assert 0 < len((kept / "runs").read_text().split()) < number
    assert (kept / "all").read_text().split() == [f"{run:04d}" for run in range(number)]
    assert (kept / "campaign.csv").read_bytes() == undisturbed.read_bytes()


def test_workers_the_scheduler_and_the_campaign_of_a_cluster_are_killed(clock, number, undisturbed, tmp_path, random):
    """Two workers are up at a time; killed ones are followed by new ones, as is the scheduler."""
    if number < 50:
        pytest.skip("a small one is in test_cluster.py; give --campaign-runs 200")
    pytest.importorskip("distributed")
    out = tmp_path / "c"
    deaths = dict.fromkeys(("worker", "scheduler", "campaign"), 0)
    least = max(2, number // 12)
    """Results between two deaths."""
    with Dask(tmp_path) as dask:
        seen = [0]

        def hurt(campaign):
            if len(campaign.kept) < seen[0] + least:
                return
            seen[0] = len(campaign.kept)
            what = ("worker", "scheduler", "worker", "campaign")[sum(deaths.values()) % 4]
            deaths[what] += 1
            if what == "campaign":
                killed(campaign.process.pid)
                campaign.process.wait()
            elif what == "scheduler":
                dask.restart_scheduler()
            else:
                dask.restart_worker(random.choice(dask.workers))

        campaign = Watched(out, "--cluster", dask.address)
        began = time.monotonic()
        campaign.until_done(options(clock, number), hurt, random)
        print(deaths, "starts", campaign.starts, f"{time.monotonic() - began:.0f} s")
        assert all(deaths.values())
        main(["sweep", "--resume", "--retries", "9", "--out", str(out)])
    assert without_attempts(out / "campaign.csv") == without_attempts(undisturbed)
    assert sorted(one.name for one in (out / "runs").iterdir()) == [f"{run:04d}" for run in range(number)]
