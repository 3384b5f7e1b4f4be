import math
from fractions import Fraction
from types import SimpleNamespace

import pytest

from graph import ComputeError
from graph.testing import run_node


def ns(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


@pytest.mark.parametrize(
    ("physics_hz", "loop_hz"), [(240, 60), (1000, 30), (60, 60), (Fraction(2997, 100), Fraction(2997, 100))]
)
def test_a_clock_fed_with_simulation_time_is_exact_to_the_nanosecond(world, physics_hz, loop_hz):
    app = world(physics_hz=physics_hz, loop_hz=loop_hz)
    run_node(
        "ROS2PublishClock",
        inputs={"timeStamp": lambda update: app.simulation.get_simulation_time()},
        pulses={"execIn": range(100)},
        updates=100,
        app=app,
    )
    stamps = [ns(one.message.clock) for one in app.sink["/clock"]]
    assert len(stamps) == 100
    steps = [math.floor(Fraction(update + 1) * physics_hz / loop_hz) for update in range(100)]
    assert stamps == [round(10**9 * Fraction(count) / physics_hz) for count in steps]


def test_a_clock_of_a_late_hour_is_still_exact(world):
    app = world(physics_hz=1000, loop_hz=60)
    app.play()
    app.simulation.clock.advance(36_000_000_000)
    run_node("ROS2PublishClock", inputs={"timeStamp": lambda update: app.simulation.get_simulation_time()},
             pulses={"execIn": [2]}, updates=3, app=app)  # fmt: skip
    [message] = app.sink["/clock"]
    assert ns(message.message.clock) == 36_000_000_050_000_000 == message.stamp_ns


def test_any_other_time_is_rounded_to_the_nearest_nanosecond(world):
    app = world()
    run_node("ROS2PublishClock", inputs={"timeStamp": 1.1}, pulses={"execIn": [0]}, app=app)
    assert ns(app.sink["/clock"][0].message.clock) == 1_100_000_000


def test_without_subscribers_nothing_is_made_but_the_topic_is_known(stage):
    from graph.sim import App

    with App(stage) as app:
        trace = run_node("ROS2PublishClock", pulses={"execIn": range(3)}, updates=3, app=app)
        assert trace.computes == 3
        assert {name: topic.messages for name, topic in app.bus.topics.items()} == {"/clock": 0}


@pytest.mark.parametrize(
    ("inputs", "topic"),
    [
        ({"topicName": "time"}, "/time"),
        ({"topicName": "time", "nodeNamespace": "robot"}, "/robot/time"),
        ({"topicName": "/time", "nodeNamespace": "robot"}, "/time"),
        ({"topicName": "time", "nodeNamespace": "/a/b/"}, "/a/b/time"),
    ],
)
def test_a_topic_is_the_namespace_and_the_name(world, inputs, topic):
    app = world()
    run_node("ROS2PublishClock", inputs=inputs, pulses={"execIn": [0]}, app=app)
    assert [name for name, messages in app.sink.messages.items() if messages] == [topic]


@pytest.mark.parametrize(("name", "namespace"), [("clock", "1abc"), ("a b", ""), ("", "robot")])
def test_inputs_that_make_no_topic_plan_none(name, namespace):
    from nodes.ros2.publishing import planned_topic

    inputs = SimpleNamespace(topicName=name, nodeNamespace=namespace or "robot")
    assert planned_topic(SimpleNamespace(inputs=inputs), "/World/G/n") is None


def test_the_namespace_comes_from_the_prims_above_where_the_node_gives_none(stage):
    from pxr import Sdf

    from nodes.ros2.publishing import collect_namespace

    for path, value in (("/World", "site"), ("/World/Robot", "r2")):
        stage.DefinePrim(path).CreateAttribute("isaac:namespace", Sdf.ValueTypeNames.String).Set(value)
    assert collect_namespace(stage, "/World/Robot/Graph/publish") == "site/r2"
    assert collect_namespace(stage, "/Other/Graph/publish") == ""


def test_an_empty_topic_is_refused(world):
    with pytest.raises(ComputeError, match="topicName is empty"):
        run_node("ROS2PublishClock", inputs={"topicName": " "}, pulses={"execIn": [0]}, app=world())


def test_a_publisher_announces_itself_again_after_a_stop(world):
    app = world()
    run_node("ROS2PublishClock", pulses={"execIn": [0, 1]}, updates=2, app=app)
    app.stop()
    run_node("ROS2PublishClock", pulses={"execIn": [0]}, app=app)
    assert len(app.sink["/clock"]) == 3


@pytest.mark.parametrize(("variable", "inputs", "context"), [("", {"domain_id": 4}, 5), ("7", {"domain_id": 4}, 8)])
def test_a_context_stands_for_a_domain(monkeypatch, variable, inputs, context):
    monkeypatch.setenv("ROS_DOMAIN_ID", variable)
    assert run_node("ROS2Context", inputs=inputs).value("context") == context


def test_the_environment_can_be_left_out_of_it(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    assert run_node("ROS2Context", inputs={"useDomainIDEnvVar": False}).value("context") == 1


def test_a_domain_that_is_not_a_number_is_refused(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "seven")
    with pytest.raises(ComputeError, match="ROS_DOMAIN_ID is 'seven'"):
        run_node("ROS2Context")
