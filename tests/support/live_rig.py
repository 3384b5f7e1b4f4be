"""A graph file whose robot follows /cmd_vel, with a lidar in a closed room: a cloud of 32 x 1800 = 57,600 points
every 0.1 s; and programs that listen to its run without this project's code.
"""

import hashlib
import json
import subprocess
import sys
import time
from contextlib import contextmanager

from mcap.reader import make_reader

from graph.cli.new import text
from tests.support.places import ROOT
from tests.support.programs import started

CLOUDS, POINTS = 30, 57_600
LISTENERS = ROOT / "tests" / "support" / "live_listeners"
_PRIMS = """
    /World/Room: {type: Cube, size: 8.0, translate: [100, 0, 10], collision: false}
    /World/Lidar:
      type: OmniLidar
      config: XT32
      translate: [100, 0, 10]
      attributes: {"omni:sensor:Core:patternFiringRateHz": 18000}

clock: """
_GRAPH = """
  /World/LidarGraph:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points, frameId: lidar}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath

record:"""


def write_rig(folder):
    """Writes the graph file into a folder; gives its path."""
    path = folder / "rig.yaml"
    rig = text("diffdrive", path.name).replace("\nclock: ", _PRIMS, 1).replace("\nrecord:", _GRAPH, 1)
    path.write_text(rig, encoding="utf8")
    return path


@contextmanager
def listening(name, *arguments, environment=None):
    """A program of `live_listeners`, which is ready to listen: receives clouds and odometry, publishes commands."""
    script = str(LISTENERS / f"{name}.py")
    options = {"stdout": subprocess.PIPE, "text": True, "env": environment}
    with started(script, *map(str, arguments), **options) as process:
        assert process.stdout.readline() == "ready\n"
        yield process


def heard(process):
    """What a listener says when it has all clouds, or when nothing came for a while."""
    return json.loads(process.stdout.read())


def run_rig(file, out, *options, environment=None):
    """Plays the file in real time for a cloud more than 3 s; gives what the command wrote to stderr."""
    command = [sys.executable, "-m", "graph", "run", str(file), "--realtime", "--duration", "3.2", "--out", str(out)]
    done = subprocess.run([*command, *options], cwd=ROOT, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    return done.stderr


def recorded(out, topic):
    """The CDR bytes of a topic's messages in the recording of a run."""
    with (out / "run.mcap").open("rb") as file:
        return [message.data for _, _, message in make_reader(file).iter_messages(topics=[topic])]


def digests(messages):
    """The SHA-256 of each message."""
    return [hashlib.sha256(data).hexdigest() for data in messages]


def wait_until(condition, seconds=20.0):
    """Waits until `condition()`, for so long at most; gives its last value."""
    end = time.monotonic() + seconds
    while not (value := condition()) and time.monotonic() < end:
        time.sleep(0.01)
    return value
