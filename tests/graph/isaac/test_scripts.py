"""Scripts in Isaac Sim's API, with the numbers that they must see."""

import pytest

APP = "from isaacsim import SimulationApp\napp = SimulationApp({'headless': True})\n"
ROBOT = """
import omni.usd
from pxr import UsdGeom, UsdPhysics
stage = omni.usd.get_context().get_stage()
stage.DefinePrim("/World/robot", "Xform")
for name, x in (("base", 0.0), ("arm", 0.5)):
    cube = UsdGeom.Cube.Define(stage, f"/World/robot/{name}")
    cube.CreateSizeAttr(0.2)
    UsdGeom.XformCommonAPI(cube).SetTranslate((x, 0, 1))
    UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath("/World/robot"))
fixed = UsdPhysics.FixedJoint.Define(stage, "/World/robot/fixed")
fixed.CreateBody1Rel().SetTargets(["/World/robot/base"])
fixed.CreateLocalPos0Attr((0, 0, 1))
hinge = UsdPhysics.RevoluteJoint.Define(stage, "/World/robot/hinge")
hinge.CreateBody0Rel().SetTargets(["/World/robot/base"])
hinge.CreateBody1Rel().SetTargets(["/World/robot/arm"])
hinge.CreateAxisAttr("Z")
hinge.CreateLocalPos0Attr((0.5, 0, 0))
drive = UsdPhysics.DriveAPI.Apply(hinge.GetPrim(), "angular")
drive.CreateStiffnessAttr(1000)
drive.CreateDampingAttr(100)
"""


@pytest.fixture
def printed(run_script):
    """What a script prints; it must end well."""

    def run(text, *options):
        code, out, err = run_script(text, *options)
        assert code == 0, err
        return out.splitlines()

    return run


def test_a_lidar_and_a_radar_measure_in_a_standalone_script(printed):
    lines = printed(f"""{APP}
import omni
import carb
from isaacsim.core.experimental.objects import Cube, GroundPlane
from isaacsim.sensors.experimental.rtx import Lidar, LidarSensor, Radar, RadarSensor, parse_generic_model_output_data
GroundPlane("/World/ground")
cube = Cube("/World/cube", sizes=1.0, positions=[[5.0, 0.0, 0.5]])
lidar = Lidar("/World/lidar", tick_rate=10.0, translations=[0, 0, 1])
sensor = LidarSensor(lidar, annotators=["generic-model-output"])
radar = RadarSensor(Radar("/World/radar", tick_rate=20.0), annotators=["generic-model-output"])
print(lidar.paths, str(sensor.render_product.GetPath()) == sensor.render_product.path, cube.get_world_poses()[0].list())
omni.timeline.get_timeline_interface().play()
frames = set()
for _ in range(13):
    app.update()
    data, info = sensor.get_data("generic-model-output")
    if data is not None:
        gmo = parse_generic_model_output_data(data)
        frames.add((gmo.timestampNs, gmo.numElements > 1000))
    parse_generic_model_output_data(radar.get_data("generic-model-output")[0]).numElements
print(sorted(frames))
omni.timeline.get_timeline_interface().stop()
app.close()
""")
    assert lines[0] == "['/World/lidar'] True [[5.0, 0.0, 0.5]]"
    assert lines[1] == "[(0, True), (100000000, True)]"  # 13 updates at 60 Hz pass 0.1 s and 0.2 s


def test_frames_are_reported_after_the_script_has_stopped(run_script):
    code, _, err = run_script(f"""{APP}
from isaacsim.sensors.experimental.rtx import Lidar, LidarSensor
import isaacsim.core.experimental.utils.app as app_utils
sensor = LidarSensor(Lidar("/World/lidar", tick_rate=10.0), annotators=["generic-model-output"])
app_utils.play()
app_utils.update_app(steps=30)
app_utils.stop()
app.close()
""")
    assert code == 0
    assert "5 of 5" in err


def test_a_cube_falls_in_a_world(printed):
    lines = printed(f"""{APP}
import numpy as np
from isaacsim.core.api import World
from isaacsim.core.api.objects import DynamicCuboid
world = World(stage_units_in_meters=1.0)
world.scene.add_default_ground_plane()
cube = world.scene.add(DynamicCuboid(prim_path="/World/cube", name="cube", position=np.array([0, 0, 1.0]), size=0.5))
dts = []
world.add_physics_callback("count", dts.append)
world.reset()
while world.current_time_step_index < 60:
    world.step(render=True)
print(round(float(cube.get_world_pose()[0][2]), 2), world.current_time, round(cube.get_mass(), 3))
world.step(render=False)
print(world.current_time_step_index, len(dts))
world.reset()
print(cube.get_world_pose()[0].tolist())
cube.set_linear_velocity(np.array([1.0, 0, 0]))
print(World.instance() is world, World() is world, world.scene.get_object("cube") is cube)
app.close()
""")
    assert lines == ["0.25 1.0 0.02", "61 61", "[0.0, 0.0, 1.0]", "True True True"]


def test_a_graph_publishes_and_a_writer_too(run_script):
    code, out, err = run_script(f"""{APP}
import omni.graph.core as og
import omni.kit.commands
import omni.replicator.core as rep
import usdrt.Sdf
from pxr import Gf
from isaacsim.core.api import SimulationContext
from isaacsim.core.utils import extensions, prims
from isaacsim.core.nodes.scripts.utils import set_target_prims
assert extensions.enable_extension("isaacsim.ros2.bridge")
context = SimulationContext(physics_dt=1 / 60, rendering_dt=1 / 60, stage_units_in_meters=1.0)
prims.create_prim("/World/box", "Cube", position=[3, 0, 0], attributes={{"size": 2.0}})
done, sensor = omni.kit.commands.execute(
    "IsaacSensorCreateRtxLidar", path="/sensor", parent=None, translation=(0, 0, 1.0), orientation=Gf.Quatd(1, 0, 0, 0)
)
sensor.GetAttribute("omni:sensor:tickRate").Set(10)
texture = rep.create.render_product(sensor.GetPath(), [1, 1], name="Isaac")
writer = rep.writers.get("RtxLidarROS2PublishPointCloud")
writer.initialize(topicName="points", frameId="sensor")
writer.attach([texture])
keys = og.Controller.Keys
og.Controller.edit(
    {{"graph_path": "/ActionGraph", "evaluator_name": "execution"}},
    {{
        keys.CREATE_NODES: [
            ("Time", "isaacsim.core.nodes.IsaacReadSimulationTime"),
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
            ("TF", "isaacsim.ros2.bridge.ROS2PublishTransformTree"),
        ],
        keys.CONNECT: [
            ("Tick.outputs:tick", "Clock.inputs:execIn"),
            ("Tick.outputs:tick", "TF.inputs:execIn"),
            ("Time.outputs:simulationTime", "Clock.inputs:timeStamp"),
        ],
        keys.SET_VALUES: [
            ("Clock.inputs:topicName", "clock"),
            ("TF.inputs:targetPrims", [usdrt.Sdf.Path("/World/box")]),
        ],
    }},
)
set_target_prims(
    primPath="/ActionGraph/TF", inputName="inputs:targetPrims", targetPrimPaths=["/World/box", sensor.GetPath()]
)
print(og.Controller.get(og.Controller.attribute("/ActionGraph/TF.inputs:targetPrims")))
context.play()
for _ in range(11):
    app.update()
app.close()
""")
    assert code == 0, err
    assert out.strip() == "['/World/box', '/sensor']"
    lines = {line.split()[0]: line.split()[1] for line in err.splitlines() if line.strip().startswith("/")}
    assert (lines["/clock"], lines["/tf"], lines["/points"]) == ("12", "12", "1")
    # play() makes an update without physics; 11 steps end at 0.183 s, so one turn at 10 Hz is whole


def test_the_stage_is_replaced_and_its_prims_can_be_removed(printed, tmp_path):
    (tmp_path / "scene.usda").write_text(
        '#usda 1.0\n(\n    defaultPrim = "W"\n    metersPerUnit = 1\n    upAxis = "Z"\n)\n'
        'def Xform "W"\n{\n    def Cube "c"\n    {\n    }\n}\n'
    )
    lines = printed(f"""{APP}
import omni.usd
import omni.kit.app
from isaacsim.core.utils.stage import add_reference_to_stage, get_current_stage
context = omni.usd.get_context()
first = context.get_stage()
timeline_before = omni.timeline.get_timeline_interface()
print(context.open_stage({str(tmp_path / "scene.usda")!r}), context.get_stage() is first)
stage = context.get_stage()
print(bool(stage.GetPrimAtPath("/W/c")), stage.RemovePrim("/W/c"), bool(stage.GetPrimAtPath("/W/c")))
print(context.open_stage("/nowhere.usda"), context.get_stage() is stage)
print(context.new_stage(), bool(context.get_stage().GetPrimAtPath("/W")), timeline_before.is_stopped())
add_reference_to_stage({str(tmp_path / "scene.usda")!r}, "/World/ref")
print(bool(get_current_stage().GetPrimAtPath("/World/ref/c")))
app.close()
""")
    assert lines == ["True False", "True True False", "False True", "True False True", "True"]
    assert 'def Cube "c"' in (tmp_path / "scene.usda").read_text()


def test_event_streams_follow_updates_and_the_timeline(printed):
    lines = printed(f"""{APP}
import omni.kit.app, omni.timeline, carb.eventdispatcher
seen = []
timeline = omni.timeline.get_timeline_interface()
kinds = omni.timeline.TimelineEventType
a = omni.kit.app.get_app().get_update_event_stream().create_subscription_to_pop(lambda e: seen.append("u"), name="x")
b = timeline.get_timeline_event_stream().create_subscription_to_pop_by_type(
    int(kinds.STOP), lambda e: seen.append("stop"))
c = carb.eventdispatcher.get_eventdispatcher().observe_event(
    observer_name="o", event_name=omni.timeline.GLOBAL_EVENT_PLAY, on_event=lambda e: seen.append("play"))
timeline.play()
app.update()
a = None
timeline.stop()
app.update()
print(seen)
async def later():
    await omni.kit.app.get_app().next_update_async()
    return 5
print(app.run_coroutine(later()))
app.close()
""")
    assert lines == ["['play', 'u', 'stop']", "5"]


def test_an_articulation_follows_its_targets(printed):
    lines = printed(f"""{APP}{ROBOT}
import numpy as np
from isaacsim.core.experimental.prims import Articulation, RigidPrim
from isaacsim.core.prims import SingleArticulation
from isaacsim.core.utils.types import ArticulationAction
import isaacsim.core.experimental.utils.app as app_utils
robot = Articulation("/World/robot")
print(robot.dof_names, robot.get_dof_positions().list())
app_utils.play()
robot.set_dof_position_targets([0.5], dof_indices=robot.get_dof_indices("hinge"))
app_utils.update_app(steps=120)
print(np.round(robot.get_dof_positions().numpy(), 3).tolist())
one = SingleArticulation("/World/robot", "robot")
one.initialize()
one.apply_action(ArticulationAction(joint_positions=np.array([-0.25])))
app_utils.update_app(steps=120)
print(np.round(one.get_joint_positions(), 3).tolist(), one.num_dof)
robot.set_dof_positions([0.125])
print(robot.get_dof_positions().list(), RigidPrim("/World/robot/arm").get_world_poses()[0].list())
app.close()
""")
    assert lines == [
        "['hinge'] [[0.0]]",
        "[[0.5]]",
        "[-0.25] 1",
        "[[0.125]] [[0.5, 0.0, 1.0]]",
    ]


def test_sensors_of_the_former_api(printed):
    lines = printed(f"""{APP}
import numpy as np
from isaacsim.core.api import World
from isaacsim.core.api.objects import DynamicCuboid, FixedCuboid
from isaacsim.sensors.camera import Camera
from isaacsim.sensors.physics import ContactSensor, IMUSensor
from isaacsim.sensors.rtx import LidarRtx
world = World()
world.scene.add_default_ground_plane()
cube = world.scene.add(DynamicCuboid(prim_path="/World/c", name="c", position=[2, 0, 0.5], mass=2.0))
imu = world.scene.add(IMUSensor(prim_path="/World/c/imu", name="imu"))
contact = ContactSensor(prim_path="/World/c/contact", name="contact", min_threshold=0, max_threshold=1e6, radius=-1)
camera = Camera(prim_path="/World/cam", position=np.array([0, 0, 0.5]), orientation=[1, 0, 0, 0], resolution=(64, 48))
lidar = LidarRtx(prim_path="/World/lidar", name="lidar", translation=[0, 0, 0.5], **{{"omni:sensor:tickRate": 10}})
world.reset()
camera.initialize()
camera.add_distance_to_image_plane_to_frame()
lidar.initialize()
lidar.attach_annotator("GenericModelOutput")
for _ in range(20):
    world.step(render=True)
frame = camera.get_current_frame()
print(sorted(frame), camera.get_rgba().shape, round(float(camera.get_depth()[24, 32]), 3))
print(sorted(lidar.get_current_frame()), len(lidar.get_current_frame()["GenericModelOutput"]) > 0)
print([round(float(one), 1) + 0.0 for one in imu.get_current_frame()["lin_acc"]])
reading = contact.get_current_frame()
print(reading["in_contact"], round(reading["force"]))
app.close()
""")
    assert lines[0] == "['distance_to_image_plane', 'rendering_frame', 'rendering_time', 'rgb', 'rgba'] (48, 64, 4) 1.5"
    assert lines[1] == "['GenericModelOutput', 'rendering_frame', 'rendering_time'] True"
    assert lines[2:] == ["[0.0, 0.0, 9.8]", "True 20"]  # m g = 2 * 9.81


def test_names_that_do_nothing_say_so_once_and_strict_refuses_them(run_script):
    text = f"""{APP}
import omni.ui as ui
window = ui.Window("title", width=3)
with window.frame:
    ui.Label("x")
    ui.Label("y")
app.close()
"""
    code, _, err = run_script(text)
    assert code == 0
    assert err.count("isaac-inert: omni.ui.Label") == 1
    code, _, err = run_script(text, "--strict")
    assert code == 1
    assert "script.py:5: omni.ui.Window" in err


MOTION = "isaacsim.robot_motion.motion_generation"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("import isaacsim.cortex.framework.df as df\ndf.DfNetwork()", "Cortex is not here"),
        (f"from {MOTION} import RmpFlow\nRmpFlow()", "motion generation is not here"),
        ("import omni.replicator.core as rep\nrep.randomizer.instantiate()", "this randomizer is not here"),
        ("import omni.usd\nomni.usd.get_contex()", "did you mean"),
        ("from omni.usd import nothing", "cannot import name"),
        ("import omni.no_such_thing", "No module named 'omni.no_such_thing'"),
        ("import torch_of_nobody", "No module named"),
    ],
)
def test_what_is_refused_names_the_line_and_the_reason(run_script, line, message):
    code, _, err = run_script(f"{APP}{line}\n")
    assert code == 1
    assert message in err
    assert f"script.py:{3 + line.count(chr(10))}: " in err


def test_old_names_stand_for_the_present_ones(run_script):
    code, out, err = run_script("""from omni.isaac.kit import SimulationApp
app = SimulationApp()
import omni.isaac.core.utils.prims as prims
from omni.isaac.core.objects import DynamicCuboid
from omni.isaac.wheeled_robots.controllers.differential_controller import DifferentialController
print(prims.is_prim_path_valid("/World"), DynamicCuboid(prim_path="/World/c").name)
print(DifferentialController(name="d", wheel_radius=0.5, wheel_base=1.0).forward([1.0, 1.0]).joint_velocities)
app.close()
""")
    assert code == 0, err
    assert out.splitlines() == ["False dynamic_cube", "[1. 3.]"]
    assert "isaac-old-name: omni.isaac.core.objects" in err


def test_a_writer_of_the_script_is_attached_to_a_sensor_by_its_name(printed):
    lines = printed("""from isaacsim import SimulationApp
app = SimulationApp()
import omni.replicator.core as rep, omni.timeline
from isaacsim.core.experimental.materials import OmniGlassMaterial
from isaacsim.core.experimental.objects import Cube
from isaacsim.sensors.experimental.rtx import Lidar, LidarSensor, parse_generic_model_output_data
class Count(rep.Writer):
    def __init__(self, least=1):
        self.data_structure = "renderProduct"
        self.annotators = [rep.annotators.get("GenericModelOutput")]
        self.least, self.frames = least, 0
    def write(self, data):
        for one in data["renderProducts"].values():
            raw = one["GenericModelOutput"]
            raw = raw["data"] if isinstance(raw, dict) else raw
            self.frames += parse_generic_model_output_data(raw).numElements >= self.least
rep.WriterRegistry.register(Count)
wall = Cube("/World/wall", sizes=2.0, positions=[[5.0, 0.0, 0.0]])
wall.apply_visual_materials(OmniGlassMaterial("/World/glass"))
wall.get_applied_visual_materials()[0].set_input_values("glass_color", [1.0, 0.5, 0.0])
sensor = LidarSensor(Lidar.create("/World/lidar", config="Example_Rotary"), annotators=[])
writer = sensor.attach_writer("Count", least=10)
omni.timeline.get_timeline_interface().play()
for _ in range(20):
    app.update()
print(writer.least, writer.frames > 0)
sensor.detach_writer("Count")
before = writer.frames
for _ in range(5):
    app.update()
print(writer.frames == before)
app.close()
""")
    assert lines == ["10 True", "True"]


def test_a_test_case_awaits_updates_of_the_application(printed):
    lines = printed("""from isaacsim import SimulationApp
app = SimulationApp()
import io, unittest, omni.kit.app, omni.kit.test, omni.usd
import omni.graph.core.tests as ogts
class TestStage(ogts.OmniGraphTestCase):
    async def setUp(self):
        await super().setUp()
        omni.usd.get_context().get_stage().DefinePrim("/Thing", "Cube")
    async def test_updates(self):
        before = omni.kit.app.get_app().get_update_number()
        await omni.kit.app.get_app().next_update_async()
        self.assertEqual(omni.kit.app.get_app().get_update_number(), before + 1)
        self.assertTrue(omni.usd.get_context().get_stage().GetPrimAtPath("/Thing"))
    def test_values(self):
        ogts.verify_values([1.0, 2.0], (1.0, 2.000001), "close")
        with self.assertRaisesRegex(ValueError, "far: Expected"):
            ogts.verify_values([1.0], [2.0], "far")
result = unittest.TextTestRunner(stream=io.StringIO()).run(
    unittest.defaultTestLoader.loadTestsFromTestCase(TestStage))
print(result.testsRun, result.wasSuccessful())
print(bool(omni.usd.get_context().get_stage().GetPrimAtPath("/Thing")))
app.close()
""")
    assert lines == ["2 True", "False"]
