"""A frame that two publishers hang on different parents, as run and explain tell it."""

import json

import pytest

HEAD = """\
tickgraph: 1
scene:
  prims:
    /World/Robot: {type: Cube, rigid_body: true}
    /World/Dock: {type: Cube}
clock: {physics_hz: 60, loop_hz: 60}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      odom: {type: ROS2PublishRawTransformTree, inputs: {parentFrameId: odom, childFrameId: Robot}}
"""
CONNECTIONS = "    connections: [tick.tick -> odom.execIn, tick.tick -> tree.execIn]\n"
TREE = "      tree: {type: ROS2PublishTransformTree, inputs: {targetPrims: [%s]%s}}\n"
SAID = (
    'frame "Robot" hangs on "odom" and on "world" (published by %s); a tree of frames takes one parent: '
    "leave it out of one of them, or rename it (isaac:nameOverride)"
)
BOTH = "/World/G/odom, /World/G/tree"


@pytest.mark.parametrize(
    ("target", "more", "where"),
    [
        ("/World/Robot", "", "/tf"),
        ("/World/Robot", ", staticPublisher: true", "/tf and /tf_static"),
        ("/World/Dock", "", None),
        ("/World/Robot", ", topicName: other/tf", None),
    ],
    ids=["one topic", "moving and static", "another frame", "another tree"],
)
def test_a_frame_with_two_parents_is_reported_once(folder, graph, target, more, where):
    (folder / "a.yaml").write_text(HEAD + TREE % (target, more) + CONNECTIONS)
    told = [line for line in graph("run", "a.yaml", "--updates", "5").err.splitlines() if "tf-two-parents" in line]
    assert told == ([f"warning tf-two-parents: {where}: {SAID % BOTH}"] if where else [])
    traps = [line for line in graph("explain", "a.yaml").out.splitlines() if "tf-two-parents" in line]
    assert traps == ([f"  tf-two-parents: {where}: {SAID % BOTH}"] if where else [])


LOST = """tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 2.0, translate: [6, 0, 1]}
    /World/Lidar: {type: OmniLidar, config: OS1, translate: [0, 0, 1]}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      tf: {type: ROS2PublishTransformTree, inputs: {targetPrims: [/World/Lidar]}}
      made: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      sent: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points, frameId: NAME}}
    connections:
      - tick.tick -> [made.execIn, tf.execIn]
      - time.simulationTime -> tf.timeStamp
      - made.execOut -> sent.execIn
      - made.renderProductPath -> sent.renderProductPath
"""


@pytest.mark.parametrize("command", ["check", "explain", "run"])
def test_a_frame_that_no_transform_places_is_named(graph, folder, command):
    """The prim is called Lidar; TF names are case-sensitive. Without any TF, another program may publish it."""

    def unplaced(text):
        (folder / "lost.yaml").write_text(text)
        report = json.loads(graph(command, "lost.yaml", *(["--updates", 12] if command == "run" else []), "--json").out)
        found = report["files"][0]["warnings"] if command == "check" else report.get("traps", report.get("warnings"))
        return [one for one in found if one["code"] == "frame-unpublished"]

    (warning,) = unplaced(LOST.replace("NAME", "lidar"))
    assert warning["where"] == "/points"
    assert warning["message"].startswith(
        'its messages (of /G/sent) name the frame "lidar", which no published transform'
    )
    assert 'did you mean "Lidar"?' in warning["message"]
    assert unplaced(LOST.replace("NAME", "Lidar")) == []
    assert (
        unplaced(
            LOST.replace("NAME", "lidar").replace("tick.tick -> [made.execIn, tf.execIn]", "tick.tick -> made.execIn")
        )
        == []
    )
