"""Publisher and subscriber of any message type."""

import pytest

from graph import ComputeError, Controller, OmniGraphError, UserError
from graph.sim import App
from graph.testing import run_node

POINT = {"messagePackage": "geometry_msgs", "messageName": "Point"}
PAIR = """\
nodes:
  tick: OnPlaybackTick
  send: {{type: ROS2Publisher, inputs: {{{type}, topicName: talk, {fields}}}}}
  hear: {{type: ROS2Subscriber, inputs: {{{type}, topicName: talk}}}}
  print: {{type: LogMessage}}
connections:
  - tick.tick -> [send.execIn, hear.execIn]
  - hear.{read} -> print.message
"""


def test_fields_are_inputs(world, plain):
    app = world()
    inputs = {**POINT, "x": 1.5, "z": lambda update: update}
    trace = run_node("ROS2Publisher", inputs=inputs, pulses={"execIn": range(3)}, updates=3, app=app)
    assert plain(app, "/topic") == [{"x": 1.5, "y": 0.0, "z": float(update)} for update in range(3)]
    assert trace.fired("execOut") == [0, 1, 2]
    assert [one.stamp_ns for one in app.sink["/topic"]] == [16_666_667, 33_333_333, 50_000_000]


def test_inner_fields_are_named_with_colons_and_lists_are_arrays(world, plain):
    app = world()
    inputs = {
        "messagePackage": "sensor_msgs", "messageName": "JointState", "topicName": "joints", "header:frame_id": "base",
        "header:stamp:sec": 3, "name": ["a", "b"], "position": [1, 2],
    }  # fmt: skip
    run_node("ROS2Publisher", inputs=inputs, pulses={"execIn": [0]}, app=app)
    [message] = plain(app, "/joints")
    assert message == {
        "header": {"stamp": {"sec": 3, "nanosec": 0}, "frame_id": "base"},
        "name": ["a", "b"], "position": [1.0, 2.0], "velocity": [], "effort": [],
    }  # fmt: skip


def test_fields_become_outputs_of_their_types(world, says, play):
    app = world()
    name = "geometry_msgs/msg/TwistStamped"
    message = says(name, header={"frame_id": "base", "stamp": {"nanosec": 7}}, twist={"linear": {"x": 0.5}})
    play(app, (0, "/topic", name, message))
    trace = run_node(
        "ROS2Subscriber",
        inputs={"messagePackage": "geometry_msgs", "messageName": "TwistStamped"},
        outputs=["twist:linear:x", "header:frame_id", "header:stamp:nanosec"],
        pulses={"execIn": [0, 1]}, updates=2, app=app,
    )  # fmt: skip
    assert trace.fired("execOut") == [0]
    assert [trace.value(one) for one in ("twist:linear:x", "header:frame_id", "header:stamp:nanosec")] == [
        0.5, "base", 7,
    ]  # fmt: skip
    types = {full: type_.name for full, type_ in trace.node.types.items() if type_ and full.startswith("outputs:")}
    assert types["outputs:twist:linear:x"] == "double"
    assert types["outputs:header:frame_id"] == "token"
    assert types["outputs:header:stamp:nanosec"] == "uint"


def test_a_list_of_messages_is_a_list_of_json(world, says, play):
    app = world()
    name = "tf2_msgs/msg/TFMessage"
    play(app, (0, "/topic", name, says(name, transforms=[{"child_frame_id": "a"}, {"child_frame_id": "b"}])))
    inputs = {"messagePackage": "tf2_msgs", "messageName": "TFMessage"}
    trace = run_node("ROS2Subscriber", inputs=inputs, outputs=["transforms"], pulses={"execIn": [0]}, app=app)
    assert [text[:80].count('"frame_id": ""') for text in trace.value("transforms")] == [1, 1]


def test_what_one_node_of_a_graph_says_another_hears_in_the_same_update(run_file):
    text = PAIR.format(type="messagePackage: std_msgs, messageName: String", fields="data: hello", read="data")
    app = run_file(text, 2)
    assert app.value("hear", "data") == "hello"
    assert app.value("print", "message") == "hello"
    assert app.graphs["/G"].nodes["hear"].computes == 2


def test_a_subscriber_in_the_run_makes_the_publisher_publish(run_file):
    text = PAIR.format(type="messagePackage: std_msgs, messageName: String", fields="data: hello", read="data")
    assert run_file(text, 3, heard=False).bus.topics["/talk"].messages == 3 - 1


def test_no_message_is_made_without_a_subscriber(stage):
    from graph.sim import App

    with App(stage) as app:
        trace = run_node("ROS2Publisher", inputs={**POINT, "x": 1.0}, pulses={"execIn": [0]}, app=app)
        assert trace.fired("execOut") == []
        assert app.bus.topics["/topic"].messages == 0


@pytest.mark.parametrize(
    ("fields", "read", "message"),
    [
        ("dta: hello", "data", 'inputs:dta is not a field of std_msgs/msg/String; did you mean "data"?'),
        ("data: hello", "dat", 'outputs:dat is not a field of std_msgs/msg/String; did you mean "data"?'),
    ],
)
def test_fields_that_are_not_there_are_reported_when_the_file_is_loaded(run_file, fields, read, message):
    text = PAIR.format(type="messagePackage: std_msgs, messageName: String", fields=fields, read=read)
    with pytest.raises(UserError) as refused:
        run_file(text, 1)
    assert message in str(refused.value)


def test_a_type_that_is_not_there_is_reported_when_the_file_is_loaded(run_file):
    text = PAIR.format(type="messagePackage: std_msgs, messageName: Sting", fields="data: hello", read="data")
    with pytest.raises(UserError) as refused:
        run_file(text, 1)
    assert 'there is no ROS 2 type "std_msgs/msg/Sting"' in str(refused.value)
    assert 'did you mean "std_msgs/msg/String"?' in str(refused.value)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({}, "no message type; set messagePackage and messageName"),
        ({"messagePackage": "std_msgs", "messageName": "Int8", "data": 300}, "field data: 300 does not fit into int8"),
    ],
)
def test_what_cannot_be_sent_stops_the_run(world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        run_node("ROS2Publisher", inputs=inputs, pulses={"execIn": [0]}, app=world())


def test_a_script_may_ask_for_a_field_that_nobody_connected(says, play):
    """Fields are there as in Isaac Sim, where the node makes them when it learns the message type."""
    keys = Controller.Keys
    with App() as app:
        _, (_, hear), _, _ = Controller.edit(
            {"graph_path": "/World/G", "evaluator_name": "execution"},
            {
                keys.CREATE_NODES: [("tick", "OnPlaybackTick"), ("hear", "isaacsim.ros2.bridge.ROS2Subscriber")],
                keys.SET_VALUES: [
                    ("hear.inputs:messagePackage", "std_msgs"),
                    ("hear.inputs:messageName", "Int32"),
                    ("hear.inputs:topicName", "talk"),
                ],
                keys.CONNECT: [("tick.outputs:tick", "hear.inputs:execIn")],
            },
        )
        app.play()
        app.update()
        data = hear.get_attribute("outputs:data")
        assert Controller.get(data) == 0
        play(
            app,
            (app.simulation.get_simulation_time(), "/talk", "std_msgs/msg/Int32", says("std_msgs/msg/Int32", data=7)),
        )
        app.update(steps=2)
        assert Controller.get(data) == 7
        assert data.get_type_name() == "int"
        with pytest.raises(OmniGraphError, match="outputs:datum is not a field of std_msgs/msg/Int32; did you mean"):
            Controller.get(hear.get_attribute("outputs:datum"))
