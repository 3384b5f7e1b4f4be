"""What wrappers of cameras, lights, materials, viewports and stages set is what they and the stage give back."""

import importlib.util

import pytest

APP = """
from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import omni.usd
stage = omni.usd.get_context().get_stage()
"""


@pytest.fixture
def printed(run_script):
    def run(text):
        code, out, err = run_script(APP + text)
        assert code == 0, err
        return out.splitlines()

    return run


def test_a_camera_counts_lengths_in_stage_units_and_its_prim_in_tenths(printed):
    assert printed("""
from isaacsim.core.experimental.objects import Camera
camera = Camera(["/A", "/B"])
camera.set_focal_lengths(2.4)
camera.set_apertures([2.0, 4.0], vertical_apertures=1.5)
camera.set_clipping_ranges(far_distances=50.0)
camera.set_projections("orthographic", indices=[1])
print(stage.GetPrimAtPath("/A").GetAttribute("focalLength").Get(), camera.get_focal_lengths().numpy().ravel().round(3))
print([one.numpy().ravel().round(3).tolist() for one in camera.get_apertures()])
print([one.numpy().ravel().tolist() for one in camera.get_clipping_ranges()], camera.get_projections())
camera.enforce_square_pixels([480, 640])  # 2.0 / (640 / 480) and 4.0 / (640 / 480)
print(camera.get_apertures()[1].numpy().ravel().round(3).tolist())
""") == [
        "24.0 [2.4 2.4]",
        "[[2.0, 4.0], [1.5, 1.5]]",
        "[[1.0, 1.0], [50.0, 50.0]] ['perspective', 'orthographic']",
        "[1.5, 3.0]",
    ]


def test_lights_and_shapes_take_colors_by_name_and_are_found_by_their_type(printed):
    assert printed("""
from isaacsim.core.experimental.objects import Cube, Light, Shape, SphereLight
light = SphereLight("/L", radii=0.25)
light.set_colors("#ff8000")
light.set_multipliers(specular_multipliers=0.5)
light.set_enabled_treat_as_points(True)
print(light.get_colors().numpy().round(2).tolist(), [one.numpy().tolist() for one in light.get_multipliers()])
print(stage.GetPrimAtPath("/L").GetAttribute("treatAsPoint").Get(), light.get_exposures().numpy().tolist())
Cube("/C").set_display_colors("0.5")
print([type(one).__name__ for one in Shape.fetch_instances(["/C", "/L"]) + Light.fetch_instances(["/C", "/L"])])
print(Shape.are_of_type(["/C", "/L"]).numpy().tolist())
""") == [
        "[[1.0, 0.5, 0.0]] [[[1.0]], [[0.5]]]",
        "True [[0.0]]",
        "['Cube', 'NoneType', 'NoneType', 'SphereLight']",
        "[True, False]",
    ]


def test_physics_materials_are_found_by_their_schemas_and_keep_what_they_are_given(printed):
    assert printed("""
import omni.kit.commands
from isaacsim.core.experimental.materials import PhysicsMaterial, RigidBodyMaterial, SurfaceDeformableMaterial
rigid = RigidBodyMaterial("/M/rigid", static_frictions=0.5, restitutions=0.25)
rigid.set_combine_modes("max", dampings="min")
rigid.set_compliant_contact_gains(1000.0, 5.0)
SurfaceDeformableMaterial("/M/cloth", youngs_moduli=1e4).set_surface_stiffnesses(1.0, bend_stiffnesses=3.0)
omni.kit.commands.execute("AddDeformableMaterial", stage=stage, path="/M/soft", youngsModulus=2e5)
found = PhysicsMaterial.fetch_instances(["/M/rigid", "/M/cloth", "/M/soft", "/M"])
print([type(one).__name__ for one in found])
print([one.numpy().item() for one in found[0].get_friction_coefficients()], found[0].get_combine_modes())
print(found[0].get_restitution_coefficients().numpy(), found[2].get_youngs_moduli().numpy())
print([one.numpy().item() for one in found[1].get_surface_stiffnesses()])
print(stage.GetPrimAtPath("/M/cloth").HasAPI("OmniPhysicsSurfaceDeformableMaterialAPI"))
""") == [
        "['RigidBodyMaterial', 'SurfaceDeformableMaterial', 'VolumeDeformableMaterial', 'NoneType']",
        "[0.5, 0.0] (['max'], ['average'], ['min'])",
        "[[0.25]] [[200000.]]",
        "[1.0, 0.0, 3.0]",
        "True",
    ]


def test_visual_materials_author_shaders_and_refuse_inputs_that_these_do_not_have(printed):
    assert printed("""
from isaacsim.core.experimental.materials import OmniPbrMaterial, PreviewSurfaceMaterial, VisualMaterial
OmniPbrMaterial("/M/paint").set_input_values("diffuse_color_constant", [0.5, 0.25, 0.0])
PreviewSurfaceMaterial("/M/plain").set_input_values("roughness", 0.75)
paint, plain = VisualMaterial.fetch_instances(["/M/paint", "/M/plain"])
print(type(paint).__name__, paint.get_input_values("diffuse_color_constant").numpy().tolist())
print(type(plain).__name__, plain.get_input_values("roughness").numpy().tolist())
print(stage.GetPrimAtPath("/M/plain/Shader").GetAttribute("info:id").Get())
try:
    plain.set_input_values("glass_color", 1.0)
except ValueError as error:
    print(str(error)[:47])
""") == [
        "OmniPbrMaterial [[0.5, 0.25, 0.0]]",
        "PreviewSurfaceMaterial [[0.75]]",
        "UsdPreviewSurface",
        "'glass_color' is not an input of PreviewSurface",
    ]


def test_material_ids_are_decoded_to_their_names(printed):
    assert printed("""
from isaacsim.core.experimental.materials import NonVisualMaterial
material = NonVisualMaterial(["/A", "/B"], bases=["steel", "asphalt"], coatings="paint")
material.set_attributes("emissive", indices=[1])
ids = NonVisualMaterial.encode_material_ids(material)
print(ids.numpy().ravel().tolist(), NonVisualMaterial.decode_material_ids(ids))
""") == ["[258, 2328] [('steel', 'paint', 'none'), ('asphalt', 'paint', 'emissive')]"]  # 2+256, 24+256+2048


def test_a_viewport_has_a_title_a_camera_and_a_size_of_its_own(printed):
    assert printed("""
from isaacsim.core.rendering_manager import ViewportManager
first = ViewportManager.create_viewport_window(camera="/OmniverseKit_Top")
ViewportManager.create_viewport_window(title="Mine", resolution=(64, 48))
print([one.title for one in ViewportManager.get_viewport_windows()], first.viewport_api.camera_path)
ViewportManager.set_resolution((320, 240), render_product_or_viewport="Viewport 2")
product = ViewportManager.get_render_product("Mine")
print([ViewportManager.get_resolution(one) for one in ("Viewport 2", "Mine")], product.GetResolutionAttr().Get())
print(ViewportManager.destroy_viewport_windows(include=["View.*"], exclude=["Viewport"]))
for call in (ViewportManager.get_resolution, ViewportManager.get_camera):
    try:
        call("/Nothing")
    except ValueError as error:
        print(error)
""") == [
        "['Viewport', 'Viewport 2', 'Mine'] /OmniverseKit_Top",
        "[(320, 240), (64, 48)] (64, 48)",
        "['Viewport 2']",
        "Unable to get resolution: unknown viewport or render product /Nothing",
        "Unable to get the camera: unknown viewport or render product /Nothing",
    ]


def test_a_camera_view_turns_to_the_target_also_straight_up_and_follows_the_point_of_interest(printed):
    lines = printed("""
from isaacsim.core.experimental.utils.xform import get_world_pose
from isaacsim.core.rendering_manager import ViewportManager
from pxr import Gf, Sdf, UsdGeom
UsdGeom.Camera.Define(stage, "/C")
def show():
    place, turn = get_world_pose("/C")
    w, x, y, z = map(float, turn.numpy())
    looks = Gf.Rotation(Gf.Quatd(w, x, y, z)).TransformDir(Gf.Vec3d(0, 0, -1))
    print([round(float(one), 3) + 0.0 for one in (*place.numpy(), *looks)])
ViewportManager.set_camera_view("/C", eye=[1, 0, 0], target=[1, 4, 0])
show()
ViewportManager.set_camera_view("/C", eye=[1, 0, 0], target=[1, 0, 2])
show()
interest = stage.GetPrimAtPath("/C").CreateAttribute("omni:kit:centerOfInterest", Sdf.ValueTypeNames.Vector3d)
interest.Set(Gf.Vec3d(1, 0, 2))
ViewportManager.set_camera_view("/C", target=[4, 0, 2], relative_tracking=True)
show()
print(interest.Get())
""")
    assert lines[:2] == ["[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]", "[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]"]
    assert lines[2:] == ["[4.0, 0.0, 0.0, 0.0, 0.0, 1.0]", "(4, 0, 2)"]


def test_a_camera_view_keeps_the_rotations_that_a_camera_has(printed):
    assert printed("""
import numpy as np
from isaacsim.core.utils.viewports import set_camera_view
camera = stage.GetPrimAtPath("/OmniverseKit_Persp")
set_camera_view(eye=np.array([0, 0, 0]), target=np.array([0, 0, 10]))
print(camera.GetAttribute("xformOp:rotateXYZ").Get())
set_camera_view(eye=np.array([5, 5, 5]), target=np.array([0, 0, 0]))  # atan(sqrt 2) = 54.74 degrees
print([round(one, 2) + 0.0 for one in camera.GetAttribute("xformOp:rotateXYZ").Get()])
""") == ["(0, 180, 0)", "[54.74, 0.0, 135.0]"]


def test_prims_are_moved_below_others_and_paths_that_cannot_be_are_refused(printed):
    assert printed("""
import isaacsim.core.experimental.utils.stage as stage_utils
for path in ("/World", "/World/A", "/World/B"):
    stage_utils.define_prim(path)
print(stage_utils.move_prim("/World/A", "/World/B"), stage_utils.move_prim("/World/B/A", "/World/C"))
for call, given in (
    (stage_utils.move_prim, ("/Nothing", "/World")),
    (stage_utils.move_prim, ("/World/C", "/Nothing/C")),
    (stage_utils.delete_prim, ("/Nothing",)),
):
    try:
        call(*given)
    except ValueError as error:
        print(error)
stage_utils.close_stage()
print(omni.usd.get_context().get_stage())
try:
    stage_utils.get_current_stage()
except ValueError as error:
    print(error)
print(stage_utils.create_new_stage(template="empty").GetDefaultPrim().GetPath())
""") == [
        "(True, '/World/B/A') (True, '/World/C')",
        "/Nothing is not a valid prim of the stage",
        "/Nothing/C has an unexisting parent; define it first",
        "/Nothing is not a valid prim of the stage",
        "None",
        "there is no stage; open one, or make SimulationApp(...) first",
        "/World",
    ]


def test_utilities_give_usdrt_objects_where_the_script_asks_for_them(printed):
    assert printed("""
import isaacsim.core.experimental.utils.backend as backend_utils
import isaacsim.core.experimental.utils.foundation as foundation_utils
import isaacsim.core.experimental.utils.prim as prim_utils
import isaacsim.core.experimental.utils.stage as stage_utils
import usdrt
with backend_utils.use_backend("usdrt"):
    made = stage_utils.define_prim("/World/A", "Cube")
    found = prim_utils.get_first_matching_child_prim("/", predicate=lambda prim, path: prim.GetTypeName() == "Cube")
    attribute = prim_utils.create_prim_attribute("/World/A", name="mine", type_name=usdrt.Sdf.ValueTypeNames.Float)
print(isinstance(made, usdrt.Usd.Prim), made == found, isinstance(attribute, usdrt.Usd.Attribute))
matching = prim_utils.find_matching_prim_paths("/World", traverse=True)
print(prim_utils.get_prim_attribute_value("/World/A", "size"), matching)
print(foundation_utils.resolve_value_type_name("color3f", backend="usdrt"))
try:
    foundation_utils.resolve_value_type_name("colour")
except ValueError as error:
    print(error)
""") == ["True True True", "2.0 ['/World', '/World/A']", "color3f", "'colour' is not the name of a type"]


def test_silent_timeline_changes_are_not_announced(printed):
    assert printed("""
import isaacsim.core.experimental.utils.app as app_utils
import omni.timeline
heard = []
stream = omni.timeline.get_timeline_interface().get_timeline_event_stream()
held = stream.create_subscription_to_pop_by_type(omni.timeline.TimelineEventType.PLAY, lambda event: heard.append(1))
app_utils.play(commit=None)
app.update()
print(app_utils.is_playing(), heard)
app_utils.stop()
app_utils.play()
print(heard)
""") == ["True []", "[1]"]


def test_an_extension_that_was_disabled_is_not_enabled(printed):
    assert printed("""
import isaacsim.core.experimental.utils.app as app_utils
print(app_utils.is_extension_enabled("isaacsim.core.nodes"), app_utils.get_extension_id("isaacsim.core.nodes"))
app_utils.enable_extension("isaacsim.core.nodes", enabled=False)
print(app_utils.is_extension_enabled("isaacsim.core.nodes"), app_utils.get_extension_id("isaacsim.core.nodes"))
""") == ["True isaacsim.core.nodes-6.0.1", "False None"]


@pytest.mark.skipif(importlib.util.find_spec("warp") is None, reason="needs warp-lang")
def test_results_are_arrays_of_warp_if_the_script_imports_it(printed):
    lines = printed("""
import isaacsim.core.experimental.utils.ops as ops_utils
from isaacsim.core.experimental.objects import Cube
cube = Cube("/C")
import warp as wp
print(isinstance(cube.get_sizes(), wp.array), cube.get_sizes().dtype is wp.float32)
cube.set_local_scales(wp.array([[1.0, 2.0, 3.0]]))
print(cube.get_local_scales().numpy().tolist(), cube.get_visibilities().dtype is wp.bool)
print(ops_utils.broadcast_to([1, 2], shape=(2, 2), dtype=wp.int32).numpy().tolist())
""")
    assert lines[-3:] == ["True True", "[[1.0, 2.0, 3.0]] True", "[[1, 2], [1, 2]]"]  # Warp greets in between


def test_a_script_that_does_not_import_warp_has_arrays_of_numpy_even_if_warp_is_loaded(printed):
    pytest.importorskip("warp")
    assert printed("""
import numpy
from isaacsim.core.experimental.objects import Cube
print(isinstance(Cube("/C", sizes=3.0).get_sizes(), numpy.ndarray))
""") == ["True"]


def test_boxes_hold_what_is_below_a_shape_and_old_ones_keep_the_scale(printed):
    assert printed("""
from isaacsim.core.utils.bounds import compute_aabb, compute_obb, create_bbox_cache, recompute_extents
from pxr import UsdGeom
outer = UsdGeom.Cube.Define(stage, "/outer")
inner = UsdGeom.Cube.Define(stage, "/outer/inner")
inner.AddTranslateOp().Set((5, 0, 0))
recompute_extents(outer, include_children=True)
cache = create_bbox_cache()
print(compute_aabb(cache, "/outer").tolist(), compute_aabb(cache, "/outer", include_children=True).tolist())
scaled = UsdGeom.Cube.Define(stage, "/scaled")
scaled.AddScaleOp().Set((1, 3, 1))
print([one.round(6).tolist() for one in compute_obb(create_bbox_cache(), "/scaled")[1:]])
""") == [
        "[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0] [-1.0, -1.0, -1.0, 6.0, 1.0, 1.0]",
        "[[[1.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 1.0]], [1.0, 1.0, 1.0]]",
    ]


def test_distances_versions_and_expressions_of_the_former_utilities(printed):
    assert printed("""
import numpy as np
from isaacsim.core.utils import distance_metrics
from isaacsim.core.utils.string import find_root_prim_path_from_regex
from isaacsim.core.version import parse_version
from pxr import Gf
quarter = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 0, 1), 90))
angle = distance_metrics.rotational_distance_angle(quarter, np.eye(4))
axis = distance_metrics.rotational_distance_single_axis(quarter, np.eye(3), [0, 0, 1])
place = distance_metrics.weighted_translational_distance(np.zeros(3), np.array([3.0, 4.0, 9.0]), np.diag([1, 1, 0]))
print(round(angle, 6), round(axis, 6), place)
print(find_root_prim_path_from_regex("/World/env_[0-9]/Robot"), find_root_prim_path_from_regex("/World/Cube"))
print(parse_version("6.0.1-beta.2+main.hash"))
""") == [
        "1.570796 0.0 5.0",
        "('/World', 2) ('/World/Cube', 2)",
        "Version(core='6.0.1', prerelease='beta.2', major='6', minor='0', patch='1', pretag='beta', prebuild='2', "
        "buildtag='main.hash')",
    ]


def test_commands_spawn_move_scale_and_remove_assets(printed, tmp_path):
    text = '#usda 1.0\n(defaultPrim = "P")\ndef Xform "P"\n{\n    def Cube "c"\n    {\n    }\n}\n'
    (tmp_path / "part.usda").write_text(text)
    assert printed(f"""
import omni.kit.commands
omni.kit.commands.execute(
    "IsaacSimSpawnPrim", usd_path={str(tmp_path / "part.usda")!r}, prim_path="/part", translation=(1, 2, 3)
)
omni.kit.commands.execute("IsaacSimScalePrim", prim_path="/part", scale=(2, 2, 2))
print(omni.usd.get_world_transform_matrix(stage.GetPrimAtPath("/part/c")).ExtractTranslation())
omni.kit.commands.execute("IsaacSimTeleportPrim", prim_path="/part", translation=(0, 0, 1))
print(stage.GetPrimAtPath("/part").GetAttribute("xformOp:scale").Get())
omni.kit.commands.execute("IsaacSimDestroyPrim", prim_path="/part")
print(bool(stage.GetPrimAtPath("/part")))
""") == ["(1, 2, 3)", "(2, 2, 2)", "False"]


def test_clones_inherit_their_source_or_copy_it_and_stand_in_a_grid(printed):
    assert printed("""
from isaacsim.core.cloner import GridCloner
from pxr import UsdGeom
UsdGeom.Cube.Define(stage, "/World/env_0/box")
cloner = GridCloner(spacing=2.0)
paths = cloner.generate_paths("/World/env", 3)
print(cloner.clone("/World/env_0", paths, position_offsets=[[0, 0, 1.0]] * 3))
cloner.clone("/World/env_0", ["/World/copy"] + paths[:0], copy_from_source=True)
stage.GetPrimAtPath("/World/env_0/box").GetAttribute("size").Set(5.0)
print([stage.GetPrimAtPath(f"/World/{one}/box").GetAttribute("size").Get() for one in ("env_2", "copy")])
print(stage.GetPrimAtPath("/World/env_2").GetAttribute("xformOp:translate").Get(), cloner.get_clone_transforms(0))
for source, offsets in ((None, None), ("no path!", None), ("/Nothing", None), ("/World/env_0", [[0, 0, 0]])):
    try:
        cloner.clone(source, ["/World/a", "/World/b"], position_offsets=offsets)
    except (TypeError, ValueError) as error:
        print(type(error).__name__)
""") == [  # two columns, two rows: x from 1 down, y from -1 up
        "[[1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, -1.0, 1.0]]",
        "[5.0, 2.0]",
        "(-1, -1, 1) ([], [])",
        "TypeError",
        "ValueError",
        "ValueError",
        "ValueError",
    ]


def test_prims_are_reset_to_the_default_state_that_each_was_given(printed):
    assert printed("""
from isaacsim.core.experimental.prims import Prim, XformPrim
for name in ("A", "B"):
    stage.DefinePrim(f"/World/{name}", "Xform")
prims = XformPrim("/World/[AB]", positions=[[0, 0, 1], [0, 0, 2]])
print(prims.get_default_state())
prims.set_default_state(positions=[0, 0, 5], indices=[1])
prims.reset_to_default_state()
print(prims.get_world_poses()[0].numpy().tolist(), prims.get_default_state(indices=[1])[0].numpy().tolist())
print(Prim.resolve_paths("/World/A"), Prim.resolve_paths("/World/New"))
for paths in ("/World/X.*", ["/World/A", "/World/New"]):
    try:
        Prim.resolve_paths(paths)
    except ValueError:
        print("refused")
print(stage.GetPrimAtPath("/World/A").HasAPI("NewtonSceneAPI"))
""") == [
        "(None, None)",
        "[[0.0, 0.0, 1.0], [0.0, 0.0, 5.0]] [[0.0, 0.0, 5.0]]",
        "(['/World/A'], []) ([], ['/World/New'])",
        "refused",
        "refused",
        "False",
    ]


def test_a_stage_outlives_many_new_ones_and_a_file_that_cannot_be_opened(printed):
    assert printed("""
import isaacsim.core.experimental.utils.stage as stage_utils
context = omni.usd.get_context()
for number in range(3):
    stage_utils.create_new_stage()
    stage_utils.get_stage_id(context.get_stage())
    app.update()
print(context.open_stage("/nowhere.usda"), context.get_stage().DefinePrim("/A", "Xform").GetPath())
""") == ["False /A"]
