"""`graph sweep`: every run is a row, whatever becomes of it; a campaign goes on where it stopped."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from graph.cli.main import main
from tests.support.places import ROOT
from wings.campaign.conduct import Limits, conduct
from wings.campaign.folder import Folder
from wings.campaign.launcher import Launcher
from wings.campaign.points import arguments_of
from wings.campaign.specification import Campaign
from wings.campaign.table import as_csv, columns_of, rows_of

FOUR = ("--vary", "seed=0..3", "--updates", "3")


def sweep(files, out, *options):
    """The exit code of `graph sweep` of the clock."""
    nodes = str(files / "act.py")
    return main(["sweep", str(files / "clock.yaml"), "--nodes", nodes, "--out", str(out), *options])


def rows(out):
    with (out / "campaign.csv").open() as stream:
        return list(csv.DictReader(stream))


@pytest.fixture(scope="module")
def four(files, tmp_path_factory):
    """A campaign of four seeds, two at a time."""
    out = tmp_path_factory.mktemp("four")
    metrics = ("--metric", "ticks=count(topic('clock'))", "--metric", "end=max(topic('/clock').clock.nanosec) / 1e9")
    assert sweep(files, out, *FOUR, *metrics, "--jobs", "2", "--report") == 0
    return out


def test_a_row_has_the_point_the_state_metrics_and_what_was_drawn(four):
    """Three updates of 0.1 s: three messages, the last at 0.3 s."""
    found = rows(four)
    assert [(row["run"], row["seed"], row["status"], row["attempts"]) for row in found] == [
        (str(seed), str(seed), "ok", "1") for seed in range(4)
    ]
    assert [(row["ticks"], row["end"]) for row in found] == [("3", "0.3")] * 4
    assert [row["speed"] for row in found] == [row["randomized.speed.value"] for row in found]
    assert len({row["speed"] for row in found}) == 4


def test_a_run_alone_makes_the_bytes_of_the_campaign(four, files, tmp_path):
    nodes = str(files / "act.py")
    options = ["--seed", "2", "--updates", "3", "--nodes", nodes, "--out", str(tmp_path)]
    assert main(["run", str(files / "clock.yaml"), *options]) == 0
    assert (tmp_path / "run.mcap").read_bytes() == (four / "runs/0002/run.mcap").read_bytes()


def test_the_table_is_the_same_bytes_with_one_worker(four, files, tmp_path):
    metrics = ("--metric", "ticks=count(topic('clock'))", "--metric", "end=max(topic('/clock').clock.nanosec) / 1e9")
    assert sweep(files, tmp_path / "one", *FOUR, *metrics, "--jobs", "1") == 0
    assert (tmp_path / "one/campaign.csv").read_bytes() == (four / "campaign.csv").read_bytes()


def test_parquet_has_the_rows_of_the_table(four):
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(four / "campaign.parquet").to_pydict()
    assert table["seed"] == [0, 1, 2, 3]
    assert table["speed"] == [float(row["speed"]) for row in rows(four)]


def test_the_page_loads_nothing_and_has_every_run(four):
    text = (four / "campaign.html").read_text()
    assert "Campaign of 4 runs" in text
    assert "default-src 'none'" in text
    assert text.count("<tr class=") == 4 + 2  # the metrics' table has two more
    assert (four / "campaign.png").read_bytes()[:4] == b"\x89PNG"


def test_a_campaign_is_not_begun_twice_and_resumes_only_as_itself(four, files, capsys):
    assert sweep(files, four, *FOUR) == 2
    assert "holds a campaign; go on with it by --resume" in capsys.readouterr().err
    assert sweep(files, four, "--vary", "seed=0..4", "--updates", "3", "--resume") == 2
    assert "it has 5 runs, the campaign of the folder 4" in capsys.readouterr().err
    before = (four / "campaign.csv").read_bytes()
    assert main(["sweep", "--resume", "--out", str(four)]) == 0
    assert (four / "campaign.csv").read_bytes() == before


def test_a_run_that_hangs_is_ended(files, tmp_path):
    assert sweep(files, tmp_path, "--vary", "act.what=hang", "--updates", "3", "--timeout", "4") == 1
    assert [(row["status"], row["why"]) for row in rows(tmp_path)] == [("timeout", "it took longer than --timeout")]


def test_runs_that_fail_crash_grow_or_are_killed_are_rows(files, tmp_path):
    varied = ("--vary", "act.what=nothing,fail,crash,die,grow", "--updates", "3")
    assert sweep(files, tmp_path, *varied, "--memory", "900M", "--jobs", "3") == 1
    found = {row["act.what"]: row for row in rows(tmp_path)}
    assert {what: row["status"] for what, row in found.items()} == {
        "nothing": "ok",
        "fail": "failed",
        "crash": "crashed",
        "die": "killed",
        "grow": "memory",
    }
    assert "as asked" in found["fail"]["why"]
    assert found["die"]["attempts"] == "2"  # repeated once
    assert "SIGABRT" in found["crash"]["why"]
    assert (tmp_path / "runs/0001/report.json").exists()
    assert not list((tmp_path / "runs").glob(".part-*"))


def test_a_run_that_is_killed_once_is_repeated_and_marked(files, tmp_path):
    mark = tmp_path / "mark"
    assert sweep(files, tmp_path / "c", "--vary", f"act.what={mark},nothing", "--updates", "3") == 0
    assert [(row["status"], row["attempts"]) for row in rows(tmp_path / "c")] == [("ok", "2"), ("ok", "1")]


def test_retries_and_a_limit_of_failures(files, tmp_path):
    failing = ("--vary", "act.what=fail", "--vary", "seed=0..2", "--updates", "3", "--jobs", "1")
    assert sweep(files, tmp_path, *failing, "--max-failures", "1") == 1
    assert [row["status"] for row in rows(tmp_path)] == ["failed", "missing", "missing"]
    assert main(["sweep", "--resume", "--retries", "1", "--jobs", "2", "--out", str(tmp_path)]) == 1
    assert [(row["status"], row["attempts"]) for row in rows(tmp_path)] == [("failed", "2")] * 3


def test_a_campaign_whose_process_is_killed_goes_on(files, tmp_path, four):
    """Nothing is lost, nothing is made twice: the finished runs keep their files."""
    command = [sys.executable, "-m", "graph", "sweep", str(files / "clock.yaml"), "--nodes", str(files / "act.py")]
    metrics = ("--metric", "ticks=count(topic('clock'))", "--metric", "end=max(topic('/clock').clock.nanosec) / 1e9")
    out = tmp_path / "c"
    options = [*FOUR, *metrics, "--out", str(out), "--jobs", "1"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen([*command, *options], env=environment, stderr=subprocess.DEVNULL) as process:
        while not (out / "runs/0001").exists():
            assert process.poll() is None
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
    finished = {one.name: (one / "result.json").stat().st_mtime_ns for one in (out / "runs").glob("0*")}
    assert main(["sweep", "--resume", "--out", str(out)]) == 0
    assert (out / "campaign.csv").read_bytes() == (four / "campaign.csv").read_bytes()
    assert all((out / "runs" / name / "result.json").stat().st_mtime_ns == at for name, at in finished.items())


def test_a_full_disk_stops_the_campaign_and_no_run_is_half_written(files, tmp_path, monkeypatch):
    """The second result does not fit; after that there is space again."""
    point = [{"file": str(files / "clock.yaml"), "seed": str(seed)} for seed in range(3)]
    common = ["--nodes", str(files / "act.py"), "--updates", "3"]
    campaign = Campaign(point, ["seed"], common)

    class Full(Folder):
        def commit(self, part, name, result):
            if name == "0001":
                raise OSError(28, os.strerror(28), str(part))
            super().commit(part, name, result)

    with Launcher([arguments_of(point[0], common)]) as launcher:
        stopped = conduct(campaign, Full(tmp_path), launcher, Limits())
        assert "make space and go on with --resume" in stopped.why_stopped
        assert stopped.done == 1
        folder = Folder(tmp_path)
        folder.tidy()
        assert sorted(one.name for one in (tmp_path / "runs").iterdir()) == ["0000"]
        assert conduct(campaign, folder, launcher, Limits()).done == 3
    found = rows_of(campaign, folder)
    assert [row["status"] for row in found] == ["ok"] * 3
    assert as_csv(columns_of(campaign, found), found).count("\n") == 4


def test_a_server_that_is_killed_loses_no_run(files, tmp_path):
    points = [{"file": str(files / "clock.yaml"), "seed": str(seed)} for seed in range(3)]
    campaign = Campaign(points, ["seed"], ["--nodes", str(files / "act.py"), "--updates", "3"])
    killed = []

    def kill_once(state):
        if state.done == 1 and not killed:
            killed.append(launcher.process)
            os.kill(launcher.process, signal.SIGKILL)

    with Launcher() as launcher:
        assert conduct(campaign, Folder(tmp_path), launcher, Limits(jobs=1), tell=kill_once).done == 3
    results = [json.loads((tmp_path / f"runs/000{number}/result.json").read_text()) for number in range(3)]
    assert [one["status"] for one in results] == ["ok"] * 3
    assert killed


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (("--metric", "run=1"), "--metric run: the table has a column of this name; choose another"),
        (("--metric", "seed=1"), "--metric seed: the table has a column of this name; choose another"),
        (
            ("--metric", "a=1", "--metric", "a=2"),
            "--metric a=2: the metric is given twice; name one of them differently",
        ),
        (("--jobs", "0"), "--jobs 0: give a number of runs, 1 or more"),
        (("--memory", "0"), "--memory 0: give bytes, such as 4G or 500M"),
        (("--retries", "-1"), "--retries -1: give a number, 0 or more"),
        (("--vary", "seed=2"), "--vary seed=2: the key is varied twice; give all its values in one --vary"),
        (("--vary", "speed.value=5..1"), "--vary speed.value=5..1: 5..1 is not a range"),
        (("--vary", "speed.value="), "--vary speed.value=: write it as KEY=V1,V2,..."),
    ],
)
def test_options_that_cannot_be_are_refused_before_a_run_is_made(files, tmp_path, capsys, options, problem):
    assert sweep(files, tmp_path / "c", *FOUR, *options) == 2
    assert capsys.readouterr().err.startswith(f"graph: {problem}")
    assert not (tmp_path / "c").exists()


def test_a_metric_of_a_node_keeps_its_name_beside_a_column_that_has_it(files, tmp_path):
    """`example.Metric` writes `seed` and `updates`: the key varied stays, what the report counts does not."""
    text = (files / "clock.yaml").read_text()
    file = tmp_path / "named.yaml"
    for name in ("seed", "updates"):
        file.write_text(text.replace("inputs: {name: speed}", f"inputs: {{name: {name}}}"))
        arguments = ["sweep", str(file), "--nodes", str(files / "act.py"), "--vary", "seed=3", "--updates", "2"]
        assert main([*arguments, "--out", str(tmp_path / name)]) == 0
    (seed,), (updates,) = rows(tmp_path / "seed"), rows(tmp_path / "updates")
    assert (seed["seed"], seed["metric.seed"]) == ("3", seed["randomized.speed.value"])
    assert updates["updates"] == updates["randomized.speed.value"]
