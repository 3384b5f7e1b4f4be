"""Files of assets, meshes, the registry of a scene, and readings of sensors by their paths, as scripts ask for them."""

START = """from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
"""


def test_usd_files_below_a_folder_are_found_by_depth_pattern_and_exclusion(run_script, tmp_path):
    for name in ("a.usd", "b.txt", "Props/c.usda", "Props/deep/d.USDZ"):
        file = tmp_path / "assets" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("#usda 1.0\n")
    code, out, err = run_script(
        START
        + """from isaacsim.storage.native import find_filtered_files_async, find_files_recursive, resolve_asset_path
from isaacsim.storage.native import find_filtered_files as find
root = "omniverse://host/Isaac"
short = lambda found: sorted(one.removeprefix(root) for one in found)
print(short(find([root])), short(find([root], max_depth=1)))
print(short(find([root], None, ["Props"])), short(find([root], None, None, ["/a[.]", "deep"])))
print(short(find([root], None, None, ["Props", "deep"], True)), short(find([root + "/no"])))
print(short(app.run_coroutine(find_filtered_files_async(root, ["c[.]usda"]))), short(find_files_recursive([root])))
print(resolve_asset_path("/Props/c.usda"), resolve_asset_path("/none.usd"))
app.close()
""",
        "--asset-root",
        f"omniverse://host/Isaac={tmp_path / 'assets'}",
    )
    assert code == 0, err
    assert out.splitlines() == [
        "['/Props/c.usda', '/Props/deep/d.USDZ', '/a.usd'] ['/Props/c.usda', '/a.usd']",
        "['/a.usd'] ['/Props/deep/d.USDZ', '/a.usd']",
        "['/Props/deep/d.USDZ'] []",
        "['/Props/c.usda'] ['/Props/c.usda', '/Props/deep/d.USDZ', '/a.usd', '/b.txt']",
        "omniverse://host/Isaac/Props/c.usda None",
    ]


def test_paths_and_addresses_are_joined_and_compared(run_script):
    code, out, err = run_script(
        START
        + """from isaacsim.storage.native import is_local_path, path_dirname, path_join, path_relative
print(path_join("omniverse://s/a/b/", "./c.usd"), path_join("https://s/a/b", "../c.usd"), path_join("/a", "c.usd"))
print(path_dirname("omniverse://s/a/c.usd"), path_dirname("/a/c.usd"), path_relative("https://s/a/b/c", "https://s/a/"))
print(is_local_path(""), is_local_path("sftp://s/a"))
try:
    path_relative("https://s/a", "https://t/a")
except ValueError as error:
    print(error)
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "omniverse://s/a/b/c.usd https://s/a/c.usd /a/c.usd",
        "omniverse://s/a/ /a/ b/c",
        "True False",
        "https://s/a is on another server than https://t/a",
    ]


def test_a_registry_keeps_one_object_for_each_name(run_script):
    code, out, err = run_script(
        START
        + """from isaacsim.core.api.scenes import SceneRegistry
registry = SceneRegistry()
registry.add_robot(name="it", robot=1)
try:
    registry.add_xform_view("it", 2)
except ValueError as error:
    print(error)
print(registry.get_object("it"), registry.robots, registry.xform_prim_views, registry.name_exists("other"))
registry.remove_object("it")
print(registry.get_object("it"))
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "Cannot add the object it to the scene since its name is not unique",
        "1 {'it': 1} {} False",
        "None",
    ]


def test_contacts_and_motion_are_read_by_the_paths_of_sensors(run_script):
    # A cube of 2 kg at rest on the ground presses with 2 x 9.81 N; its IMU feels 9.81 m/s2 upwards.
    code, out, err = run_script(
        START
        + """import omni.kit.commands, omni.timeline
from isaacsim.core.experimental.objects import Cube, GroundPlane
from isaacsim.core.experimental.prims import GeomPrim, RigidPrim
from isaacsim.sensors.physics import _sensor
GroundPlane("/World/ground")
Cube("/World/Cube", sizes=1.0, positions=[0.0, 0.0, 0.5])
GeomPrim("/World/Cube", apply_collision_apis=True)
RigidPrim("/World/Cube", masses=[2.0])
omni.kit.commands.execute("IsaacSensorCreateContactSensor", path="/touch", parent="/World/Cube", max_threshold=1e7)
omni.kit.commands.execute("IsaacSensorCreateImuSensor", path="/imu", parent="/World/Cube")
touch, imu = _sensor.acquire_contact_sensor_interface(), _sensor.acquire_imu_sensor_interface()
print(touch.is_contact_sensor("/World/Cube/touch"), touch.get_sensor_reading("/World/Cube/touch").is_valid)
omni.timeline.get_timeline_interface().play()
for _ in range(90):
    app.update()
print(touch.is_contact_sensor("/World/Cube/touch"), touch.is_contact_sensor("/World/Cube"), imu.is_imu_sensor("/none"))
reading, raw = touch.get_sensor_reading("/World/Cube/touch"), touch.get_contact_sensor_raw_data("/World/Cube/touch")
print(reading.inContact, round(reading.value, 1), {touch.decode_body_name(one) for one in raw["body0"]})
of_body = touch.get_rigid_body_raw_data("/World/Cube")
print(round(float(sum(raw["impulse"]["z"] / raw["dt"])), 1), len(of_body) == len(raw))
felt = imu.get_sensor_reading("/World/Cube/imu")
print(felt.is_valid, round(felt.lin_acc_z, 1), [round(one, 2) + 0.0 for one in felt.orientation])
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "False False",
        "True False False",
        "True 19.6 {'/World/Cube'}",
        "19.6 True",
        "True 9.8 [0.0, 0.0, 0.0, 1.0]",
    ]


def test_faces_creases_and_corners_of_meshes_are_kept(run_script):
    code, out, err = run_script(
        START
        + """from isaacsim.core.experimental.objects import Mesh
mesh = Mesh(["/A", "/B"], primitives="Plane")
mesh.set_crease_specs([[0, 1, 2]], [[3]], [[2.0, 4.0]], indices=[1])
mesh.set_corner_specs([[3]], [[10.0]])
mesh.set_face_specs(varying_linear_interpolations=["all"], hole_indices=[[0]], indices=[0])
lists = lambda found: [one.list() for one in found]
print(*map(lists, mesh.get_crease_specs()), *map(lists, mesh.get_corner_specs()))
corners, counts, rules, holes = mesh.get_face_specs()
print(lists(corners)[1], lists(counts), rules, lists(holes))
for wrong in (([[0, 1]], [[3]], [[1.0]]), ([[0, 1, 2]], [[3]], [[1.0, 2.0, 3.0]])):
    try:
        mesh.set_crease_specs(*wrong)
    except AssertionError as error:
        print(error)
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "[[], [0, 1, 2]] [[], [3]] [[], [2.0, 4.0]] [[3], [3]] [[10.0], [10.0]]",
        "[0, 1, 2, 3] [[4], [4]] ['all', 'cornersPlus1'] [[0], []]",
        "the lengths of creases add up to 3, not 2 indices",
        "3 values of sharpness are not one a crease or one an edge",
    ]


def test_old_calls_for_non_visual_materials_take_names_and_numbers(run_script):
    code, out, err = run_script(
        START
        + """import omni.usd
from isaacsim.sensors.rtx import ATTR_BASE, apply_nonvisual_material, decode_material_id, get_material_id
from pxr import UsdGeom, UsdShade
stage = omni.usd.get_context().get_stage()
prim = UsdShade.Material.Define(stage, "/M").GetPrim()
print(apply_nonvisual_material(prim, 10, "paint_clearcoat", attribute=2), prim.GetAttribute(ATTR_BASE).Get())
print(get_material_id(prim), decode_material_id(get_material_id(prim)), decode_material_id(100))
other = UsdGeom.Xform.Define(stage, "/X").GetPrim()
print(apply_nonvisual_material(prim, "tim"), apply_nonvisual_material(other, "tin"), get_material_id(other))
try:
    decode_material_id(1 << 16)
except ValueError as error:
    print(error)
app.close()
"""
    )
    assert code == 0, err
    # base 10, coating 3, attribute 2: 10 + 3 x 256 + 2 x 2048.
    assert out.splitlines() == [
        "True tin",
        "4874 ('tin', 'paint_clearcoat', 'retroreflective') ('none', 'none', 'none')",
        "False False 0",
        "material id 65536 is outside valid uint16 range",
    ]
    assert "material-unknown" in err


def test_a_schema_is_found_by_stage_and_path_and_by_prim_and_instance(run_script):
    code, out, err = run_script(
        START
        + """import omni.usd
from pxr import PhysxSchema, UsdPhysics
stage = omni.usd.get_context().get_stage()
prim = UsdPhysics.Scene.Define(stage, "/physics").GetPrim()
PhysxSchema.PhysxSceneAPI.Apply(prim)
print(PhysxSchema.PhysxSceneAPI.Get(stage, "/physics").CreateEnableCCDAttr(True).GetName())
print(PhysxSchema.PhysxLimitAPI.Get(prim, "linear").CreateStiffnessAttr(2.0).GetName())
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["physxScene:enableCCD", "physxLimit:linear:stiffness"]


def test_a_command_takes_the_former_attribute_for_the_level_of_a_lidar(run_script):
    code, out, err = run_script(
        START
        + """import omni.kit.commands
options = {"omni:sensor:Core:auxOutputType": "FULL", "omni:sensor:Core:scanRateBaseHz": 20.0}
_, prim = omni.kit.commands.execute("IsaacSensorCreateRtxLidar", path="lidar", **options)
level = prim.GetAttribute("_replicator:rendervar:GenericModelOutput:channels").Get()
print(prim.GetAttribute("omni:sensor:Core:scanRateBaseHz").Get(), list(level))
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["20 ['FULL']"]
    assert "unknown-attribute" not in err


def test_step_subscriptions_of_physx_get_the_time_alone_and_those_of_physics_a_context_too(run_script):
    code, out, err = run_script("""
from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import omni.physics.core, omni.physx, omni.timeline
told = []
kept = [
    omni.physx.get_physx_interface().subscribe_physics_on_step_events(lambda dt: told.append("before"), True, 0),
    omni.physx.get_physx_interface().subscribe_physics_on_step_events(fn=told.append, pre_step=False, order=1),
    omni.physics.core.get_physics_simulation_interface().subscribe_physics_on_step_events(
        on_update=lambda dt, context: told.append("core"), pre_step=False, order=2
    ),
]
omni.timeline.get_timeline_interface().play()
app.update()
kept.clear()
app.update()
print([one if isinstance(one, str) else round(one * 60, 6) for one in told])
app.close()
""")
    assert code == 0, err
    assert out.splitlines() == ["['before', 1.0, 'core']"]


def test_inputs_of_a_material_are_those_of_its_shader(run_script):
    code, out, err = run_script("""
from isaacsim import SimulationApp
app = SimulationApp()
import omni.kit.commands, omni.usd
from pxr import Gf, Sdf, UsdShade
made = []
names = {"mdl_name": "OmniGlass.mdl", "mtl_name": "Glass"}
omni.kit.commands.execute("CreateAndBindMdlMaterialFromLibrary", **names, mtl_created_list=made)
stage = omni.usd.get_context().get_stage()
prim = stage.GetPrimAtPath(made[0])
omni.usd.create_material_input(prim, "glass_color", Gf.Vec3f(0, 1, 0), Sdf.ValueTypeNames.Color3f)
found = omni.usd.create_material_input(prim, "glass_ior", 1.5, Sdf.ValueTypeNames.Float, 1.4, 1.0, 4.0, "IOR", "Glass")
shader = UsdShade.Material(prim).ComputeSurfaceSource("mdl")[0]
print(shader.GetInput("glass_color").Get(), found.Get(), found.GetAttr().GetCustomData(), found.GetDisplayGroup())
try:
    omni.usd.create_material_input(stage.DefinePrim("/Nothing"), "x", 1, Sdf.ValueTypeNames.Int)
except ValueError as error:
    print(error)
app.close()
""")
    assert code == 0, err
    assert out.splitlines() == [
        "(0, 1, 0) 1.5 {'default': 1.4, 'range': {'max': 4.0, 'min': 1.0}} Glass",
        "/Nothing is neither a shader nor a material with one",
    ]


def test_extensions_are_found_by_name_and_by_the_start_of_their_version(run_script):
    code, out, err = run_script("""
from isaacsim import SimulationApp
app = SimulationApp()
import isaacsim.core.experimental.utils.app as app_utils
for name in ("isaacsim.core.nodes", "isaacsim.core.nodes-6.0", "isaacsim.core.nodes-0.1"):
    print(app_utils.get_extension_id(name))
found = app_utils.get_extension_dict("isaacsim.core.nodes")
print(sorted(found), found["package"])
app.close()
""")
    assert code == 0, err
    assert out.splitlines() == [
        "isaacsim.core.nodes-6.0.1",
        "isaacsim.core.nodes-6.0.1",
        "None",
        "['package', 'path'] {'id': 'isaacsim.core.nodes-6.0.1', 'name': 'isaacsim.core.nodes', 'version': '6.0.1'}",
    ]
