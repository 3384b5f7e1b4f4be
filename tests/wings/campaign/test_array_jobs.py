"""Campaigns by the array jobs of a batch system: a plan, one index one run, and only what is missing is asked for."""

from __future__ import annotations

import csv
import json

import pytest

from graph.cli.main import main
from graph.cli.output_folder import locked

POINTS = ("--vary", "seed=0..2", "--updates", "3", "--metric", "ticks=count(topic('clock'))")


@pytest.fixture
def sweep(capsys):
    """Runs `graph sweep`; gives its exit code and its lines."""

    def run(*arguments):
        code = main(["sweep", *map(str, arguments)])
        out, err = capsys.readouterr()
        return code, out.strip(), err.strip()

    return run


@pytest.fixture
def planned(files, tmp_path, sweep):
    """The folder of a planned campaign of three seeds."""
    out = tmp_path / "c"
    nodes = files / "act.py"
    code, said, _ = sweep(files / "clock.yaml", "--nodes", nodes, *POINTS, "--out", out, "--plan")
    assert (code, said) == (0, f"planned 3 runs in {out}")
    assert [one.name for one in out.iterdir()] == ["campaign.json"]
    return out


def test_each_index_is_a_run_and_the_table_is_that_of_one_machine(files, planned, tmp_path, sweep):
    assert sweep("--missing", "--out", planned)[:2] == (0, "0-2")
    assert sweep("--index", 1, "--out", planned)[:2] == (0, "run 0001 ok")
    assert sweep("--missing", "--out", planned)[:2] == (0, "0,2")
    assert sweep("--report", "--out", planned)[0] == 0  # draws the table, and runs nothing
    with (planned / "campaign.csv").open() as stream:
        assert [row["status"] for row in csv.DictReader(stream)] == ["missing", "ok", "missing"]
    before = (planned / "runs/0001/result.json").stat().st_mtime_ns
    assert sweep("--index", 1, "--out", planned)[:2] == (0, "run 0001 ok")  # it is made once
    assert sweep("--index", 0, "--out", planned)[0] == 0
    assert sweep("--resume", "--out", planned)[0] == 0  # makes run 2
    assert (planned / "runs/0001/result.json").stat().st_mtime_ns == before
    assert sweep("--missing", "--out", planned)[:2] == (0, "")
    local = tmp_path / "local"
    assert sweep(files / "clock.yaml", "--nodes", files / "act.py", *POINTS, "--out", local)[0] == 0
    assert (planned / "campaign.csv").read_bytes() == (local / "campaign.csv").read_bytes()


def test_a_failed_run_is_asked_for_again_only_with_retries(files, tmp_path, sweep):
    out = tmp_path / "c"
    plan = ("--vary", "act.what=nothing,fail", "--updates", "2", "--out", out, "--plan")
    assert sweep(files / "clock.yaml", "--nodes", files / "act.py", *plan)[0] == 0
    assert sweep("--index", 0, "--out", out)[0] == 0
    code, said, _ = sweep("--index", 1, "--out", out)
    assert (code, said.partition(":")[0]) == (1, "run 0001 failed")
    assert sweep("--missing", "--out", out)[1] == ""
    assert sweep("--missing", "--retries", 1, "--out", out)[1] == "1"
    assert sweep("--index", 1, "--retries", 1, "--out", out)[0] == 1
    assert sweep("--missing", "--retries", 1, "--out", out)[1] == ""
    assert json.loads((out / "runs/0001/result.json").read_text())["attempts"] == 2


def test_indices_share_a_folder_that_no_campaign_goes_on_with_meanwhile(planned, sweep):
    """The attempts of running jobs are not swept away."""
    with locked(planned, "", shared=True):
        assert sweep("--index", 0, "--out", planned)[0] == 0
        code, _, err = sweep("--resume", "--out", planned)
        assert (code, "let that campaign end" in err) == (2, True)
    with locked(planned, ""):
        code, _, err = sweep("--index", 1, "--out", planned)
        assert (code, "let that campaign end" in err) == (2, True)


def test_what_cannot_be_run_is_refused_in_one_line(planned, tmp_path, sweep):
    assert sweep("--index", 3, "--out", planned)[::2] == (
        2,
        "graph: --index 3: the campaign has the runs 0 to 2",
    )
    assert "begin it with --plan" in sweep("--index", 0, "--out", tmp_path)[2]
    assert "begin it with --plan" in sweep("--missing", "--out", tmp_path)[2]


def test_an_index_of_another_folder_or_another_file_makes_no_run(tmp_path, files, sweep, monkeypatch):
    """A run that read another file, or none, would be a row that no retry mends."""
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.chdir(home)
    (home / "clock.yaml").write_text((files / "clock.yaml").read_text())
    plan = ("--nodes", files / "act.py", "--vary", "seed=0..1", "--updates", "2", "--out", "c", "--plan")
    assert sweep("clock.yaml", *plan)[0] == 0
    monkeypatch.chdir(tmp_path)
    code, _, err = sweep("--index", 0, "--out", "home/c")
    assert (code, err) == (2, "graph: clock.yaml: no such file; start the command where the campaign began")
    monkeypatch.chdir(home)
    (home / "clock.yaml").write_text((files / "clock.yaml").read_text() + "# changed\n")
    code, _, err = sweep("--index", 0, "--out", "c")
    assert (code, err) == (2, "graph: clock.yaml has changed since the campaign began; begin another")
    assert sweep("--missing", "--out", "c")[1] == "0-1"
