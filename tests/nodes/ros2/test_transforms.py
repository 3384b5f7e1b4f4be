import math

import pytest

from graph import ComputeError
from graph.testing import run_node

PUBLISH = "ROS2PublishTransformTree"


@pytest.fixture
def robot(stage):
    """A chain base - arm - hand of bodies under /World/Robot (the root), jointed in this order, 1 m apart along x."""
    from pxr import UsdGeom, UsdPhysics

    root = UsdGeom.Xform.Define(stage, "/World/Robot")
    root.AddTranslateOp().Set((0, 0, 5))
    UsdPhysics.ArticulationRootAPI.Apply(root.GetPrim())
    for number, name in enumerate(("hand", "arm", "base")):
        link = UsdGeom.Xform.Define(stage, f"/World/Robot/{name}")
        link.AddTranslateOp().Set((2 - number, 0, 0))
        UsdPhysics.RigidBodyAPI.Apply(link.GetPrim())
    for name, ends in {"wrist": ("arm", "hand"), "elbow": ("base", "arm")}.items():
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/World/Robot/{name}")
        joint.GetBody0Rel().SetTargets([f"/World/Robot/{ends[0]}"])
        joint.GetBody1Rel().SetTargets([f"/World/Robot/{ends[1]}"])
    ground = UsdPhysics.FixedJoint.Define(stage, "/World/Robot/mount")
    ground.GetBody1Rel().SetTargets(["/World/Robot/base"])
    return stage


def edges(stage, parent, *targets):
    from nodes.isaac.transform_trees import edges_of

    return [(one.parent_frame, one.child_frame) for one in edges_of(stage, parent, targets)]


def test_an_articulation_stands_for_its_links_each_on_the_one_that_carries_it(robot):
    assert edges(robot, "", "/World/Robot") == [("world", "base"), ("base", "arm"), ("arm", "hand")]


def test_without_a_mount_the_first_body_is_the_root_link(robot):
    robot.RemovePrim("/World/Robot/mount")
    assert edges(robot, "", "/World/Robot") == [("world", "hand"), ("hand", "arm"), ("arm", "base")]


def test_other_prims_hang_on_the_parent_and_the_parent_itself_is_left_out(robot):
    assert edges(robot, "/World/Robot/base", "/World/Robot/hand", "/World/Robot/base") == [("base", "hand")]


def test_frames_take_the_override_and_prims_of_one_name_their_paths(stage):
    from pxr import Sdf

    for path in ("/World/A/lidar", "/World/B/lidar", "/World/C"):
        stage.DefinePrim(path, "Xform")
    stage.GetPrimAtPath("/World/C").CreateAttribute("isaac:nameOverride", Sdf.ValueTypeNames.String).Set("camera")
    found = edges(stage, "", "/World/A/lidar", "/World/B/lidar", "/World/C")
    assert [child for _, child in found] == ["lidar", "World_B_lidar", "camera"]


def publish(app, updates=1, **inputs):
    return run_node(PUBLISH, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def test_poses_are_relative_metres_and_xyzw(stage, world):
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    parent = UsdGeom.Xform.Define(stage, "/World/Base")
    parent.AddTranslateOp().Set((100, 0, 0))
    parent.AddRotateZOp().Set(90)
    parent.AddScaleOp().Set((2, 2, 2))
    child = UsdGeom.Xform.Define(stage, "/World/Lidar")
    child.AddTranslateOp().Set((100, 300, 50))
    app = world()
    publish(app, parentPrim="/World/Base", targetPrims="/World/Lidar", timeStamp=0.5)
    [message] = app.sink["/tf"]
    [one] = message.message.transforms
    assert (one.header.frame_id, one.child_frame_id) == ("Base", "Lidar")
    assert one.header.stamp.nanosec == 500_000_000
    shift, turn = one.transform.translation, one.transform.rotation
    assert (shift.x, shift.y, shift.z) == pytest.approx((3, 0, 0.5))
    assert (turn.x, turn.y, turn.z, turn.w) == pytest.approx((0, 0, -math.sqrt(0.5), math.sqrt(0.5)))


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
def test_the_frame_of_a_camera_is_optical(stage, world, parity):
    # A USD camera looks along -z with y up, a ROS optical frame has z ahead and y down: half a turn about x between
    # them. What is 2 m ahead of the camera, at z = -2 below it, is at z = +2 of its frame.
    from pxr import UsdGeom

    camera = UsdGeom.Camera.Define(stage, "/World/Eye")
    camera.AddTranslateOp().Set((0, 0, 5))
    ahead = UsdGeom.Xform.Define(stage, "/World/Ahead")
    ahead.AddTranslateOp().Set((0, 1, 3))
    app = world(parity=parity)
    run_node(PUBLISH, inputs={"targetPrims": ["/World/Eye"]}, pulses={"execIn": [0]}, updates=1, app=app)
    inputs = {"targetPrims": ["/World/Ahead"], "parentPrim": ["/World/Eye"], "topicName": "seen"}
    run_node(PUBLISH, inputs=inputs, pulses={"execIn": [0]}, updates=1, app=app)
    [eye] = [one.message.transforms[0].transform for one in app.sink["/tf"]]
    [seen] = [one.message.transforms[0].transform for one in app.sink["/seen"]]
    turn = eye.rotation
    assert [abs(turn.x), turn.y, turn.z, turn.w] == pytest.approx([1, 0, 0, 0])
    assert [eye.translation.x, eye.translation.y, eye.translation.z] == pytest.approx([0, 0, 5])
    assert [seen.translation.x, seen.translation.y, seen.translation.z] == pytest.approx([0, -1, 2])


def test_a_static_tree_is_sent_once_on_tf_static_and_again_when_it_changed(stage, world):
    stage.DefinePrim("/World/Lidar", "Xform")
    app = world()

    def move(update):
        if update == 3:
            import numpy as np

            app.fabric.set_world_matrix("/World/Lidar", np.eye(4) + np.eye(4, k=3))
        return True

    publish(app, updates=6, targetPrims="/World/Lidar", staticPublisher=move)
    assert [len(app.sink[topic]) for topic in ("/tf_static", "/tf")] == [2, 0]


def test_given_frames_are_published_as_they_are(world):
    app = world()
    publish(
        app,
        parentFrames=["map"],
        childFrames=["odom"],
        translations=[[1.0, 2.0, 3.0]],
        orientations=[[0.0, 0.0, 1.0, 0.0]],
    )
    [one] = app.sink["/tf"][0].message.transforms
    assert (one.header.frame_id, one.child_frame_id) == ("map", "odom")
    assert (one.transform.translation.y, one.transform.rotation.z) == (2, 1)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({}, "nothing to publish; set targetPrims"),
        ({"targetPrims": "/World/Gone"}, "there is no prim /World/Gone"),
        ({"targetPrims": "/World/half\ud800"}, "there is no prim /World/half"),
        ({"childFrames": ["a"], "parentFrames": ["b"]}, "have 1, 1, 0, 0 entries; they must agree"),
    ],
)
def test_what_cannot_be_published_is_reported(world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        publish(world(), **inputs)


TREES = """\
tickgraph: 1
clock: {{physics_hz: 60, loop_hz: 60, parity: {parity}}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      a: {{type: ROS2PublishRawTransformTree, inputs: {{childFrameId: a}}}}
      b: {{type: ROS2PublishRawTransformTree, inputs: {{childFrameId: b}}}}
      c: {{type: ROS2PublishRawTransformTree, inputs: {{childFrameId: c, topicName: other}}}}
    connections:
      - tick.tick -> a.execIn
      - tick.tick -> b.execIn
      - tick.tick -> c.execIn
      - time.simulationTime -> c.timeStamp
{stamps}"""


def recorded_frames(folder, *options, parity="documented", stamped="ab"):
    """Topic -> the child frames of each message, of a run of three updates without warm-up steps."""
    from graph.cli.main import main
    from graph.recording.run_reader import open_run

    stamps = "".join(f"      - time.simulationTime -> {one}.timeStamp\n" for one in stamped)
    file = folder / "g.yaml"
    file.write_text(TREES.format(parity=parity, stamps=stamps))
    settings = ["--/tickgraph/warmUpSteps=0", *options]
    assert main(["run", str(file), "--updates", "3", "--out", str(folder / "out"), *settings]) == 0
    found = {}
    with open_run(folder / "out") as run:
        for entry in run.read():
            found.setdefault(entry.topic, []).append([one.child_frame_id for one in entry.load().transforms])
    return found


def test_transforms_of_nodes_that_share_a_topic_are_one_message_per_tick(tmp_path):
    assert recorded_frames(tmp_path) == {"/tf": [["a", "b"]] * 3, "/other": [["c"]] * 3}


def test_the_setting_and_the_profile_keep_each_nodes_message_apart(tmp_path):
    apart = {"/tf": [["a"], ["b"]] * 3, "/other": [["c"]] * 3}
    assert recorded_frames(tmp_path, "--/tickgraph/mergeTransforms=false") == apart
    assert recorded_frames(tmp_path, parity="isaacsim-6.0.1") == apart


def test_transforms_of_another_stamp_stay_apart(tmp_path):
    # b has the constant stamp 0.
    frames = recorded_frames(tmp_path, stamped="a")["/tf"]
    assert frames == [["a"], ["b"]] * 3


def test_transforms_of_another_quality_stay_apart(world):
    from graph.sim.messages.message import DEFAULT, Quality

    app = world()
    for name, quality in (("a", DEFAULT), ("b", Quality(depth=1)), ("c", DEFAULT)):
        app.bus.gather("/tf", "tf2_msgs/msg/TFMessage", [name], tuple, 5, quality)
    app.bus.release()
    assert [one.message for one in app.sink["/tf"]] == [("a", "c"), ("b",)]


def test_a_subscriber_in_the_graph_gets_every_message_at_once(world):
    from graph.sim.messages.message import DEFAULT
    from nodes.ros2.messages import TRANSFORMS, transforms

    app = world()
    heard = app.bus.listen("/tf", TRANSFORMS)
    app.bus.gather("/tf", TRANSFORMS, transforms([], 5).transforms, lambda parts: parts, 5, DEFAULT)
    assert len(heard) == 1


def test_what_is_gathered_when_the_app_closes_is_not_lost(world):
    from graph.sim.messages.message import DEFAULT

    app = world()
    app.bus.gather("/tf", "tf2_msgs/msg/TFMessage", ["one"], tuple, 5, DEFAULT)
    app.bus.gather("/tf", "tf2_msgs/msg/TFMessage", ["two"], tuple, 5, DEFAULT)
    app.close()
    assert [one.message for one in app.sink["/tf"]] == [("one", "two")]
