"""The usual drive graph, driven by messages from a file: commands in, wheels turn, joint states out."""

import math

import pytest

from graph.recording.mcap_sink import McapSink
from graph.session.message_sources import open_sources, play_into
from graph.sim import App
from graph.sim.messages.bus import MemorySink
from tests.support.fixed_robots import define_cart

GRAPH = """\
tickgraph: 1
scene: {usd: cart.usda}
clock: {physics_hz: 240, loop_hz: 60}
graphs:
  /World/Drive:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      twist: ROS2SubscribeTwist
      linear: BreakVector3
      angular: BreakVector3
      drive: {type: DifferentialController, inputs: {wheelRadius: 0.5, wheelDistance: 2.0}}
      wheels:
        type: IsaacArticulationController
        inputs: {targetPrim: /World/Cart, jointNames: [left_joint, right_joint]}
      joints: {type: ROS2PublishJointState, inputs: {targetPrim: /World/Cart}}
    connections:
      - tick.tick -> [twist.execIn, drive.execIn, wheels.execIn, joints.execIn]
      - twist.linearVelocity -> linear.tuple
      - twist.angularVelocity -> angular.tuple
      - linear.x -> drive.linearVelocity
      - angular.z -> drive.angularVelocity
      - drive.velocityCommand -> wheels.velocityCommand
      - time.simulationTime -> joints.timeStamp
"""
COMMANDS = """\
- {at: 0.1, topic: /cmd_vel, type: geometry_msgs/msg/Twist, message: {linear: {x: 1.0}}}
- {at: 1.0, topic: /cmd_vel, message: {angular: {z: 0.5}}}
"""


@pytest.fixture
def folder(tmp_path):
    """The graph, its commands and the cart, whose wheels follow without lag."""
    from graph.sim import register_schemas

    register_schemas()
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(tmp_path / "cart.usda"))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    define_cart(stage, damping=math.radians(1000.0))
    stage.Save()
    (tmp_path / "drive.yaml").write_text(GRAPH)
    (tmp_path / "commands.yaml").write_text(COMMANDS)
    return tmp_path


def run(folder, source, recording):
    """Two seconds; the joint states as (time, left speed, right speed)."""
    with App.from_file(folder / "drive.yaml") as app:
        sink, file = MemorySink(), McapSink(folder / recording)
        app.bus.subscribe(sink)
        app.bus.subscribe(file)
        play_into(app, open_sources([folder / source]))
        app.play()
        app.update(120)
    found = []
    for one in sink["/joint_states"]:
        speed = dict(zip(one.message.name, one.message.velocity, strict=True))
        found.append((one.stamp_ns, speed["left_joint"], speed["right_joint"]))
    return found


def test_commands_turn_the_wheels_from_their_time_on(folder):
    states = run(folder, "commands.yaml", "run.mcap")
    assert len(states) == 120
    # 0.1 s is the end of update 5; its command reaches the wheels in update 5, the joints move from update 6 on.
    assert [max(abs(left), abs(right)) < 1e-9 for _, left, right in states[:7]] == [True] * 6 + [False]
    assert states[58][1:] == pytest.approx((2, 2), rel=0.02)  # v / r
    assert states[119][1:] == pytest.approx((-1, 1), rel=0.02)  # w d / (2 r)


def test_a_recording_of_a_run_drives_the_same_run_again(folder):
    first = run(folder, "commands.yaml", "first.mcap")
    # The recording holds joint states too: nobody listens to those.
    assert run(folder, "first.mcap", "second.mcap") == first
    assert (folder / "second.mcap").read_bytes() == (folder / "first.mcap").read_bytes()
