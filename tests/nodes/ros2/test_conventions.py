"""ROS's conventions, clause by clause, on what a run publishes: REP-103, 105, 117 and 118.

A wall's front face lies 4.5 m ahead of a lidar and a camera and reaches from 0.5 to 1.5 m to their left; of its other
faces they see the right one, 0.5 m to the left. Nothing else is ahead. A body slides along its own x axis, which points
along the world's y axis; gravity is too small to matter.
"""

import numpy as np
import pytest

from graph.sim import App
from graph.sim.messages.bus import MemorySink

GRAPH = """
tickgraph: 1
scene:
  prims:
    /World/Physics: {type: PhysicsScene, attributes: {physics:gravityMagnitude: 1.0e-6}}
    /World/Wall:   {type: Cube, size: 1.0, translate: [5, 1, 1]}
    /World/Lidar:  {type: OmniLidar, config: Example_Rotary_2D, translate: [0, 0, 1]}
    /World/Camera: {type: Camera, translate: [0, 0, 1], rotate: [90, 0, -90]}
    /World/Base:
      {type: Cube, size: 0.2, translate: [-5, 0, 3], rotate: [0, 0, 90], rigid_body: true, mass: 1.0,
       velocity: [0, 1, 0], angular_velocity: [0, 0, 30]}
clock: {physics_hz: 60, loop_hz: 60}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      once: Once
      time: IsaacReadSimulationTime
      turns: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      scan: {type: ROS2RtxLidarHelper, inputs: {type: laser_scan, topicName: scan, frameId: lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points, frameId: lidar}}
      images: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Camera, width: 65, height: 49}}
      depth: {type: ROS2CameraHelper, inputs: {type: depth, topicName: depth, frameId: camera}}
      seen: {type: ROS2CameraHelper, inputs: {type: depth_pcl, topicName: seen, frameId: camera}}
      info: {type: ROS2CameraInfoHelper, inputs: {topicName: camera_info, frameId: camera}}
      frames: {type: ROS2PublishTransformTree, inputs: {targetPrims: [/World/Base, /World/Camera]}}
      odometry: {type: IsaacComputeOdometry, inputs: {chassisPrim: /World/Base}}
      publish: {type: ROS2PublishOdometry}
    connections:
      - tick.tick -> [once.execIn, frames.execIn, odometry.execIn]
      - once.once -> turns.execIn
      - turns.execOut -> [scan.execIn, cloud.execIn, images.execIn]
      - turns.renderProductPath -> [scan.renderProductPath, cloud.renderProductPath]
      - images.execOut -> [depth.execIn, seen.execIn, info.execIn]
      - images.renderProductPath -> [depth.renderProductPath, seen.renderProductPath, info.renderProductPath]
      - odometry.execOut -> publish.execIn
      - odometry.position -> publish.position
      - odometry.orientation -> publish.orientation
      - odometry.linearVelocity -> publish.linearVelocity
      - odometry.angularVelocity -> publish.angularVelocity
      - time.simulationTime -> [publish.timeStamp, frames.timeStamp]
"""


@pytest.fixture(scope="module")
def heard(tmp_path_factory):
    """The last message of each topic after 12 updates."""
    path = tmp_path_factory.mktemp("graph") / "graph.yaml"
    path.write_text(GRAPH)
    with App.from_file(path) as app:
        sink = MemorySink()
        app.bus.subscribe(sink)
        app.play()
        app.update(12)
        topics = ("/scan", "/points", "/depth", "/seen", "/camera_info", "/tf", "/odom")
        return {topic: sink[topic][-1].message for topic in topics}


def points(message):
    """(n, 3) x, y, z of a cloud of float32."""
    rows = np.frombuffer(np.asarray(message.data, np.uint8).tobytes(), np.uint8).reshape(-1, message.point_step)
    offsets = {one.name: one.offset for one in message.fields}
    return np.stack([rows[:, offsets[name] :][:, :4].copy().view("<f4")[:, 0] for name in "xyz"], axis=1)


def test_rep_103_a_body_frame_is_metres_with_x_forward_y_left_z_up(heard):
    found = points(heard["/points"])
    face = found[np.abs(found[:, 0] - 4.5) < 1e-4]
    assert len(face) > 50
    assert 0.5 <= face[:, 1].min() < face[:, 1].max() <= 1.5
    np.testing.assert_allclose(face[:, 2], 0, atol=1e-5)


def test_rep_103_an_optical_frame_has_z_forward_x_right_y_down(heard):
    found = points(heard["/seen"])
    face = found[np.isfinite(found).all(axis=1)]
    front = np.abs(face[:, 2] - 4.5) < 1e-4
    assert front.sum() > 100
    np.testing.assert_allclose(face[~front, 0], -0.5, atol=1e-4)  # the right face
    assert -1.5 <= face[front, 0].min() < face[front, 0].max() <= -0.5 + 1e-4
    assert -0.5 <= face[:, 1].min() < 0 < face[:, 1].max() <= 0.5


def test_rep_103_rotations_are_unit_quaternions_counted_counterclockwise(heard):
    (turn,) = (one.transform.rotation for one in heard["/tf"].transforms if one.child_frame_id == "Base")
    assert turn.x**2 + turn.y**2 + turn.z**2 + turn.w**2 == pytest.approx(1, abs=1e-9)
    yaw = 2 * np.arctan2(turn.z, turn.w)
    assert np.degrees(yaw) == pytest.approx(90 + 30 * 12 / 60, abs=0.01)  # left, as x turns towards y


def test_rep_103_the_frame_of_a_camera_in_tf_is_the_optical_one(heard):
    (turn,) = (one.transform.rotation for one in heard["/tf"].transforms if one.child_frame_id == "Camera")
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    forward = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]  # the frame's z axis
    np.testing.assert_allclose(forward, [1, 0, 0], atol=1e-6)
    assert heard["/camera_info"].header.frame_id == "camera"


def test_rep_105_odometry_is_the_pose_of_the_base_in_odom_and_the_speed_in_the_base(heard):
    message = heard["/odom"]
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
    # odom is the base's pose at the first of the 12 updates, when it had turned by half a degree
    moved = 11 / 60
    assert message.pose.pose.position.x == pytest.approx(moved * np.cos(np.radians(0.5)), abs=1e-4)
    assert message.pose.pose.position.y == pytest.approx(-moved * np.sin(np.radians(0.5)), abs=1e-4)
    turned = np.radians(30 * 12 / 60)
    speed = message.twist.twist.linear
    assert (speed.x, speed.y) == pytest.approx((np.cos(turned), -np.sin(turned)), abs=1e-3)
    assert message.twist.twist.angular.z == pytest.approx(np.radians(30), abs=1e-4)


def test_rep_105_a_frame_has_one_parent_and_the_tree_one_root(heard):
    edges = [(one.header.frame_id, one.child_frame_id) for one in heard["/tf"].transforms]
    children = [child for _, child in edges]
    assert len(children) == len(set(children))
    assert {parent for parent, _ in edges} - set(children) == {"world"}


def test_rep_117_a_beam_without_a_return_is_infinite_and_none_is_not_a_number(heard):
    message = heard["/scan"]
    ranges = np.asarray(message.ranges)
    angles = message.angle_min + np.arange(len(ranges)) * message.angle_increment
    on_wall = np.isfinite(ranges)
    assert np.isposinf(ranges[~on_wall]).all()
    assert ((ranges[on_wall] >= message.range_min) & (ranges[on_wall] <= message.range_max)).all()
    expected = 4.5 / np.cos(angles[on_wall])
    front = np.abs(expected * np.sin(angles[on_wall]) - 1) < 0.49  # the face, not its edges and its side
    np.testing.assert_allclose(ranges[on_wall][front], expected[front], rtol=1e-5)


def test_rep_118_depth_is_float32_metres_along_the_axis_with_infinity_beyond(heard):
    message = heard["/depth"]
    assert (message.encoding, message.step, message.is_bigendian) == ("32FC1", 65 * 4, 0)
    depth = np.asarray(message.data, np.uint8).view("<f4").reshape(49, 65)
    seen = np.isfinite(depth)
    assert np.count_nonzero(np.abs(depth[seen] - 4.5) < 1e-4) > 100
    assert ((depth[seen] > 4.4999) & (depth[seen] < 5.5001)).all()  # the front and the right face
    assert np.isposinf(depth[~seen]).all()
    rows, columns = np.nonzero(seen)
    assert columns.max() < 32  # left of the middle
    assert (rows.min() + rows.max()) / 2 == 24


def test_rep_118_depth_and_camera_info_share_stamp_frame_and_size(heard):
    depth, info = heard["/depth"], heard["/camera_info"]
    assert depth.header == info.header
    assert (depth.width, depth.height) == (info.width, info.height)
    np.testing.assert_allclose(info.k[2], 65 / 2)
