"""`graph sweep --cluster`: the same table on a Dask cluster, also when its workers and its scheduler die."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import time

import pytest

from graph.cli.main import main
from tests.support.dask import Dask
from tests.support.places import ROOT

pytest.importorskip("distributed")

METRIC = ("--metric", "ticks=count(topic('clock'))")


@pytest.fixture(scope="module")
def local(files, tmp_path_factory):
    """A campaign of six seeds on this machine."""
    out = tmp_path_factory.mktemp("local")
    assert main([*command(files, out), "--jobs", "2"]) == 0
    return (out / "campaign.csv").read_bytes()


def command(files, out, number=6):
    seeds = ("--vary", f"seed=0..{number - 1}", "--updates", "3")
    return ["sweep", str(files / "clock.yaml"), "--nodes", str(files / "act.py"), "--out", str(out), *seeds, *METRIC]


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    """A cluster of two workers."""
    with Dask(tmp_path_factory.mktemp("dask")) as cluster:
        yield cluster


@pytest.mark.parametrize("transfer", ["shared", "upload"])
def test_the_table_of_a_cluster_is_that_of_this_machine(files, tmp_path, local, dask, transfer):
    out = tmp_path / transfer
    assert main([*command(files, out), "--cluster", dask.address, "--transfer", transfer]) == 0
    assert (out / "campaign.csv").read_bytes() == local
    assert (out / "runs/0003/run.mcap").stat().st_size > 500


def test_dead_workers_and_a_new_scheduler_lose_nothing(files, tmp_path):
    """A worker is killed after the first result, the scheduler after the third; two new workers go on."""
    out = tmp_path / "c"
    with Dask(tmp_path) as dask:
        arguments = [sys.executable, "-m", "graph", *command(files, out, 8), "--cluster", dask.address]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        with subprocess.Popen(arguments, env=environment, stderr=subprocess.DEVNULL) as campaign:
            wait_for(out, 1, campaign)
            dask.workers[0].send_signal(signal.SIGKILL)
            dask.start_worker()
            wait_for(out, 3, campaign)
            dask.scheduler.send_signal(signal.SIGKILL)
            dask.scheduler.wait()
            dask.start_scheduler()
            dask.start_worker()
            dask.start_worker()
            assert campaign.wait() == 0
    with (out / "campaign.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["run"], row["status"], row["ticks"]) for row in rows] == [(str(n), "ok", "3") for n in range(8)]
    assert not list((out / "runs").glob(".part-*"))


def wait_for(out, number, campaign):
    while len(list((out / "runs").glob("0*"))) < number:
        assert campaign.poll() is None
        time.sleep(0.05)


def test_without_a_scheduler_the_campaign_ends_in_one_line(files, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("wings.campaign.cluster.CONNECT_S", 0.2)
    assert main([*command(files, tmp_path / "c"), "--cluster", "tcp://127.0.0.1:9"]) == 1
    assert "no scheduler answers" in capsys.readouterr().err.strip().splitlines()[-1]
