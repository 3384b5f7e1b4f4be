"""A long run with a recording, and a process that opens file after file, keep their memory.

pytest tests/robustness/test_soak.py --soak-updates 1000000 --soak-cycles 200
"""

import ctypes
import os
from pathlib import Path

import pytest
from mcap.reader import make_reader

from graph.base.exact import nanoseconds
from graph.recording.mcap_sink import McapSink
from graph.sim import App
from graph.sim.messages.ros_types import message_type
from tests.support.places import ROOT

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


class Mallinfo(ctypes.Structure):
    """What `mallinfo2` of the GNU C library gives [bytes]."""

    _fields_ = [(name, ctypes.c_size_t) for name in ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks")]
    _fields_ += [(name, ctypes.c_size_t) for name in ("fsmblks", "uordblks", "fordblks", "keepcost")]


def allocated():
    """Bytes that the process holds of `malloc`; what is freed and not yet returned to the system does not count."""
    library = ctypes.CDLL(None)
    library.mallinfo2.restype = Mallinfo
    found = library.mallinfo2()
    return found.uordblks + found.hblkhd


MOST_LEFT = 20_000
"""Bytes that a cycle may leave: caches of a few names. A physics engine, scene or graph left over is megabytes."""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="needs the GNU C library")
@pytest.mark.parametrize("name", ["quickstart", "yard"])
def test_opening_playing_and_closing_leaves_nothing(name, request):
    """Ten cycles fill the caches of libraries; as many and more may leave no more than some names."""
    cycles = request.config.getoption("--soak-cycles", default=10)

    def cycle(times):
        for _ in range(times):
            with App.from_file(ROOT / f"graphs/{name}.yaml") as app:
                app.play()
                app.update(12)

    cycle(10)
    before = allocated()
    cycle(cycles)
    assert allocated() - before < MOST_LEFT * max(cycles, 50)
