"""Scripts as tutorials for Isaac Sim have them: robots of one edit, changed by single calls while they play."""

import pytest

from graph import Controller, OmniGraphError
from graph.recording.sources import MemorySource, Player
from graph.sim import App
from graph.sim.messages.bus import MemorySink
from graph.sim.messages.ros_fields import from_plain

K = Controller.Keys
TWIST = "geometry_msgs/msg/Twist"
DRIVE = {
    K.CREATE_NODES: [
        ("OnPlaybackTick", "omni.graph.action.OnPlaybackTick"),
        ("SubscribeTwist", "omni.isaac.ros2_bridge.ROS2SubscribeTwist"),
        ("Scale", "omni.isaac.core_nodes.OgnIsaacScaleToFromStageUnit"),
        ("BreakLinear", "omni.graph.nodes.BreakVector3"),
        ("BreakAngular", "omni.graph.nodes.BreakVector3"),
        ("Drive", "omni.isaac.wheeled_robots.DifferentialController"),
    ],
    K.SET_VALUES: [
        ("Drive.inputs:wheelDistance", 0.16),
        ("Drive.inputs:wheelRadius", 0.025),
        ("SubscribeTwist.inputs:topicName", "cmd_vel"),
    ],
    K.CONNECT: [
        ("OnPlaybackTick.outputs:tick", "SubscribeTwist.inputs:execIn"),
        ("SubscribeTwist.outputs:execOut", "Drive.inputs:execIn"),
        ("SubscribeTwist.outputs:linearVelocity", "Scale.inputs:value"),
        ("Scale.outputs:result", "BreakLinear.inputs:tuple"),
        ("BreakLinear.outputs:x", "Drive.inputs:linearVelocity"),
        ("SubscribeTwist.outputs:angularVelocity", "BreakAngular.inputs:tuple"),
        ("BreakAngular.outputs:z", "Drive.inputs:angularVelocity"),
    ],
}


@pytest.fixture
def app():
    with App() as app:
        yield app


def command(app, linear, angular):
    """Sends a velocity and has it arrive."""
    message = from_plain(TWIST, {"linear": {"x": linear}, "angular": {"z": angular}})
    Player(app, [MemorySource([(app.simulation.get_simulation_time(), "/cmd_vel", TWIST, message)])])
    app.update(steps=3)


def test_a_robot_is_driven_and_slowed_down_while_it_plays(app):
    """Wheels turn at (v -+ w d/2) / r: v = 0.1 m/s, w = 0.5 rad/s, d = 0.16 m, r = 0.025 m."""
    graph, *_ = Controller.edit({"graph_path": "/ActionGraph", "evaluator_name": "execution"}, DRIVE)
    wheels = Controller.attribute("/ActionGraph/Drive.outputs:velocityCommand")
    app.play()
    command(app, 0.1, 0.5)
    assert list(wheels.get()) == pytest.approx([2.4, 5.6])

    Controller.create_node("/ActionGraph/half", "omni.graph.nodes.Multiply")
    factor = Controller.create_node(("factor", graph), "omni.graph.nodes.ConstantDouble")
    Controller.set(factor.get_attribute("inputs:value"), 0.5)
    Controller.disconnect("/ActionGraph/BreakLinear.outputs:x", "/ActionGraph/Drive.inputs:linearVelocity")
    Controller.connect("/ActionGraph/BreakLinear.outputs:x", "/ActionGraph/half.inputs:a")
    Controller.connect(factor.get_attribute("inputs:value"), "/ActionGraph/half.inputs:b")
    Controller.connect("/ActionGraph/half.outputs:product", "/ActionGraph/Drive.inputs:linearVelocity")
    command(app, 0.1, 0.5)
    assert list(wheels.get()) == pytest.approx([0.4, 3.6]), "half of 0.1 m/s"

    Controller.set("/ActionGraph/Drive.inputs:wheelRadius", 0.05)
    Controller.set("/ActionGraph/factor.inputs:value", 2.0)
    command(app, 0.1, 0.0)
    assert list(wheels.get()) == pytest.approx([8.0, 8.0]), "0.2 m/s; the radius is read at the first compute"
    app.stop()
    app.play()
    app.update(steps=20)  # what was sent before comes again at its times
    command(app, 0.1, 0.0)
    assert list(wheels.get()) == pytest.approx([4.0, 4.0]), "0.2 m/s on wheels of 0.05 m"

    Controller.delete_node("/ActionGraph/half")
    assert not Controller.attribute("/ActionGraph/Drive.inputs:linearVelocity").is_connected()
    command(app, 0.1, 0.5)
    assert list(wheels.get()) == pytest.approx([-0.8, 0.8]), "nothing but the turn is left"
    assert len(graph.get_nodes()) == 7


def test_a_value_goes_through_sums_and_arrays_that_are_put_together_call_by_call(app):
    graph = Controller.create_graph({"graph_path": "/P", "evaluator_name": "push"})
    a = Controller.create_node("/P/a", "omni.graph.nodes.ConstantFloat")
    b = Controller.create_node(("b", "/P"), "omni.graph.nodes.ConstantInt")
    add = Controller.create_node("/P/add", "omni.graph.nodes.Add")
    Controller.connect(a.get_attribute("inputs:value"), add.get_attribute("inputs:a"))
    Controller.connect(b.get_attribute("inputs:value"), add.get_attribute("inputs:b"))
    Controller.set(a.get_attribute("inputs:value"), 1.5)
    Controller.set("/P/b.inputs:value", 2)
    Controller.evaluate_sync(graph)
    assert Controller.get(add.get_attribute("outputs:sum")) == 3.5
    assert add.get_attribute("outputs:sum").get_type_name() == "float"

    Controller.edit(graph, {K.CREATE_NODES: [("array", "omni.graph.nodes.ConstructArray")]})
    Controller.set("/P/array.inputs:arraySize", 2)
    Controller.connect("/P/add.outputs:sum", "/P/array.inputs:input0")
    Controller.create_attribute("/P/array", "inputs:input1", "any")
    Controller.connect("/P/a.inputs:value", "/P/array.inputs:input1")
    Controller.create_node("/P/pick", "omni.graph.nodes.ArrayIndex")
    Controller.connect("/P/array.outputs:array", "/P/pick.inputs:array")
    Controller.set("/P/pick.inputs:index", 1)
    Controller.evaluate_sync(graph)
    assert Controller.get("/P/array.outputs:array").tolist() == [3.5, 1.5]
    assert Controller.get("/P/pick.outputs:value") == 1.5

    Controller.edit(
        graph,
        {K.DISCONNECT: ("/P/b.inputs:value", "/P/add.inputs:b"), K.CONNECT: ("/P/a.inputs:value", "/P/add.inputs:b")},
    )
    Controller.evaluate_sync(graph)
    assert Controller.get("/P/array.outputs:array").tolist() == [3.0, 1.5], "1.5 + 1.5"
    assert Controller.delete_node("/P/pick")
    assert Controller.delete_node("/P/b")
    assert [node.get_type_name().rpartition(".")[2] for node in graph.get_nodes()] == [
        "ConstantFloat", "Add", "ConstructArray",
    ]  # fmt: skip


def test_a_counter_is_built_into_a_graph_that_plays_and_taken_out_again(app):
    graph, (tick, count), _, _ = Controller.edit(
        {"graph_path": "/World/G", "evaluator_name": "execution"},
        {
            K.CREATE_NODES: [("tick", "omni.graph.action.OnPlaybackTick"), ("count", "omni.graph.action.Counter")],
            K.CONNECT: [("tick.outputs:tick", "count.inputs:execIn")],
        },
    )
    app.play()
    app.update(steps=3)
    assert Controller.get(count.get_attribute("outputs:count")) == 3
    second = Controller.create_node("/World/G/second", "omni.graph.action.Counter")
    Controller.connect("/World/G/count.outputs:execOut", "/World/G/second.inputs:execIn")
    total = Controller.create_node("/World/G/total", "omni.graph.nodes.Add")
    Controller.connect("/World/G/count.outputs:count", "/World/G/total.inputs:a")
    Controller.connect("/World/G/second.outputs:count", "/World/G/total.inputs:b")
    Controller.create_variable(graph, "total", "int")
    Controller.edit(
        graph,
        {
            K.CREATE_NODES: ("write", "omni.graph.core.WriteVariable"),
            K.SET_VALUES: ("write.inputs:variableName", "total"),
            K.CONNECT: [("total.outputs:sum", "write.inputs:value"), ("second.outputs:execOut", "write.inputs:execIn")],
        },
    )
    app.update(steps=2)
    assert (count.get("outputs:count"), second.get("outputs:count")) == (5, 2), "what was there goes on"
    assert [one.get() for one in graph.get_variables()] == [7]
    Controller.disconnect("/World/G/tick.outputs:tick", "/World/G/count.inputs:execIn")
    app.update(steps=5)
    assert (count.get("outputs:count"), second.get("outputs:count")) == (5, 2)
    Controller.connect(tick.get_attribute("outputs:tick"), second.get_attribute("inputs:execIn"))
    app.update()
    assert (second.get("outputs:count"), graph.find_variable("total").get()) == (3, 8)
    assert total in graph.get_nodes()
    app.stop()
    app.play()
    app.update()
    assert (count.get("outputs:count"), second.get("outputs:count")) == (0, 1), "the edit stays, the counts begin anew"


def test_a_clock_is_published_under_another_topic_after_an_edit(app):
    sink = MemorySink()
    app.bus.subscribe(sink)
    Controller.edit(
        {"graph_path": "/World/Clock", "evaluator_name": "execution"},
        {
            K.CREATE_NODES: [
                ("tick", "omni.graph.action.OnPlaybackTick"),
                ("time", "isaacsim.core.nodes.IsaacReadSimulationTime"),
                ("context", "isaacsim.ros2.bridge.ROS2Context"),
                ("clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
            ],
            K.CONNECT: [
                ("tick.outputs:tick", "clock.inputs:execIn"),
                ("time.outputs:simulationTime", "clock.inputs:timeStamp"),
                ("context.outputs:context", "clock.inputs:context"),
            ],
            K.SET_VALUES: [("context.inputs:useDomainIDEnvVar", 1), ("clock.inputs:topicName", "clock")],
        },
    )
    app.play()
    app.update(steps=3)
    stamps = [one.stamp_ns for one in sink["/clock"]]
    assert stamps == [16_666_667, 33_333_333, 50_000_000], "k/60 s"
    later = Controller.create_node("/World/Clock/later", "omni.graph.nodes.Add")
    Controller.disconnect("/World/Clock/time.outputs:simulationTime", "/World/Clock/clock.inputs:timeStamp")
    Controller.connect("/World/Clock/time.outputs:simulationTime", later.get_attribute("inputs:a"))
    Controller.edit("/World/Clock", {K.SET_VALUES: (later.get_attribute("inputs:b"), 1.0)})
    Controller.connect(later.get_attribute("outputs:sum"), "/World/Clock/clock.inputs:timeStamp")
    app.update()
    message = sink["/clock"][-1].message
    assert (message.clock.sec, message.clock.nanosec) == (1, 66_666_667), "4/60 s and one second"


def test_what_a_script_does_wrong_leaves_the_playing_graph_as_it_was(app):
    graph, *_ = Controller.edit({"graph_path": "/ActionGraph", "evaluator_name": "execution"}, DRIVE)
    app.play()
    command(app, 0.1, 0.0)
    before = graph.spec
    for wrong, message in [
        (
            lambda: Controller.connect("/ActionGraph/Drive.outputs:velocity", "/ActionGraph/Scale.inputs:value"),
            "did you",
        ),
        (
            lambda: Controller.disconnect("/ActionGraph/Scale.outputs:result", "/ActionGraph/Drive.inputs:dt"),
            "are not con",
        ),
        (lambda: Controller.create_node("/ActionGraph/Drive", "omni.graph.nodes.Add"), "already exists"),
        (
            lambda: Controller.connect(
                "/ActionGraph/Drive.outputs:velocityCommand", "/ActionGraph/BreakLinear.inputs:tuple"
            ),
            "two sources",
        ),
        (lambda: Controller.set("/ActionGraph/Drive.inputs:wheelRadius", "wide"), "expected a number"),
        (lambda: Controller.delete_node("/ActionGraph/Driver"), "did you mean"),
    ]:
        with pytest.raises(OmniGraphError, match=message):
            wrong()
        assert graph.spec is before
    command(app, 0.2, 0.0)
    assert list(Controller.get("/ActionGraph/Drive.outputs:velocityCommand")) == pytest.approx([8.0, 8.0])
