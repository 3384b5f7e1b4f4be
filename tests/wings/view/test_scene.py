"""`graph view`: what is drawn together, in which place, by which quantity and with which unit."""

import numpy as np
import pytest

from graph.recording.contents.clouds import points_of
from graph.recording.contents.poses import TransformLog
from graph.recording.contents.scans import Scan
from graph.sim.messages.ros_types import message_type
from wings.view.clouds import CloudPanel
from wings.view.collecting import Collected
from wings.view.frames import boxes, frames, lens
from wings.view.scene import cloud_groups, scene
from wings.view.values import Series

HALF = 0.5**0.5


def ros(name, *values):
    return message_type(name)(*values)


def stamp(seconds=0.0):
    return ros("builtin_interfaces/msg/Time", int(seconds), round(seconds % 1 * 1e9))


def header(frame, seconds=0.0):
    return ros("std_msgs/msg/Header", stamp(seconds), frame)


def pose(place, turn=(0.0, 0.0, 0.0, 1.0)):
    return ros("geometry_msgs/msg/Point", *place), ros("geometry_msgs/msg/Quaternion", *turn)


def moved(parent, child, place, turn=(0.0, 0.0, 0.0, 1.0), seconds=0.0):
    """A TFMessage of one transform."""
    shift = ros("geometry_msgs/msg/Vector3", *place)
    whole = ros("geometry_msgs/msg/Transform", shift, ros("geometry_msgs/msg/Quaternion", *turn))
    return ros(
        "tf2_msgs/msg/TFMessage", [ros("geometry_msgs/msg/TransformStamped", header(parent, seconds), child, whole)]
    )


@pytest.fixture
def log():
    """A robot that goes 2 m along x in a second, turned 90 deg to the left; its camera is 1 m ahead of it."""
    log = TransformLog()
    for seconds in (0.0, 1.0):
        log.add(moved("world", "robot", (2 * seconds, 0.0, 0.0), (0.0, 0.0, HALF, HALF), seconds), "/tf")
    log.add(moved("robot", "camera", (1.0, 0.0, 0.5)), "/tf_static")
    return log


def cloud(points, topic, frame, pose=None):
    """A panel with one frame of these points (n, 3) in the sensor's frame."""
    packed = np.zeros(len(points), [(axis, "<f4") for axis in "xyz"])
    packed["x"], packed["y"], packed["z"] = np.transpose(points)
    panel = CloudPanel(topic)
    panel.add(Scan(topic, 0, 0, frame, packed, pose, None, None), "world", 1000)
    return panel


def test_frames_are_sampled_in_the_root_of_their_tree(log):
    robot, camera = frames(log)
    assert (robot["name"], robot["parent"], robot["root"], robot["moves"]) == ("robot", "world", "world", True)
    assert (camera["parent"], camera["root"], camera["moves"]) == ("robot", "world", True)
    assert (robot["t"][0], robot["t"][-1]) == (0.0, 1.0)
    assert robot["places"][-1] == [2.0, 0.0, 0.0]
    assert camera["places"][-1] == pytest.approx([2.0, 1.0, 0.5])  # ahead of the robot is +y of the world
    assert camera["turns"][0] == pytest.approx([0.0, 0.0, HALF, HALF], abs=1e-5)


def test_boxes_are_placed_by_their_frame(log):
    """A box of 2 x 4 x 6 m, 3 m ahead of the camera: about (0, 4, 0.5) of the world at t = 0, 4 m wide along x."""
    place, turn = pose((3.0, 0.0, 0.0))
    hypothesis = ros("vision_msgs/msg/ObjectHypothesis", "7", 1.0)
    nowhere = ros("geometry_msgs/msg/Pose", *pose((0.0, 0.0, 0.0)))
    result = ros(
        "vision_msgs/msg/ObjectHypothesisWithPose",
        hypothesis,
        ros("geometry_msgs/msg/PoseWithCovariance", nowhere, np.zeros(36)),
    )
    size = ros("geometry_msgs/msg/Vector3", 2.0, 4.0, 6.0)
    box = ros("vision_msgs/msg/BoundingBox3D", ros("geometry_msgs/msg/Pose", place, turn), size)
    one = ros("vision_msgs/msg/Detection3D", header("camera"), [result], box, "")
    found = boxes(ros("vision_msgs/msg/Detection3DArray", header("camera"), [one]), 0, log)
    assert (found["root"], found["labels"]) == ("world", ["7"])
    corners = np.array(found["corners"][0])
    assert corners.min(axis=0) == pytest.approx([-2.0, 3.0, -2.5])
    assert corners.max(axis=0) == pytest.approx([2.0, 5.0, 3.5])


def test_a_lens_gives_the_directions_to_the_corners_of_its_image():
    """200 x 100 pixels with a focal length of 100: the corners are at x = -1, 1 and y = -0.5, 0.5 of z = 1."""
    region = ros("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
    k = np.array([100.0, 0, 100, 0, 100, 50, 0, 0, 1])

    def info(k):
        zeros = np.zeros(0), k, np.zeros(9), np.zeros(12)
        return ros("sensor_msgs/msg/CameraInfo", header("camera"), 100, 200, "plumb_bob", *zeros, 0, 0, region)

    assert lens(info(k)) == {
        "frame": "camera",
        "rays": [[-1.0, -0.5, 1.0], [1.0, -0.5, 1.0], [1.0, 0.5, 1.0], [-1.0, 0.5, 1.0]],
    }
    assert lens(info(np.zeros(9))) is None


def test_topics_of_one_sensor_share_a_panel():
    """Two topics of a prim, and one in the same frame of which the recording does not name the prim."""
    flat = [(1.0, 0.0, 0.0), (0.0, 2.0, 0.0)]
    found = Collected()
    for topic, frame in (("/points", "front"), ("/scan", "front"), ("/extracted", "front"), ("/top", "top")):
        found.clouds[topic] = cloud(flat if frame == "front" else [*flat, (1.0, 0.0, 1.0)], topic, frame)
    front, top = cloud_groups(found, {"/points": "/World/Front", "/scan": "/World/Front", "/top": "/World/Top"})
    assert (front["name"], front["topics"], front["flat"]) == ("front", ["/points", "/scan", "/extracted"], True)
    assert (top["topics"], top["flat"]) == (["/top"], False)  # 45 deg up is not in the plane
    assert "local" in found.clouds["/scan"].data()["frames"][0]


def test_a_cloud_in_a_frame_of_two_sensors_is_of_neither():
    found = Collected(clouds={topic: cloud([(1.0, 0.0, 0.0)], topic, "lidar") for topic in ("/a", "/b", "/c")})
    groups = cloud_groups(found, {"/a": "/World/A", "/b": "/World/B"})
    assert [group["topics"] for group in groups] == [["/a"], ["/b"], ["/c"]]


def test_the_scene_is_in_the_frame_of_most_and_follows_what_carries_most(log):
    found = Collected(poses=list(frames(log)))
    found.clouds["/points"] = cloud([(1.0, 0.0, 0.0), (9.0, 0.0, 0.0)], "/points", "camera", np.eye(4))
    found.clouds["/elsewhere"] = cloud([(100.0, 0.0, 0.0)], "/elsewhere", "drone")
    shown = scene(found, [0, 1])
    assert (shown["root"], shown["clouds"], shown["base"]) == ("world", [0], "robot")
    assert shown["reach"] == pytest.approx(1.25**0.5)  # from the robot to its camera
    assert shown["high"][0] < 20
    assert scene(Collected(), []) is None


def test_numbers_are_drawn_by_quantity_with_its_unit():
    """An imu turned 90 deg about z, which turns by 0.5 rad/s and feels 9.81 m/s^2 upwards."""
    vector, none = "geometry_msgs/msg/Vector3", np.zeros(9)
    turn = ros("geometry_msgs/msg/Quaternion", 0.0, 0.0, HALF, HALF)
    imu = ros(
        "sensor_msgs/msg/Imu",
        *(header("imu"), turn, none, ros(vector, 0.0, 0.0, 0.5), none, ros(vector, 0.0, 0.0, 9.81), none),
    )
    series = Series("/imu")
    series.add(0, "sensor_msgs/msg/Imu", imu)
    data = series.data()
    assert data["holds"] is False
    assert [(one["name"], one["unit"], [line["name"] for line in one["lines"]]) for one in data["quantities"]] == [
        ("orientation: roll, pitch, yaw", "°", ["yaw"]),
        ("angular_velocity", "rad/s", ["z"]),
        ("linear_acceleration", "m/s²", ["z"]),
    ]
    assert data["quantities"][0]["lines"][0]["y"] == pytest.approx([90.0])


@pytest.mark.parametrize(
    ("topic", "type_name", "holds"),
    [
        ("/cmd_vel", "geometry_msgs/msg/Twist", True),
        ("/drive", "ackermann_msgs/msg/AckermannDriveStamped", True),
        ("/joint_command", "sensor_msgs/msg/JointState", True),
        ("/joint_states", "sensor_msgs/msg/JointState", False),
        ("/odom", "nav_msgs/msg/Odometry", False),
    ],
)
def test_commands_hold_until_the_next_and_samples_do_not(topic, type_name, holds):
    assert Series(topic, type_name).data()["holds"] is holds


def test_a_value_that_comes_later_or_is_not_finite_leaves_a_gap():
    empty = np.zeros(0)
    series = Series("/joint_states")
    for names, speeds in (([], empty), (["hip"], np.array([np.inf])), (["hip"], np.array([2.0]))):
        message = ros("sensor_msgs/msg/JointState", header(""), names, empty, speeds, empty)
        series.add(0, "sensor_msgs/msg/JointState", message)
    (quantity,) = series.data()["quantities"]
    assert quantity["lines"] == [{"name": "hip", "y": [None, None, 2.0]}]


def test_a_scan_is_read_as_flat_points():
    """Two beams of a scan, at 0 and 90 deg; the third has no return."""
    scan = ros(
        "sensor_msgs/msg/LaserScan",
        *(header("front"), 0.0, 3.0, np.pi / 2, 0.0, 0.1, 0.1, 10.0),
        *(np.array([1.0, 2.0, np.inf], np.float32), np.zeros(0, np.float32)),
    )
    points = points_of(scan, "sensor_msgs/msg/LaserScan")
    assert np.stack([points["x"], points["y"]], 1) == pytest.approx(np.array([[1, 0], [0, 2]]), abs=1e-6)
    assert cloud(np.stack([points["x"], points["y"], points["z"]], 1), "/scan", "front").is_flat()


def test_a_recording_without_a_box_or_a_place_has_no_scene():
    empty = {"t": 0.0, "root": "world", "corners": [], "labels": []}
    assert scene(Collected(boxes={"/boxes": [empty]}), []) is None


def test_frames_whose_parents_form_a_ring_have_a_scene():
    log = TransformLog()
    for seconds in (0.0, 1.0):
        for parent, child in (("a", "b"), ("b", "c"), ("c", "a")):
            log.add(moved(parent, child, (seconds, 0.0, 0.0), seconds=seconds), "/tf")
    found = Collected(poses=list(frames(log)))
    whole = scene(found, [])
    assert whole is None or whole["low"] < whole["high"]
