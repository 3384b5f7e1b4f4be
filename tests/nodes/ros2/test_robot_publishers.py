"""Joint states, odometry, single transforms, inertial readings, steering."""

import math

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from tests.support.fixed_robots import define_base, define_joint


def once(kind, app, **inputs):
    run_node(kind, inputs=inputs, pulses={"execIn": [0]}, app=app)


@pytest.fixture
def slider(stage, world):
    """A world in centimetres with a fixed base, a wheel on a hinge (y) and a block on a slide (x)."""
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    define_base(stage, "/Robot", size=10)
    alike = {"stiffness": 1000.0, "damping": 100.0, "size": 10}
    define_joint(stage, "/Robot", "hinge", "hinge_link", (0, 100, 0), targetPosition=math.degrees(0.5), **alike)
    define_joint(stage, "/Robot", "slide", "slide_link", (0, -100, 0), "X", "linear", targetPosition=20.0, **alike)
    return world(physics_hz=240)


def test_a_robots_joints_are_published_in_rad_and_metres(slider, plain):
    run_node("ROS2PublishJointState", inputs={"targetPrim": "/Robot", "timeStamp": 3.25},
             pulses={"execIn": [240]}, updates=241, app=slider)  # fmt: skip
    [message] = plain(slider, "/joint_states")
    joints = dict(zip(message["name"], zip(message["position"], message["velocity"], strict=True), strict=True))
    assert message["header"] == {"stamp": {"sec": 3, "nanosec": 250_000_000}, "frame_id": ""}
    assert joints["hinge"][0] == pytest.approx(0.5, abs=0.02)
    assert joints["slide"][0] == pytest.approx(0.2, abs=0.005)
    assert len(message["effort"]) == 2


def test_given_joints_are_published_as_they_are(world, plain):
    app = world()
    once("ROS2PublishJointState", app, jointNames=["a", "b"], jointPositions=[1, 2], jointEfforts=[3, 4])
    [message] = plain(app, "/joint_states")
    assert [message[key] for key in ("name", "position", "velocity", "effort")] == [["a", "b"], [1, 2], [], [3, 4]]


def test_given_joints_that_slide_are_scaled_to_metres(world, plain):
    app = world()
    once("ROS2PublishJointState", app, jointNames=["a", "b"], jointPositions=[1, 20], jointVelocities=[3, 40],
         jointEfforts=[5, 6], jointDofTypes=[0, 1], stageMetersPerUnit=0.01)  # fmt: skip
    [message] = plain(app, "/joint_states")
    assert message["position"] == [1, 0.2]
    assert message["velocity"] == [3, 0.4]
    assert message["effort"] == [5, 6]


def test_the_sensors_time_is_the_stamp_where_no_time_is_given(world, plain):
    app = world()
    once("ROS2PublishJointState", app, jointNames=["a"], sensorTime=1.5)
    once("ROS2PublishJointState", app, jointNames=["a"], sensorTime=1.5, timeStamp=2.0)
    stamps = [message["header"]["stamp"] for message in plain(app, "/joint_states")]
    assert stamps == [{"sec": 1, "nanosec": 500_000_000}, {"sec": 2, "nanosec": 0}]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({}, "nothing to publish; set targetPrim"),
        ({"targetPrim": "/Nobody"}, "there is no prim /Nobody on the stage; correct the path"),
        ({"jointNames": ["a"], "jointPositions": [1, 2]}, "jointPositions has 2 values for 1 joints"),
        ({"jointNames": ["a", "b"], "jointDofTypes": [1]}, "jointDofTypes has 1 values for 2 joints"),
    ],
)
def test_joints_that_do_not_add_up_stop_the_run(world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        once("ROS2PublishJointState", world(), **inputs)


def test_odometry_has_pose_and_twist_in_their_frames(world, plain):
    app = world()
    once("ROS2PublishOdometry", app, position=[1, 2, 3], orientation=[0, 0, 0.6, 0.8], linearVelocity=[1, 2, 3],
         angularVelocity=[4, 5, 6], timeStamp=1.0)  # fmt: skip
    [message] = plain(app, "/odom")
    assert (message["header"]["frame_id"], message["child_frame_id"]) == ("odom", "base_link")
    assert message["pose"]["pose"] == {
        "position": {"x": 1, "y": 2, "z": 3}, "orientation": {"x": 0, "y": 0, "z": 0.6, "w": 0.8},
    }  # fmt: skip
    assert message["twist"]["twist"] == {"linear": {"x": 1, "y": 2, "z": 3}, "angular": {"x": 4, "y": 5, "z": 6}}
    assert message["pose"]["covariance"] == message["twist"]["covariance"] == [0.0] * 36


@pytest.mark.parametrize(
    ("inputs", "linear"),
    [
        ({"robotFront": [0, 2, 0]}, [2, -1, 3]),  # the front is +y, so left is -x
        ({"robotFront": [-1, 0, 0]}, [-1, -2, 3]),
        ({"robotFront": [-1, 0, 0], "publishRawVelocities": True}, [1, 2, 3]),
    ],
)
def test_velocities_are_published_along_front_left_and_up(world, plain, inputs, linear):
    app = world()
    once("ROS2PublishOdometry", app, linearVelocity=[1, 2, 3], **inputs)
    found = plain(app, "/odom")[0]["twist"]["twist"]["linear"]
    assert [found[axis] for axis in "xyz"] == pytest.approx(linear)


def test_a_front_that_points_up_is_refused(world):
    with pytest.raises(ComputeError, match="is zero or points up"):
        once("ROS2PublishOdometry", world(), robotFront=[0, 0, 1])


def test_a_raw_transform_is_published_as_given(world, plain):
    app = world()
    once("ROS2PublishRawTransformTree", app, translation=[1, 2, 3], rotation=[0, 0, 1, 0], childFrameId="base")
    [message] = plain(app, "/tf")
    [transform] = message["transforms"]
    assert (transform["header"]["frame_id"], transform["child_frame_id"]) == ("odom", "base")
    assert transform["transform"] == {
        "translation": {"x": 1, "y": 2, "z": 3}, "rotation": {"x": 0, "y": 0, "z": 1, "w": 0},
    }  # fmt: skip


def test_a_static_transform_is_published_when_it_changes_on_its_own_topic(world, plain):
    app = world()
    inputs = {"staticPublisher": True, "translation": lambda update: [update // 3, 0, 0]}
    run_node("ROS2PublishRawTransformTree", inputs=inputs, pulses={"execIn": range(6)}, updates=6, app=app)
    moved = [message["transforms"][0]["transform"]["translation"]["x"] for message in plain(app, "/tf_static")]
    assert moved == [0, 1]
    assert plain(app, "/tf") == []


def test_an_imu_marks_what_it_does_not_measure(world, plain):
    app = world()
    readings = {"orientation": [0, 0, 0.6, 0.8], "angularVelocity": [1, 2, 3], "linearAcceleration": [0, 0, 9.81]}
    once("ROS2PublishImu", app, **readings)
    once("ROS2PublishImu", app, **readings, publishOrientation=False, publishAngularVelocity=False)
    full, part = plain(app, "/imu")
    assert full["header"]["frame_id"] == "sim_imu"
    assert full["orientation"] == {"x": 0, "y": 0, "z": 0.6, "w": 0.8}
    assert full["angular_velocity"] == {"x": 1, "y": 2, "z": 3}
    assert full["linear_acceleration"] == part["linear_acceleration"] == {"x": 0, "y": 0, "z": 9.81}
    covariances = [f"{name}_covariance" for name in ("orientation", "angular_velocity", "linear_acceleration")]
    assert [full[name][0] for name in covariances] == [0, 0, 0]
    assert [part[name][0] for name in covariances] == [-1, -1, 0]


def test_ackermann_commands_go_out(world, plain):
    app = world()
    once("ROS2PublishAckermannDrive", app, steeringAngle=0.25, steeringAngleVelocity=0.5, speed=2, acceleration=1,
         jerk=4, frameId="base", timeStamp=2.5)  # fmt: skip
    [message] = plain(app, "/ackermann_cmd")
    assert message["header"] == {"stamp": {"sec": 2, "nanosec": 500_000_000}, "frame_id": "base"}
    assert message["drive"] == {
        "steering_angle": 0.25, "steering_angle_velocity": 0.5, "speed": 2, "acceleration": 1, "jerk": 4,
    }  # fmt: skip


@pytest.mark.parametrize(
    "kind", ["JointState", "Odometry", "RawTransformTree", "Imu", "AckermannDrive", "Image", "CompressedImage",
             "CameraInfo", "SemanticLabels", "ObjectIdMap"],
)  # fmt: skip
def test_publishers_do_nothing_without_a_subscriber(stage, kind):
    """Not even look at their inputs, which are wrong for some here."""
    from graph.sim import App

    with App(stage) as app:
        once(f"ROS2Publish{kind}", app)
        [topic] = app.bus.topics.values()
        assert topic.messages == 0


def test_messages_are_recorded_and_read_back(world, tmp_path):
    from graph.recording.mcap_sink import McapSink
    from graph.recording.mcap_source import McapSource

    app = world()
    sink = McapSink(tmp_path / "run.mcap")
    app.bus.subscribe(sink)
    once("ROS2PublishAckermannDrive", app, speed=2.0)
    once("ROS2PublishOdometry", app, position=[1, 0, 0])
    sink.close()
    drive, odometry = (entry.load() for entry in McapSource(tmp_path / "run.mcap"))
    assert drive.drive.speed == 2
    assert odometry.pose.pose.position.x == 1
    assert np.array_equal(odometry.pose.covariance, np.zeros(36))
