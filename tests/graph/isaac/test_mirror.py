"""Graphs of a script and their prims on the stage, both ways."""

import pytest

SETUP = """from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import omni.graph.core as og, omni.usd, omni.timeline
from pxr import Sdf
keys = og.Controller.Keys
og.Controller.edit({"graph_path": "/World/G", "evaluator_name": "execution"}, {
    keys.CREATE_NODES: [
        ("tick", "omni.graph.action.OnPlaybackTick"),
        ("count", "omni.graph.action.Counter"),
        ("clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
    ],
    keys.CONNECT: [("tick.outputs:tick", "count.inputs:execIn")],
    keys.SET_VALUES: [("clock.inputs:topicName", "a")],
})
stage = omni.usd.get_context().get_stage()
clock = stage.GetPrimAtPath("/World/G/clock")
timeline = omni.timeline.get_timeline_interface()
def run(updates):
    timeline.play()
    for _ in range(updates):
        app.update()
"""


@pytest.fixture
def printed(run_script):
    def run(text):
        code, out, err = run_script(SETUP + text + "\napp.close()\n")
        assert code == 0, err
        return out.splitlines(), err

    return run


def test_an_edit_leaves_prims(printed):
    lines, _ = printed("""
print(stage.GetPrimAtPath("/World/G").GetTypeName(), clock.GetTypeName(), clock.GetAttribute("node:type").Get())
print(clock.GetAttribute("inputs:topicName").Get(), stage.GetPrimAtPath("/World").GetTypeName())
print(stage.GetPrimAtPath("/World/G/count").GetAttribute("inputs:execIn").GetConnections())
og.Controller.attribute("/World/G/clock.inputs:topicName").set("b")
print(clock.GetAttribute("inputs:topicName").Get())
og.Controller.delete_node("/World/G/count")
print(bool(stage.GetPrimAtPath("/World/G/count")))
""")
    assert lines == [
        "OmniGraph OmniGraphNode isaacsim.ros2.bridge.ROS2PublishClock",
        "a Xform",
        "[Sdf.Path('/World/G/tick.outputs:tick')]",
        "b",
        "False",
    ]


def test_values_connections_nodes_and_variables_of_the_stage_reach_the_graph(printed):
    lines, err = printed("""
clock.GetAttribute("inputs:topicName").Set("other")
clock.GetAttribute("inputs:execIn").AddConnection("/World/G/tick.outputs:tick")
node = stage.DefinePrim("/World/G/second", "OmniGraphNode")
node.CreateAttribute("node:type", Sdf.ValueTypeNames.Token).Set("omni.graph.action.Counter")
node.CreateAttribute("node:typeVersion", Sdf.ValueTypeNames.Int).Set(1)
node.CreateAttribute("inputs:execIn", Sdf.ValueTypeNames.UInt).AddConnection("/World/G/tick.outputs:tick")
variable = stage.GetPrimAtPath("/World/G").CreateAttribute("graph:variable:speed", Sdf.ValueTypeNames.Double)
variable.Set(2.5)
print(og.Controller.get("/World/G/clock.inputs:topicName"))
print(og.get_graph_by_path("/World/G").find_variable("speed").get())
run(3)
print(og.Controller.get("/World/G/second.outputs:count"))
""")
    assert lines == ["other", "2.5", "3"]
    assert "/other" in err
    assert "3  rosgraph_msgs/msg/Clock" in err


def test_removed_prims_are_removed_nodes_and_graphs(printed):
    lines, _ = printed("""
print(stage.RemovePrim("/World/G/count"), og.get_node_by_path("/World/G/count"))
run(2)
timeline.stop()
app.update()
print([prim.GetName() for prim in stage.GetPrimAtPath("/World/G").GetChildren()])
print(stage.RemovePrim("/World/G"), og.get_graph_by_path("/World/G"), og.get_all_graphs())
""")
    assert lines == ["True None", "['tick', 'clock']", "True None []"]


def test_a_stop_keeps_edits_of_graphs_on_the_stage(printed):
    lines, _ = printed("""
run(2)
og.Controller.edit("/World/G", {keys.CREATE_NODES: [("late", "omni.graph.action.Counter")]})
og.Controller.attribute("/World/G/clock.inputs:topicName").set("late")
timeline.stop()
app.update()
print(bool(stage.GetPrimAtPath("/World/G/late")), clock.GetAttribute("inputs:topicName").Get())
print(og.Controller.get("/World/G/clock.inputs:topicName"))
""")
    assert lines == ["True late", "late"]


def test_a_wrong_edit_of_the_stage_is_a_warning_and_the_rest_counts(printed):
    lines, err = printed("""
node = stage.DefinePrim("/World/G/odd", "OmniGraphNode")
node.CreateAttribute("node:type", Sdf.ValueTypeNames.Token).Set("acme.Nope")
clock.GetAttribute("inputs:topicName").Set("good")
print(og.get_node_by_path("/World/G/odd"), og.Controller.get("/World/G/clock.inputs:topicName"))
""")
    assert lines == ["None good"]
    assert "stage-edit-refused: /World/G" in err


def test_unset_inputs_have_their_defaults_on_the_stage_and_a_cleared_one_gets_it_back(printed):
    lines, _ = printed("""
topic = clock.GetAttribute("inputs:topicName")
default = og.Controller.node("/World/G/clock").get_attribute("inputs:queueSize").get()
print(clock.GetAttribute("inputs:queueSize").Get() == default, topic.Get())
topic.Clear()
print(og.Controller.get("/World/G/clock.inputs:topicName"))
topic.Set("again")
print(og.Controller.get("/World/G/clock.inputs:topicName"))
""")
    assert lines == ["True a", "clock", "again"]


def test_a_node_that_comes_back_on_the_stage_is_connected_again(printed):
    lines, _ = printed("""
count = stage.GetPrimAtPath("/World/G/count")
tick = stage.GetPrimAtPath("/World/G/tick")
tick.SetActive(False)
sources = lambda: og.Controller.attribute("/World/G/count.inputs:execIn").get_upstream_connections()
print([one.get_path() for one in sources()])
tick.SetActive(True)
print([one.get_path() for one in sources()])
run(2)
print(og.Controller.get("/World/G/count.outputs:count"))
""")
    assert lines == ["[]", "['/World/G/tick.outputs:tick']", "2"]


def test_attributes_that_a_script_adds_to_the_prim_of_a_node_outlast_edits(printed):
    lines, _ = printed("""
clock.CreateAttribute("ui:note", Sdf.ValueTypeNames.String).Set("mine")
og.Controller.edit("/World/G", {
    keys.CONNECT: [("tick.outputs:tick", "clock.inputs:execIn")],
    keys.SET_VALUES: [("clock.inputs:topicName", "b")],
})
print(clock.GetAttribute("ui:note").Get(), clock.GetAttribute("inputs:topicName").Get())
print(clock.GetAttribute("inputs:execIn").GetConnections())
og.Controller.disconnect("/World/G/tick.outputs:tick", "/World/G/clock.inputs:execIn")
print(clock.GetAttribute("inputs:execIn").GetConnections())
""")
    assert lines == ["mine b", "[Sdf.Path('/World/G/tick.outputs:tick')]", "[]"]


def test_what_was_edited_while_playing_is_on_the_stage_after_the_stop(printed):
    lines, _ = printed("""
run(1)
og.Controller.delete_node("/World/G/count")
og.Controller.edit("/World/G", {
    keys.CREATE_NODES: [("late", "omni.graph.action.Counter")],
    keys.CONNECT: [("tick.outputs:tick", "late.inputs:execIn")],
    keys.CREATE_VARIABLES: [("speed", "double", 2.0)],
})
og.Controller.edit("/World/H", {keys.CREATE_NODES: [("tick", "omni.graph.action.OnPlaybackTick")]})
clock.GetAttribute("inputs:topicName").Set("onStage")
app.update()
timeline.stop()
app.update()
graph = stage.GetPrimAtPath("/World/G")
print(*([prim.GetName() for prim in one.GetChildren()] for one in (graph, stage.GetPrimAtPath("/World/H"))))
print(stage.GetAttributeAtPath("/World/G/late.inputs:execIn").GetConnections())
print(graph.GetAttribute("graph:variable:speed").Get(), clock.GetAttribute("inputs:topicName").Get())
run(2)
print(og.Controller.get("/World/G/late.outputs:count"))
""")
    assert lines == [
        "['tick', 'clock', 'late'] ['tick']",
        "[Sdf.Path('/World/G/tick.outputs:tick')]",
        "2.0 onStage",
        "2",
    ]


def test_a_variable_that_gets_another_value_on_the_stage_has_it_at_once_and_at_the_next_start(printed):
    lines, _ = printed("""
og.Controller.edit("/World/G", {keys.CREATE_VARIABLES: [("speed", "double", 1.0)]})
speed = og.get_graph_by_path("/World/G").find_variable("speed")
stage.GetPrimAtPath("/World/G").GetAttribute("graph:variable:speed").Set(2.0)
og.get_graph_by_path("/World/G")
print(speed.get())
run(1)
timeline.stop()
app.update()
print(speed.get(), og.Controller.get_variable_default_value(speed))
""")
    assert lines == ["2.0", "2.0 2.0"]


def test_a_value_set_after_an_edit_waits_with_it_and_is_on_the_stage_at_once(printed):
    """Compiling a graph of a thousand nodes costs fifty times what an edit of one node does."""
    lines, _ = printed("""
from graph.session.runner import graphs_of
from graph.isaac.session import app as our_app
app.update()
og.Controller.edit("/World/G", {keys.CREATE_NODES: [("value", "omni.graph.nodes.ConstantDouble")]})
for path, value in (("/World/G/value.inputs:value", 2.5), ("/World/G/clock.inputs:topicName", "c")):
    og.Controller.set(path, value)
    print(stage.GetAttributeAtPath(path).Get(), graphs_of(our_app()).graphs["/World/G"].stale is None)
app.update()
print(og.Controller.get("/World/G/value.inputs:value"), og.Controller.get("/World/G/clock.inputs:topicName"))
""")
    assert lines == ["2.5 False", "c False", "2.5 c"]


def test_a_set_value_is_no_default_any_more_and_notes_of_the_script_stay(printed):
    lines, _ = printed("""
topic, size = (clock.GetAttribute(f"inputs:{name}") for name in ("nodeNamespace", "queueSize"))
size.SetCustomDataByKey("mine", 1)
print(topic.HasAuthoredMetadata("customData"), sorted(size.GetCustomData()))
og.Controller.set("/World/G/clock.inputs:nodeNamespace", "robot")
og.Controller.set("/World/G/clock.inputs:queueSize", 3)
print(topic.HasAuthoredMetadata("customData"), size.GetCustomData(), topic.Get(), size.Get())
""")
    assert lines == ["True ['mine', 'tickgraph']", "False {'mine': 1} robot 3"]


def test_a_callback_hears_values_of_the_controller_and_of_the_stage(printed):
    lines, _ = printed("""
attribute = og.Controller.attribute("/World/G/clock.inputs:topicName")
attribute.register_value_changed_callback(lambda one: print(one.get_name(), one.get(), one == attribute))
og.Controller.set(attribute, "b")
og.Controller.set("/World/G/clock.inputs:topicName", "c")
clock.GetAttribute("inputs:topicName").Set("d")
app.update()
attribute.register_value_changed_callback(None)
attribute.set("e")
""")
    assert lines == [f"inputs:topicName {value} True" for value in "bcd"]


def test_values_of_usd_types_are_taken_as_lists_and_quaternions_with_the_real_part_last(printed):
    lines, _ = printed("""
import numpy as np
from pxr import Gf, Vt
graph, nodes, _, _ = og.Controller.edit("/World/V", {
    keys.CREATE_NODES: [("point", "omni.graph.nodes.ConstantPoint3d"), ("turn", "omni.graph.nodes.ConstantQuatd"),
                        ("many", "omni.graph.action.OnPlaybackTick")],
    keys.CREATE_ATTRIBUTES: [("many.inputs:floats", "float[]"), ("many.inputs:points", "pointf[3][]"),
                             ("many.inputs:matrix", "matrixd[4]")],
    keys.SET_VALUES: [("point.inputs:value", Gf.Vec3d(1, 2, 3)), ("turn.inputs:value", Gf.Quatd(1, 0, 0, 0.5)),
                      ("many.inputs:floats", Vt.FloatArray([1, 2])), ("many.inputs:matrix", Gf.Matrix4d(2.0))],
})
og.Controller.set("/World/V/many.inputs:points", Vt.Vec3fArray([(0, 1, 2), (3, 4, 5)]))
for path in ("point.inputs:value", "turn.inputs:value", "many.inputs:floats", "many.inputs:points"):
    print(np.ravel(og.Controller.get(f"/World/V/{path}")).tolist())
matrix = og.Controller.get("/World/V/many.inputs:matrix")
print(stage.GetAttributeAtPath("/World/V/turn.inputs:value").Get(), matrix[1][1])
""")
    assert lines == [
        "[1.0, 2.0, 3.0]",
        "[0.0, 0.0, 0.5, 1.0]",
        "[1.0, 2.0]",
        "[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]",
        "(1, 0, 0, 0.5) 2.0",
    ]
