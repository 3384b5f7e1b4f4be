"""kill -9 at random points: what is lost is less than a second of simulation, whatever the traffic.

pytest tests/robustness/test_kill.py --kills 100
"""

import random
import subprocess
import textwrap
import time

import pytest
from mcap.reader import make_reader

from graph.recording.recovery import finish
from graph.recording.run_reader import recorded_files
from tests.support.programs import started

LONGEST_LOSS_NS = 10**9
PROGRAM = """
import os, sys
import numpy as np
from graph.sim import App
from graph.base.exact import nanoseconds
from graph.recording.recorder import Recorder
from graph.sim.messages.ros_types import message_type
path, progress, traffic = sys.argv[1:]
Clock, Time = message_type("rosgraph_msgs/msg/Clock"), message_type("builtin_interfaces/msg/Time")
Bytes = message_type("std_msgs/msg/ByteMultiArray")
Layout = message_type("std_msgs/msg/MultiArrayLayout")
noise = np.random.default_rng(0).integers(0, 256, 150_000, np.uint8)
note = os.open(progress, os.O_WRONLY | os.O_CREAT)
with App(physics_hz=60, loop_hz=60) as app:
    app.bus.subscribe(Recorder(path, split_ns=10**9 if traffic == "parts" else None))
    def publish():
        now = nanoseconds(app.simulation.time)
        if traffic != "sparse" or app.update_index % 45 == 0:
            app.bus.publish("/clock", "rosgraph_msgs/msg/Clock", Clock(Time(now // 10**9, now % 10**9)), now)
        if traffic in ("heavy", "parts"):
            app.bus.publish("/noise", "std_msgs/msg/ByteMultiArray", Bytes(Layout([], 0), noise), now)
    app.on("simulation_graphs", publish)
    app.play()
    while True:
        app.update()
        os.pwrite(note, nanoseconds(app.simulation.time).to_bytes(8, "little"), 0)  # one write: whole or not at all
"""


def pytest_generate_tests(metafunc):
    if "delay" in metafunc.fixturenames:
        config = metafunc.config
        draw = random.Random(config.getoption("--seed", default=0))
        kills = config.getoption("--kills", default=6)
        # Seconds after the first update; runs are faster than real time, so this is many seconds of simulation.
        metafunc.parametrize("delay", [round(draw.uniform(0.0, 0.6), 3) for _ in range(kills)])


@pytest.mark.parametrize("traffic", ["sparse", "steady", "heavy", "parts"])
def test_a_killed_run_has_lost_less_than_a_second(tmp_path, delay, traffic):
    recording, progress = tmp_path / "run.mcap", tmp_path / "progress"
    arguments = ["-c", textwrap.dedent(PROGRAM), str(recording), str(progress), traffic]
    with started(*arguments, stderr=subprocess.DEVNULL) as process:
        while not progress.exists() or progress.stat().st_size < 8:
            assert process.poll() is None
            time.sleep(0.001)
        time.sleep(delay)
        process.kill()
        process.wait()
    reached = int.from_bytes(progress.read_bytes(), "little")
    files = recorded_files(tmp_path)
    if not files:  # no chunk was due yet
        assert reached < LONGEST_LOSS_NS
        return
    logged = []
    if len(files) > 1 and not files[-1].stat().st_size:  # a part that had just begun
        files.pop()
        assert finish(files[-1]).whole
    for one in files:
        left = finish(one)
        assert left.whole or one == files[-1]  # every part but the last was finished before the next began
        with one.open("rb") as file:
            found = [message.log_time for _, _, message in make_reader(file, validate_crcs=True).iter_messages()]
        assert len(found) == left.messages
        logged += found
    assert logged == sorted(logged)
    step = 10**9 // 60
    due = [one for one in range(1, reached // step + 1) if traffic != "sparse" or (one - 1) % 45 == 0]
    # Of what was sent a second or more before the end, everything is there.
    old = [round(one * 10**9 / 60) for one in due if round(one * 10**9 / 60) <= reached - LONGEST_LOSS_NS]
    assert set(old) <= set(logged)
