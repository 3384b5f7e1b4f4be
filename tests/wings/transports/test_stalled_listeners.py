"""A listener that stops at its first cloud, as a debugger stops it: the run goes on, and says what was lost."""

import json
import os
import subprocess
import sys

import pytest

from tests.support.live_rig import free_port, listening, recorded, ros_domain, run_rig, write_rig
from tests.support.places import ROOT

LIBRARIES = {"foxglove": "foxglove", "dds": "cyclonedds", "zenoh": "zenoh"}
UPDATES = 192
"""3.2 s of 1/60 s."""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGSTOP")
@pytest.mark.parametrize("name", LIBRARIES)
def test_a_listener_that_stops_at_the_end_does_not_hold_the_process(name, tmp_path):
    """It stops at the 25th of 32 clouds; the command returns, with a whole recording and report."""
    pytest.importorskip(LIBRARIES[name], reason=f"pip install 'tickgraph[{name}]'")
    domain = ros_domain(110 + os.getpid() % 100 if name == "dds" else 0)
    where = [] if name == "dds" else [free_port()]
    with listening(name, 1000, *where, "late", environment=domain):
        report = run_rig(
            write_rig(tmp_path), tmp_path / "out", "--live", ":".join([name, *map(str, where)]), environment=domain
        )
    assert report["updates"] == UPDATES
    assert len(recorded(tmp_path / "out", "/points")) == 32


EXIT_HOOK = """
import atexit, sys, threading
from graph.cli import command
from graph.recording.transports import sink, targets
class Silent:
    place = "nowhere"
    def close(self): threading.Event().wait()  # a library that waits for its listener for ever
    def __getattr__(self, name): return lambda *args: [] if name == "notes" else None
targets.load = lambda *names: targets.Kind("silent", (), 8765)
sys.modules["silent"] = type(sys)("silent")
sys.modules["silent"].open_transport = lambda target: Silent()
atexit.register(threading.Event().wait)  # as the exit hook of rerun's package waits for its viewer
raise SystemExit(command())
"""


def test_no_library_holds_the_process_once_the_files_are_closed(tmp_path):
    (tmp_path / "g.yaml").write_text("tickgraph: 1\n")
    command = ["run", "g.yaml", "--updates", "3", "--live", "foxglove", "--out", "out"]
    done = subprocess.run(
        [sys.executable, "-c", EXIT_HOOK, *command],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "wrote out/report.json" in done.stdout
    assert json.loads((tmp_path / "out" / "report.json").read_text())["updates"] == 3


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGSTOP")
@pytest.mark.parametrize("name", LIBRARIES)
def test_a_listener_that_stops_does_not_hold_up_the_run_which_counts_what_was_lost(name, tmp_path):
    pytest.importorskip(LIBRARIES[name], reason=f"pip install 'tickgraph[{name}]'")
    domain = ros_domain(100 + os.getpid() % 100 if name == "dds" else 0)
    where = [] if name == "dds" else [free_port()]
    target = ":".join([name, *map(str, where)])
    with listening(name, 1000, *where, "stall", environment=domain):
        report = run_rig(write_rig(tmp_path), tmp_path / "out", "--live", target, environment=domain)
    assert report["updates"] == UPDATES
    # The updates wait for no listener: what they spend in all sinks, the recording's included, stays a small part.
    assert report["timing_s"]["io"] < report["wall_time_s"] / 4
    assert "live-slow-listener" in {warning["code"] for warning in report["warnings"]}
    counts = report["live"][name]["topics"]["/points"]
    assert counts["sent"] + counts["dropped"] + counts["not_sent"] == 32
