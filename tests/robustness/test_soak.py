"""A long run with a recording keeps its memory.

pytest tests/robustness/test_soak.py --soak-updates 1000000
"""

import os
from pathlib import Path

import pytest
from mcap.reader import make_reader

from graph.base.exact import nanoseconds
from graph.sim import App
from graph.sim.messages.recording import McapSink
from graph.sim.messages.ros_types import message_type

MOST_GROWTH = 4_000_000
"""Bytes that a thousand updates may add, and a chunk's index of some hundred bytes for every half second beside."""


def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
def test_updates_and_a_recording_keep_their_memory(tmp_path, request):
    updates = request.config.getoption("--soak-updates", default=4000)
    stamp, clock = message_type("builtin_interfaces/msg/Time"), message_type("rosgraph_msgs/msg/Clock")
    with App(physics_hz=240, loop_hz=60) as app:
        app.bus.subscribe(McapSink(tmp_path / "run.mcap"))

        def publish():
            now = nanoseconds(app.simulation.time)
            app.bus.publish("/clock", "rosgraph_msgs/msg/Clock", clock(stamp(now // 10**9, now % 10**9)), now)

        app.on("simulation_graphs", publish)
        app.play()
        app.update(1000)
        before = resident()
        app.update(updates)
        assert resident() - before < MOST_GROWTH + updates // 30 * 1000
    with (tmp_path / "run.mcap").open("rb") as file:
        assert make_reader(file).get_summary().statistics.message_count == updates + 1000
