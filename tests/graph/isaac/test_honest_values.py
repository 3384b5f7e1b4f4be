"""Values that scripts read are real: contacts, moduli, metadata, types, instances; what has no effect says so."""

from dataclasses import replace
from importlib import import_module

import pytest

import graph.isaac
from graph.session.runner import graphs_of
from graph.sim import App
from tests.support.without_wing import needs_wing

APP = "from isaacsim import SimulationApp\napp = SimulationApp({'headless': True})\n"
GRAPH = (
    APP
    + """
import omni.graph.core as og
keys = og.Controller.Keys
graph, nodes, _, _ = og.Controller.edit("/G", {
    keys.CREATE_NODES: [("tick", "omni.graph.action.OnPlaybackTick"), ("add", "omni.graph.nodes.Add")],
    keys.CREATE_VARIABLES: [("speed", "float")],
})
"""
)


@pytest.fixture
def printed(run_script):
    def run(text, *options):
        code, out, err = run_script(text, *options)
        assert code == 0, err
        return out.splitlines(), err

    return run


@needs_wing("stand_ins")
def test_a_contact_sensor_reads_the_contacts_of_the_engine(printed):
    lines, _ = printed(f"""{APP}
from isaacsim.core.api import World
from isaacsim.core.api.objects import DynamicCuboid
from isaacsim.sensors.physics import ContactSensor
world = World()
world.scene.add_default_ground_plane()
world.scene.add(DynamicCuboid(prim_path="/World/c", name="c", position=[2, 0, 0.5], size=1.0, mass=2.0))
sensor = ContactSensor(prim_path="/World/c/contact", name="contact", min_threshold=0, max_threshold=1e6, radius=-1)
sensor.add_raw_contact_data_to_frame()
world.reset()
for _ in range(60):
    world.step(render=False)
frame = sensor.get_current_frame()
raw = frame["contacts"]
print(frame["number_of_contacts"] == len(raw), {{one["body0"] for one in raw}}, len({{one["body1"] for one in raw}}))
print([round(float(x), 2) + 0.0 for x in sum(one["impulse"] / one["dt"] for one in raw)])
print({{tuple(round(float(x), 3) + 0.0 for x in one["normal"]) for one in raw}})
print(sorted({{tuple(abs(round(float(x - c), 1)) for x, c in zip(one["position"], (2, 0, 0))) for one in raw}}))
app.close()
""")
    assert lines[0] == "True {'/World/c'} 1"
    assert lines[1] == "[0.0, 0.0, 19.62]"  # m g = 2 * 9.81
    assert lines[2] == "{(0.0, 0.0, 1.0)}"  # towards the body
    assert lines[3] == "[(0.5, 0.5, 0.0)]"  # the corners of the cube on the ground


def test_deformable_materials_keep_their_moduli_where_the_engine_reads_them(printed):
    lines, _ = printed(f"""{APP}
from isaacsim.core.experimental.materials import SurfaceDeformableMaterial, VolumeDeformableMaterial
import omni.usd
soft = VolumeDeformableMaterial("/Soft", youngs_moduli=[2e4], poissons_ratios=[0.25], densities=[300])
stage = omni.usd.get_context().get_stage()
prim = stage.GetPrimAtPath("/Soft")
print([prim.GetAttribute("omniphysics:" + name).Get() for name in ("youngsModulus", "poissonsRatio", "density")])
print(soft.get_youngs_moduli().numpy().tolist(), soft.get_poissons_ratios().numpy().tolist())
print(round(float(SurfaceDeformableMaterial("/Cloth").get_poissons_ratios()[0, 0]), 3))
app.close()
""")
    assert lines == ["[20000.0, 0.25, 300.0]", "[[20000.0]] [[0.25]]", "0.3"]


def test_graphs_know_the_graphs_below_them(printed):
    lines, _ = printed(
        GRAPH
        + """
below = graph.create_subgraph("Below")
print(below.get_path_to_graph(), [one.path for one in graph.get_subgraphs()], below.get_parent_graph() == graph)
print(graph.get_subgraph("Below") == below, graph.get_subgraph("No"), graph.get_parent_graph())
app.close()
"""
    )
    assert lines == ["/G/Below ['/G/Below'] True", "True None None"]


def test_metadata_and_the_type_of_a_variable_are_kept(printed):
    lines, _ = printed(
        GRAPH
        + """
a = nodes[1].get_attribute("inputs:a")
b = nodes[1].get_attribute("inputs:b")
print(a.set_metadata("uiName", "left"), a.get_metadata("uiName"), b.get_metadata("uiName"))
speed = graph.find_variable("speed")
print(speed.set_type(og.Type(og.BaseDataType.INT)), speed.type.get_type_name(), speed.get())
app.close()
"""
    )
    assert lines == ["True left None", "True int 0"]


def test_an_instance_that_does_not_exist_is_an_error(run_script):
    text = GRAPH + 'nodes[0].get_attribute("outputs:time").get(instance=2)\n'
    code, _, err = run_script(text)
    assert code == 1
    assert "there is no instance 2; the graph has 0" in err


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("graph.get_event_stream()", "omni.graph.core.Graph.get_event_stream"),
        ("graph.register_error_status_change_callback(print)", "Graph.register_error_status_change_callback"),
        ("nodes[1].register_on_connected_callback(print)", "Node.register_on_connected_callback"),
        ("nodes[1].resolve_coupled_attributes([])", "Node.resolve_coupled_attributes"),
        ('nodes[1].get_attribute("inputs:a").set_resolved_type(og.Type(og.BaseDataType.INT))', "set_resolved_type"),
        ('nodes[0].get_attribute("outputs:time").get(on_gpu=True)', "on_gpu"),
        ('from omni.kit.app import get_app; m = get_app().get_extension_manager(); '
         'm.set_extension_enabled_immediate("omni.anim.people", True)', "extension omni.anim.people"),
        ("import omni.timeline; omni.timeline.get_timeline_interface().set_prerolling(True)", "set_prerolling"),
    ],
)  # fmt: skip
def test_what_has_no_effect_says_so_once_and_strict_refuses_it(run_script, line, said):
    code, _, err = run_script(f"{GRAPH}for _ in range(2):\n    {line}\napp.close()\n")
    assert code == 0, err
    told = [one for one in err.splitlines() if one.startswith("warning isaac-inert")]
    assert len(told) == 1
    assert said in told[0]
    code, _, err = run_script(f"{GRAPH}{line}\napp.close()\n", "--strict")
    assert code == 1
    assert said in err


def test_extensions_that_are_here_need_no_message(printed):
    _, err = printed(f"""{APP}
from isaacsim.core.utils.extensions import enable_extension
for name in ("isaacsim.ros2.bridge", "isaacsim.sensors.rtx", "omni.graph.action", "isaacsim.core.nodes"):
    assert enable_extension(name)
app.close()
""")
    assert "isaac-inert" not in err


@pytest.mark.parametrize("task", ["FollowTarget", "PickPlace"])
def test_a_task_without_an_arm_says_so(run_script, task):
    text = f"{APP}from isaacsim.core.api import World\nfrom isaacsim.core.api.tasks import {task}\n"
    code, _, err = run_script(f"{text}world = World()\nworld.add_task({task}('t'))\nworld.reset()\n")
    assert code == 1
    assert f"{task} has no set_robot(); write one that returns the arm" in err


def test_commands_act_on_all_their_arguments(printed):
    lines, err = printed(f"""{APP}
import omni.kit.commands, omni.usd
stage = omni.usd.get_context().get_stage()
omni.kit.commands.execute("RangeSensorCreateLidar", path="/Lidar", min_range=0.5, rotation_rate=7.0, no_such=1)
print([stage.GetPrimAtPath("/Lidar").GetAttribute(name).Get() for name in ("minRange", "rotationRate")])
omni.kit.commands.execute("SelectPrims", old_selected_paths=[], new_selected_paths=["/Lidar"], expand_in_stage=True)
print(omni.usd.get_context().get_selection().get_selected_prim_paths())
omni.kit.commands.execute_argv("CreatePrim", ["prim_type=Cube", "prim_path=/Box"])
print(stage.GetPrimAtPath("/Box").GetTypeName())
omni.kit.commands.execute("ChangeProperty", prop_path="/Box.nothing", value=1, prev=None)
app.close()
""")
    assert lines == ["[0.5, 7.0]", "['/Lidar']", "Cube"]
    assert err.count("RangeSensorCreateLidar(no_such=...)") == 1
    assert "there is no property /Box.nothing" in err


def test_strict_fails_for_a_sensor_that_saw_nothing(run_script):
    text = f"""{APP}
from isaacsim.core.api import World
from isaacsim.sensors.rtx import LidarRtx
world = World()
lidar = LidarRtx(prim_path="/World/lidar", name="lidar")
lidar.attach_annotator("GenericModelOutput")
world.reset()
for _ in range(20):
    world.step()
app.close()
"""
    assert run_script(text)[0] == 0
    code, _, err = run_script(text, "--strict")
    assert code == 1
    assert "strict: sensor /World/lidar rendered" in err


@needs_wing("stand_ins")
def test_stand_ins_for_assets_are_said_once_each(printed):
    lines, err = printed(f"""{APP}
from isaacsim.core.utils.stage import add_reference_to_stage
from isaacsim.storage.native import get_assets_root_path
for prim, asset in (
    ("/A", "Robots/FrankaRobotics/FrankaPanda/franka.usd"), ("/B", "Robots/FrankaRobotics/FrankaPanda/franka.usd"),
    ("/C", "Robots/NVIDIA/Jetbot/jetbot.usd"), ("/D", "Environments/Grid/default_environment.usd"),
):
    print(len(add_reference_to_stage(f"{{get_assets_root_path()}}/Isaac/{{asset}}", prim).GetChildren()) > 0)
app.close()
""")
    assert lines == ["True"] * 4
    told = [one for one in err.splitlines() if one.startswith("warning asset-stand-in")]
    assert [one.count("its 9 joints") for one in told] == [1, 0, 0]


def test_values_of_an_instance_are_its_own():
    with graph.isaac.importable(), App() as app:
        og = import_module("omni.graph.core")

        keys = og.Controller.Keys
        made, nodes, _, _ = og.Controller.edit("/G", {keys.CREATE_NODES: [("c", "omni.graph.nodes.ConstantInt")]})
        for path in ("/P", "/Q"):
            app.stage.DefinePrim(path)
        graphs = graphs_of(app)
        graphs.apply([replace(graphs.current_spec("/G"), instances={"/P": {}, "/Q": {}})], {})
        value = nodes[0].get_attribute("inputs:value")
        value.set(3)
        value.set(5, instance=1)
        assert made.get_instance_count() == 2
        assert [value.get(), value.get(instance=0), value.get(instance=1)] == [3, 3, 5]
        assert value.get_attribute_data(1).get() == 5


def test_undo_takes_back_what_commands_made_and_redo_makes_it_again(printed):
    """A prim that was there before stays. A group is taken back as a whole; a command that cannot be says so once."""
    lines, err = printed(f"""{APP}
import omni.kit.commands, omni.kit.undo, omni.usd
stage = omni.usd.get_context().get_stage()
def there():
    print([name for name in ("Lidar", "Old", "Box", "Ball", "Own") if stage.GetPrimAtPath(f"/{{name}}")])
class Own(omni.kit.commands.Command):
    def do(self):
        stage.DefinePrim("/Own")
    def undo(self):
        stage.RemovePrim("/Own")
omni.kit.commands.register(Own)
stage.DefinePrim("/Old", "Xform")
omni.kit.commands.execute("IsaacSensorCreateRtxLidar", path="/Lidar")
omni.kit.undo.undo()
there()
omni.kit.undo.redo()
there()
with omni.kit.undo.group():
    omni.kit.commands.execute("CreatePrim", prim_type="Cube", prim_path="/Box")
    omni.kit.commands.execute("CreatePrim", prim_type="Sphere", prim_path="/Ball")
    omni.kit.commands.execute("Own")
there()
print(omni.kit.undo.undo())
there()
print(omni.kit.undo.redo())
there()
omni.kit.commands.execute("CreatePrim", prim_type="Xform", prim_path="/Old")
print([omni.kit.undo.undo(), omni.kit.undo.undo(), omni.kit.undo.redo()])
there()
app.close()
""")
    assert lines == [
        *("['Old']", "['Lidar', 'Old']", "['Lidar', 'Old', 'Box', 'Ball', 'Own']"),
        *("True", "['Lidar', 'Old']", "True", "['Lidar', 'Old', 'Box', 'Ball', 'Own']"),
        *("[False, True, True]", "['Lidar', 'Old', 'Box', 'Ball', 'Own']"),
    ]
    assert err.count("omni.kit.undo.undo of CreatePrim") == 1


def test_sensors_of_physx_are_made_and_read_by_their_schemas(printed):
    """Several beams need a curtain length. An attribute that the schema does not have is refused."""
    lines, err = printed(f"""{APP}
import omni.kit.commands, omni.usd
from pxr import Gf, RangeSensorSchema
import omni.isaac.IsaacSensorSchema as IsaacSensorSchema
stage = omni.usd.get_context().get_stage()
_, lidar = omni.kit.commands.execute("RangeSensorCreateLidar", translation=Gf.Vec3d(1, 2, 3), horizontal_fov=90.0)
print([str(lidar.GetPath()), lidar.GetHorizontalFovAttr().Get(), lidar.GetHighLodAttr().Get(), bool(lidar)])
print(tuple(stage.GetPrimAtPath("/Lidar").GetAttribute("xformOp:translate").Get()))
lidar.CreateVerticalFovAttr(45.0)
print([RangeSensorSchema.Lidar(lidar.GetPrim()).GetVerticalFovAttr().Get(), hasattr(lidar, "GetNumRaysAttr")])
_, beams = omni.kit.commands.execute(
    "IsaacSensorCreateLightBeamSensor", num_rays=5, curtain_length=2.0, forward_axis=Gf.Vec3d(0, 1, 0)
)
print([beams.GetNumRaysAttr().Get(), tuple(beams.GetForwardAxisAttr().Get()), beams.GetMaxRangeAttr().Get()])
print([bool(IsaacSensorSchema.IsaacBaseSensor(one.GetPrim())) for one in (beams, lidar)])
print(omni.kit.commands.execute("IsaacSensorCreateLightBeamSensor", num_rays=5))
app.close()
""")
    assert lines == [
        "['/Lidar', 90.0, False, True]",
        "(1.0, 2.0, 3.0)",
        "[45.0, False]",
        "[5, (0.0, 1.0, 0.0), 100.0]",
        "[True, False]",
        "(True, None)",
    ]
    assert "num_rays=5 needs a curtain_length above 0" in err


def test_commands_of_rtx_sensors_make_one_in_spite_of_a_wrong_configuration(printed):
    """As in the product; a warning names the known ones, or what is left out."""
    lines, err = printed(f"""{APP}
import omni.kit.commands
for kind, config in (("Lidar", "no_such"), ("Radar", "no_such"), ("Lidar", "OS1")):
    usd = None if kind == "Radar" else "no.usd"
    done, prim = omni.kit.commands.execute(f"IsaacSensorCreateRtx{{kind}}", path="/A", config=config, usd_path=usd)
    print([done, str(prim.GetPath()), str(prim.GetTypeName())])
app.close()
""")
    assert lines == [
        "[True, '/A', 'OmniLidar']",
        "[True, '/A_01', 'OmniRadar']",
        "[True, '/A_02', 'OmniLidar']",
    ]
    assert "no lidar config 'no_such'" in err
    assert "there is no radar configuration 'no_such'" in err
    assert err.count("usd_path is left out") == 2
