"""A graph file whose runs cost little: it publishes its clock, and one of its nodes can fail, hang or crash."""

from __future__ import annotations

import pytest

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
      act: {type: example.Act, inputs: {what: nothing}}
      clock: ROS2PublishClock
      time: IsaacReadSimulationTime
    connections:
      - tick.tick -> [metric.execIn, act.execIn, clock.execIn]
      - speed.value -> metric.value
      - time.simulationTime -> clock.timeStamp
"""
ACT = """\
import os, signal, time
from pathlib import Path
from graph import Attribute, Database, node_type

@node_type(
    "example.Act",
    inputs={"execIn": Attribute("execution", "acts"), "what": Attribute("string", "what it does", default="nothing")},
)
def act(db: Database) -> None:
    \"\"\"Does what a run should survive.\"\"\"
    what = db.inputs.what
    if what == "fail":
        raise RuntimeError("as asked")
    if what == "hang":
        time.sleep(600)
    if what == "crash":
        os.abort()
    if what == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "grow":
        kept = bytearray(2**30)
        kept[::4096] = b"x" * len(kept[::4096])
        time.sleep(600)
    mark = Path(what)
    if what.startswith("/") and not mark.exists():
        mark.write_text("once")
        os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture(scope="session")
def files(tmp_path_factory):
    """The folder of the graph file `clock.yaml` and of the node `act.py`."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "clock.yaml").write_text(CLOCK)
    (folder / "act.py").write_text(ACT)
    return folder
