"""A listener that stops at its first cloud, as a debugger stops it: the run goes on, and says what was lost."""

import os
import sys

import pytest

from tests.support.live_rig import free_port, listening, ros_domain, run_rig, write_rig

LIBRARIES = {"foxglove": "foxglove", "dds": "cyclonedds", "zenoh": "zenoh"}
UPDATES = 192
"""3.2 s of 1/60 s."""


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
