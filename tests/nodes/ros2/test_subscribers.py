"""Subscribing nodes: when they fire, what they keep, what waits."""

import json
from fractions import Fraction

import pytest

from graph import ComputeError
from graph.node import registry
from graph.testing import run_node

TWIST = "geometry_msgs/msg/Twist"


def every(updates):
    return {"pulses": {"execIn": range(updates)}, "updates": updates}


def test_a_twist_fires_once_and_its_values_stay(world, says, play):
    app = world()
    message = says(TWIST, linear={"x": 0.5, "y": 1}, angular={"z": -2})
    play(app, (Fraction(3, 60), "/cmd_vel", TWIST, message))
    trace = run_node("ROS2SubscribeTwist", **every(6), app=app)
    assert trace.fired("execOut") == [2]
    assert [value.tolist() for value in trace.values("linearVelocity")] == [[0, 0, 0]] * 2 + [[0.5, 1, 0]] * 4
    assert trace.value("angularVelocity").tolist() == [0, 0, -2]


def speeds(*times_and_speeds, says):
    return [(time, "/cmd_vel", TWIST, says(TWIST, linear={"x": speed})) for time, speed in times_and_speeds]


def test_each_compute_takes_one_message_oldest_first(world, says, play):
    app = world(physics_hz=240)
    play(app, *speeds((0, 1), ("1/240", 2), ("2/240", 3), says=says))
    trace = run_node("ROS2SubscribeTwist", **every(5), app=app)
    assert trace.fired("execOut") == [0, 1, 2]
    assert [value[0] for value in trace.values("linearVelocity")] == [1, 2, 3, 3, 3]


@pytest.mark.parametrize(
    ("inputs", "taken"),
    [
        ({"queueSize": 2}, [4, 5, 5]),
        ({"queueSize": 0}, [5, 5, 5]),
        ({"qosProfile": json.dumps({"history": "keepLast", "depth": 1})}, [5, 5, 5]),
        ({"qosProfile": json.dumps({"history": "keepAll", "depth": 1})}, [1, 2, 3]),
    ],
)
def test_a_full_queue_loses_the_oldest_and_says_so(world, says, play, inputs, taken):
    app = world(physics_hz=600)
    play(app, *speeds(*((Fraction(number, 600), number) for number in range(1, 6)), says=says))
    trace = run_node("ROS2SubscribeTwist", inputs=inputs, **every(3), app=app)
    assert [value[0] for value in trace.values("linearVelocity")] == taken
    lost = [warning.code for warning in trace.warnings]
    assert lost == ([] if taken == [1, 2, 3] else ["subscriber-queue-full"])


def test_a_subscriber_hears_from_the_update_of_its_first_compute_on(world, says, play):
    app = world()
    play(app, *speeds(*((Fraction(number, 60), number) for number in range(1, 8)), says=says))
    trace = run_node("ROS2SubscribeTwist", pulses={"execIn": [3, 4]}, updates=6, app=app)
    assert [value[0] for value in trace.values("linearVelocity")] == [0, 0, 0, 4, 5, 5]


def test_a_stop_forgets_what_waits(world, says, play, monkeypatch):
    app = world()
    listening = []
    listen, unlisten = app.bus.listen, app.bus.unlisten
    monkeypatch.setattr(
        app.bus, "listen", lambda *given, **more: listening.append(listen(*given, **more)) or listening[-1]
    )
    monkeypatch.setattr(app.bus, "unlisten", lambda one: (listening.remove(one), unlisten(one)))
    play(app, *speeds((0, 1), (0, 2), ("1/60", 3), says=says))
    seen = []

    def stop_once(update, node):
        seen.append(node.get("linearVelocity")[0])
        if update == 2:
            app.stop()
            app.play()

    run_node("ROS2SubscribeTwist", **every(5), app=app, on_update=stop_once)
    assert seen == [0, 1, 2, 1, 2]
    assert [one.topic for one in listening] == ["/cmd_vel"]


def test_namespaces_apply_to_subscribers_too(world, says, play):
    app = world()
    play(app, (0, "/robot/cmd_vel", TWIST, says(TWIST, linear={"x": 1})))
    trace = run_node("ROS2SubscribeTwist", inputs={"nodeNamespace": "robot"}, **every(1), app=app)
    assert trace.fired("execOut") == [0]


def test_joint_commands_arrive_with_names_and_stamp(world, says, play):
    app = world()
    name = "sensor_msgs/msg/JointState"
    header = {"stamp": {"sec": 2, "nanosec": 500_000_000}}
    play(app, (0, "/joint_command", name, says(name, header=header, name=["a", "b"], velocity=[1, 2])))
    trace = run_node("ROS2SubscribeJointState", **every(1), app=app)
    assert trace.fired("execOut") == [0]
    assert trace.value("timeStamp") == 2.5
    assert list(trace.value("jointNames")) == ["a", "b"]
    found = [trace.value(f"{kind}Command").tolist() for kind in ("position", "velocity", "effort")]
    assert found == [[], [1, 2], []]


def test_a_clock_from_outside(world, says, play):
    app = world()
    play(app, (0, "/clock", "rosgraph_msgs/msg/Clock", says("rosgraph_msgs/msg/Clock", clock={"sec": 7})))
    trace = run_node("ROS2SubscribeClock", **every(2), app=app)
    assert (trace.fired("execOut"), trace.value("timeStamp")) == ([0], 7.0)


def test_ackermann_commands(world, says, play):
    app = world()
    name = "ackermann_msgs/msg/AckermannDriveStamped"
    drive = {"steering_angle": 0.25, "steering_angle_velocity": 0.5, "speed": 2, "acceleration": 1, "jerk": 4}
    play(app, (0, "/ackermann_cmd", name, says(name, header={"frame_id": "base"}, drive=drive)))
    trace = run_node("ROS2SubscribeAckermannDrive", **every(1), app=app)
    names = ("frameId", "steeringAngle", "steeringAngleVelocity", "speed", "acceleration", "jerk")
    assert [trace.value(name) for name in names] == ["base", 0.25, 0.5, 2, 1, 4]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"topicName": " "}, "topicName is empty"),
        ({"qosProfile": "fast"}, "qosProfile 'fast' is not a profile; connect the output of a ROS2QoSProfile"),
        ({"qosProfile": '{"depth": -1}'}, "depth -1 is not a number of messages"),
        ({"qosProfile": '{"speed": 1}'}, "is not a profile"),
    ],
)
def test_wrong_inputs_are_refused(world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        run_node("ROS2SubscribeTwist", inputs=inputs, **every(1), app=world())


def test_a_topic_of_another_type_stops_the_run(world, says, play):
    app = world()
    play(app, (0, "/cmd_vel", "std_msgs/msg/String", says("std_msgs/msg/String")))
    with pytest.raises(Exception, match=r"topic /cmd_vel: .* sends std_msgs/msg/String, but /test/node expects"):
        run_node("ROS2SubscribeTwist", **every(1), app=app)


def test_a_profile_says_its_presets_and_its_own_policies():
    def profile(**inputs):
        return json.loads(run_node("ROS2QoSProfile", inputs=inputs).value("qosProfile"))

    usual = profile()
    assert usual == {
        "history": "keepLast", "depth": 10, "reliability": "reliable", "durability": "volatile", "deadline": 0.0,
        "lifespan": 0.0, "liveliness": "systemDefault", "leaseDuration": 0.0,
    }  # fmt: skip
    assert profile(createProfile="Sensor Data") == {**usual, "depth": 5, "reliability": "bestEffort"}
    assert profile(createProfile="Services", depth=3) == usual
    assert profile(createProfile="System Default")["depth"] == 0
    assert profile(createProfile="Custom", depth=3, durability="transientLocal") == {
        **usual, "depth": 3, "durability": "transientLocal",
    }  # fmt: skip


def test_no_subscriber_counts_as_a_publisher_that_keeps_silent():
    publishers = {one.short_name for one in registry.all() if one.inputs_as("topic")}
    assert {"ROS2Publisher", "ROS2PublishClock", "ROS2RtxLidarHelper"} <= publishers
    assert not {one for one in publishers if "Subscri" in one}
