"""A frame that two publishers hang on different parents, as run and explain tell it."""

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
