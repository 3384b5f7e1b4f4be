"""UCX nodes: the ROS 2 messages on topics named by port and tag."""

import pytest

from graph.sim.messages.ros_fields import from_plain, to_plain
from graph.testing import run_node

JOINTS = "sensor_msgs/msg/JointState"


def once(kind, app, **inputs):
    return run_node(kind, inputs=inputs, pulses={"execIn": [0]}, app=app)


def sent(app, topic):
    return [to_plain(one.type_name, one.message) for one in app.sink[topic]]


def test_an_endpoint_is_a_topic_of_port_and_tag(world):
    app = world()
    trace = once("UCXPublishClock", app, timeStamp=1.5)
    once("UCXPublishClock", app, timeStamp=2.0, port=7, tag=9)
    assert trace.fired("execOut") == [0]
    assert sent(app, "/ucx/port_50008/tag_2985021151") == [{"clock": {"sec": 1, "nanosec": 500_000_000}}]
    assert sent(app, "/ucx/port_7/tag_9") == [{"clock": {"sec": 2, "nanosec": 0}}]


def test_joint_values_go_out_without_names(world):
    app = world()
    once("UCXPublishJointState", app, jointPositions=[1, 2], jointVelocities=[3, 4], timeStamp=1.0)
    [message] = sent(app, "/ucx/port_50008/tag_3806437495")
    assert [message[key] for key in ("name", "position", "velocity", "effort")] == [[], [1, 2], [3, 4], []]
    assert message["header"]["stamp"] == {"sec": 1, "nanosec": 0}


def test_odometry_imu_and_images(world):
    app = world()
    once("UCXPublishOdometry", app, position=[1, 2, 3], linearVelocity=[4, 5, 6])
    once("UCXPublishImu", app, linearAcceleration=[0, 0, 9.81], publishOrientation=False)
    once("UCXPublishImage", app, data=[1, 2, 3, 4], width=1, height=1, encoding="bgra8")
    [odometry], [imu], [image] = (sent(app, f"/ucx/port_13337/tag_{tag}") for tag in (7, 2, 10))
    assert odometry["pose"]["pose"]["position"] == {"x": 1, "y": 2, "z": 3}
    assert odometry["twist"]["twist"]["linear"] == {"x": 4, "y": 5, "z": 6}
    assert (imu["linear_acceleration"]["z"], imu["orientation_covariance"][0]) == (9.81, -1)
    assert (image["encoding"], image["step"], image["data"]) == ("bgra8", 4, [1, 2, 3, 4])


def test_commands_come_in(world):
    from graph.recording.sources import MemorySource, Player

    app = world()
    command = from_plain(JOINTS, {"position": [0.5], "velocity": [2.0], "header": {"stamp": {"sec": 3}}})
    Player(app, [MemorySource([("1/30", "/ucx/port_50008/tag_987171027", JOINTS, command)])])
    trace = run_node("UCXSubscribeJointCommand", pulses={"execIn": range(4)}, updates=4, app=app)
    assert trace.fired("execOut") == [1]
    assert trace.value("timeStamp") == 3.0
    found = [trace.value(f"{kind}Command").tolist() for kind in ("position", "velocity", "effort")]
    assert found == [[0.5], [2.0], []]


@pytest.mark.parametrize("kind", ["Clock", "JointState", "Odometry", "Imu"])
def test_no_message_is_sent_without_a_subscriber(stage, kind):
    from graph.sim import App

    with App(stage) as app:
        assert once(f"UCXPublish{kind}", app).fired("execOut") == []
