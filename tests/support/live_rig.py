"""A graph file whose robot follows /cmd_vel, with a lidar in a closed room: a cloud of 32 x 1800 = 57,600 points
every 0.1 s; and programs that listen to its run without this project's code.
"""

import hashlib
import json
import os
import socket
import subprocess
import sys
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


_OF_ROS = (
    '<CycloneDDS><Domain Id="{0}"><Discovery><ParticipantIndex>auto</ParticipantIndex>'
    "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex></Discovery></Domain></CycloneDDS>,"
    '<CycloneDDS><Domain Id="{0}"><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces></General>'
    "</Domain></CycloneDDS>"
)
"""What rmw_cyclonedds makes of the manual's CYCLONEDDS_URI: its own part first."""


def ros_domain(number):
    """The environment of a program in a ROS domain, with Cyclone DDS on the loopback interface."""
    return {**os.environ, "ROS_DOMAIN_ID": str(number), "CYCLONEDDS_URI": _OF_ROS.format(number)}


def write_rig(folder):
    """Writes the graph file into a folder; gives its path."""
    path = folder / "rig.yaml"
    rig = text("diffdrive", path.name).replace("\nclock: ", _PRIMS, 1).replace("\nrecord:", _GRAPH, 1)
    path.write_text(rig, encoding="utf8")
    return path


@contextmanager
def listening(name, *arguments, environment=None):
    """A program of `live_listeners`, which is ready to listen: receives clouds and odometry, publishes commands."""
    script = str(LISTENERS / f"over_{name}.py")
    options = {"stdout": subprocess.PIPE, "text": True, "env": environment}
    with started(script, *map(str, arguments), **options) as process:
        assert process.stdout.readline() == "ready\n"
        yield process


def heard(process):
    """What a listener says when it has all clouds, or when nothing came for a while."""
    return json.loads(process.stdout.read())


def run_rig(file, out, *options, environment=None):
    """Plays the file in real time for 3.2 s; gives the report."""
    command = [sys.executable, "-m", "graph", "run", str(file), "--realtime", "--duration", "3.2", "--out", str(out)]
    done = subprocess.run([*command, *options], cwd=ROOT, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads((out / "report.json").read_text(encoding="utf8"))


def recorded(out, topic):
    """The CDR bytes of a topic's messages in the recording of a run."""
    with (out / "run.mcap").open("rb") as file:
        return [message.data for _, _, message in make_reader(file).iter_messages(topics=[topic])]


def free_port():
    """A port of this machine that nothing uses."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def digests(messages):
    """The SHA-256 of each message."""
    return [hashlib.sha256(data).hexdigest() for data in messages]
