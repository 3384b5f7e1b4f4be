"""`omni.replicator.core` in scripts: what the orchestrator captures, and the prims that calls author."""

import pytest

APP = "from isaacsim import SimulationApp\napp = SimulationApp({'headless': True})\n"
LOOKING_DOWN = f"""{APP}
import os
import numpy as np
import omni.replicator.core as rep
import omni.timeline, omni.usd, carb
from pxr import UsdGeom, UsdLux
stage = omni.usd.get_context().get_stage()
UsdLux.DomeLight.Define(stage, "/World/Dome").CreateIntensityAttr(500)
cube = UsdGeom.XformCommonAPI(UsdGeom.Cube.Define(stage, "/World/Cube"))
UsdGeom.XformCommonAPI(UsdGeom.Camera.Define(stage, "/World/Camera")).SetTranslate((0, 0, 6))
product = rep.create.render_product("/World/Camera", (8, 6))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir="frames", distance_to_image_plane=True)
writer.attach([product])
timeline = omni.timeline.get_timeline_interface()
def depths():
    names = sorted(os.listdir("frames")) if os.path.isdir("frames") else []
    return [round(float(np.load("frames/" + name)[3, 4]), 3) for name in names if name.endswith(".npy")]
"""


@pytest.fixture
def ran(run_script, tmp_path, monkeypatch):
    """(Lines that a script prints, stderr); it must end well."""
    monkeypatch.chdir(tmp_path)

    def run(text, *options):
        code, out, err = run_script(text, *options)
        assert code == 0, err
        return out.splitlines(), err

    return run


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
def test_a_step_of_no_time_captures_the_world_as_it_stands(ran, parity):
    """The cube's top is 5 m below the camera, then 4 m after it rises by 1 m: before play, and after 6 updates."""
    lines, _ = ran(
        f"""{LOOKING_DOWN}
rep.orchestrator.set_capture_on_play(False)
rep.orchestrator.step(delta_time=0.0)
cube.SetTranslate((0, 0, 1))
rep.orchestrator.step(delta_time=0.0)
print(depths(), timeline.get_current_time())
timeline.play()
for _ in range(6):
    app.update()
before = timeline.get_current_time()
cube.SetTranslate((0, 0, 2))
rep.orchestrator.step(delta_time=0.0, pause_timeline=False)
rep.orchestrator.wait_until_complete()
print(depths(), timeline.get_current_time() == before > 0, timeline.is_playing())
app.close()
""",
        "--parity",
        parity,
    )
    assert lines == ["[5.0, 4.0] 0.0", "[5.0, 4.0, 3.0] True True"]


def test_step_async_captures_too(ran):
    lines, _ = ran(f"""{LOOKING_DOWN}
async def capture():
    for _ in range(2):
        await rep.orchestrator.step_async(delta_time=0.0)
app.run_coroutine(capture())
print(len(depths()), timeline.get_current_time())
app.close()
""")
    assert lines == ["2 0.0"]


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
@pytest.mark.parametrize(
    "switch",
    [
        "rep.orchestrator.set_capture_on_play({})",
        "carb.settings.get_settings().set('/omni/replicator/captureOnPlay', {})",
    ],
)
def test_capture_on_play_decides_whether_played_updates_are_written(ran, switch, parity):
    """5 played updates, 2 steps, 5 played updates."""
    script = f"""{LOOKING_DOWN}
%s
for _ in range(2):
    timeline.play()
    for _ in range(5):
        app.update()
    timeline.pause()
    app.update()
    if not os.path.isdir("stepped"):
        os.mkdir("stepped")
        for _ in range(2):
            rep.orchestrator.step()
rep.orchestrator.wait_until_complete()
print(len(depths()))
app.close()
"""
    assert ran(script % switch.format(False), "--parity", parity)[0] == ["2"]


def test_with_capture_on_play_every_played_update_is_written(ran):
    lines, _ = ran(f"""{LOOKING_DOWN}
timeline.play()
for _ in range(5):
    app.update()
rep.orchestrator.step()
print(len(depths()), carb.settings.get_settings().get("/omni/replicator/captureOnPlay"))
app.close()
""")
    assert lines == ["6 True"]


def test_a_started_orchestrator_captures_each_update_until_it_stops(ran):
    lines, _ = ran(f"""{LOOKING_DOWN}
rep.orchestrator.set_capture_on_play(False)
rep.orchestrator.run_until_complete(num_frames=3, start_timeline=True)
rep.orchestrator.stop()
app.update()
print(len(depths()))
app.close()
""")
    assert lines == ["3"]


def test_a_writer_of_the_script_follows_capture_on_play(ran):
    lines, _ = ran(f"""{LOOKING_DOWN}
class Count(rep.Writer):
    def __init__(self):
        self.annotators, self.seen = ["distance_to_image_plane"], 0
    def write(self, data):
        self.seen += 1
rep.WriterRegistry.register(Count)
count = rep.WriterRegistry.get("Count", init_params={{}})
count.attach([product])
rep.orchestrator.set_capture_on_play(False)
timeline.play()
for _ in range(5):
    app.update()
rep.orchestrator.step(delta_time=0.0)
print(count.seen)
app.close()
""")
    assert lines == ["1"]


def test_a_step_says_that_subframes_have_no_effect(ran):
    _, err = ran(f"{LOOKING_DOWN}\nrep.orchestrator.step(rt_subframes=4)\napp.close()\n")
    assert "rt-subframes-ignored" in err


SCENE = f"""{APP}
import os
import numpy as np
import omni.replicator.core as rep
import omni.usd
from pxr import UsdGeom, UsdPhysics
stage = omni.usd.get_context().get_stage()
def at(path):
    pose = UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(path))
    return [round(float(x), 3) for x in pose.ExtractTranslation()]
"""


def test_functional_create_authors_prims_by_name_below_their_parent(ran):
    lines, _ = ran(f"""{SCENE}
rep.functional.create.xform(name="World")
light = rep.functional.create.dome_light(intensity=500, parent="/World", name="Dome")
labels = {{"class": "box"}}
cube = rep.functional.create.cube(
    position=(1, 2, 3), scale=(1, 2, 1), parent="/World", name="Cube", semantics=labels
)
again = rep.functional.create.cube(parent="/World", name="Cube")
cones = rep.functional.create_batch.cone(count=2, parent="/World")
print([str(prim.GetPath()) for prim in (light, cube, again, *cones)])
print(light.GetTypeName(), light.GetAttribute("inputs:intensity").Get())
print(cube.GetAttribute("size").Get(), at("/World/Cube"))
print(list(cube.GetAttribute("semantics:labels:class").Get()))
rep.functional.modify.semantics(cube, {{"class": "crate"}}, mode="replace")
rep.functional.modify.pose(cube, position_value=(0, 0, 1), rotation_value=(0, 0, 90))
rep.functional.physics.apply_rigid_body(cube)
rep.functional.physics.apply_collider([cube, again])
print(list(cube.GetAttribute("semantics:labels:class").Get()), at("/World/Cube"), again.HasAPI(UsdPhysics.CollisionAPI))
side = UsdGeom.XformCache().GetLocalToWorldTransform(cube).TransformDir((1, 0, 0))
print([round(float(x), 3) + 0.0 for x in side])
app.close()
""")
    assert lines == [
        "['/World/Dome', '/World/Cube', '/World/Cube_01', '/World/Cone', '/World/Cone_01']",
        "DomeLight 500.0",
        "1.0 [1.0, 2.0, 3.0]",
        "['box']",
        "['crate'] [0.0, 0.0, 1.0] True",
        "[0.0, 1.0, 0.0]",
    ]


def test_create_authors_items_that_modify_takes_and_cameras_that_see_them(ran):
    """A camera 5 m above the plane of 10 x 10 m looks down at it: depth 5; on the cube, raised to 1.5 m, 3.5 m."""
    lines, _ = ran(f"""{SCENE}
rep.create.light(light_type="dome", intensity=800)
plane = rep.create.plane(scale=10, semantics=[("class", "floor")])
cube = rep.create.cube(position=(0, 0, 0.5), semantics=[("class", "box")])
camera = rep.create.camera(position=(0, 0, 5), look_at=(0, 0, 0))
product = rep.create.render_product(camera, (32, 32))
depth = rep.AnnotatorRegistry.get_annotator("distance_to_image_plane").attach([product])
seen = rep.AnnotatorRegistry.get_annotator("semantic_segmentation").attach([product])
with cube:
    rep.modify.pose(position=(0, 0, 1.0))
rep.orchestrator.step(delta_time=0.0)
image = depth.get_data()
print(round(float(image[16, 16]), 3), round(float(image[0, 0]), 3))
print(sorted(one["class"] for one in seen.get_data()["info"]["idToLabels"].values()))
print(camera.GetPath(), [str(prim.GetPath()) for prim in cube.get_output_prims()["prims"]])
app.close()
""")
    assert lines == ["3.5 5.0", "['box', 'floor']", "/Replicator/Camera_Xform/Camera ['/Replicator/Cube_Xform']"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("rep.distribution.poisson(3)", "distribution.poisson: this distribution is not here; use uniform"),
        ("rep.distribution.normal((0, 0), (1, -1))", "the standard deviation is below 0"),
        ("rep.trigger.on_condition()", "trigger.on_condition: this trigger is not here; use on_frame"),
        ("rep.trigger.on_time(0)", "interval 0 s; give a time above 0"),
        ("rep.randomizer.instantiate([])", "randomizer.instantiate: this randomizer is not here; modify.pose"),
        ("rep.functional.randomizer.display_color([])", "randomizer.display_color: it is not here; draw a value"),
        ("rep.create.material_mdl()", "create.material_mdl: it is not here"),
        ("rep.create.material_omnipbr(bump=1.0)", "material_omnipbr(bump=...): it is not here"),
        ("rep.functional.create.cube(material='x')", "cube(material=...): it is not here"),
        ("rep.create.light(light_type='laser')", "light_type 'laser' is not one of Distant"),
    ],
)
def test_random_and_missing_calls_are_refused_with_their_reason(run_script, line, message):
    code, _, err = run_script(f"{SCENE}{line}\napp.close()\n")
    assert code == 1
    assert message in err


def test_functional_create_makes_lidars_and_radars_of_their_attributes(ran):
    lines, _ = ran(f"""{SCENE}
rep.functional.create.xform(name="World")
state = "omni:sensor:Core:emitterState:s002:"
attributes = {{"omni:sensor:Core:scanRateBaseHz": 20.0, state + "azimuthDeg": [0.0, 1.0]}}
lidar = rep.functional.create.omni_lidar(position=(0, 0, 2), parent="/World", name="Top", **attributes)
radar = rep.functional.create.omni_radar(name="Radar")
rows = rep.functional.create_batch.omni_lidar(count=2, parent="/World", name="Row")
item = rep.create.omni_lidar(position=(1, 0, 0))
print(lidar.GetPath(), lidar.GetTypeName(), at("/World/Top"), radar.GetTypeName(), [one.GetName() for one in rows])
print(lidar.GetAttribute("omni:sensor:Core:scanRateBaseHz").Get(), list(lidar.GetAttribute(state + "azimuthDeg").Get()))
print(item.GetPath(), str(rep.create.render_product(item, (1, 1)).GetPath()).startswith("/Render/"))
app.close()
""")
    assert lines == [
        "/World/Top OmniLidar [0.0, 0.0, 2.0] OmniRadar ['Row', 'Row_01']",
        "20 [0.0, 1.0]",
        "/Replicator/OmniLidar_Xform/OmniLidar True",
    ]


def test_functional_create_material_sets_the_inputs_of_an_mdl_file_and_binds_it(ran):
    lines, _ = ran(f"""{SCENE}
from pxr import UsdShade
cube = rep.functional.create.cube(name="Cube")
made = rep.functional.create.material(
    mdl="OmniPBR.mdl", bind_prims=[cube], diffuse_color_constant=(1, 0, 0), metallic_constant=0.5
)
wood = rep.functional.create.material(mdl="wood/Oak.mdl", parent="/World/Looks", name="Oak", shine=2.0, grain="oak.png")
red = UsdShade.Shader(made.GetChild("Shader"))
oak = UsdShade.Shader(wood.GetChild("Shader"))
print(made.GetPath(), red.GetSourceAsset("mdl").path, tuple(red.GetInput("diffuse_color_constant").Get()))
print(UsdShade.MaterialBindingAPI(cube).GetDirectBinding().GetMaterialPath())
print(wood.GetPath(), oak.GetSourceAsset("mdl").path, oak.GetInput("shine").Get(), oak.GetInput("grain").Get().path)
app.close()
""")
    assert lines == [
        "/Looks/OmniPBR OmniPBR.mdl (1.0, 0.0, 0.0)",
        "/Looks/OmniPBR",
        "/World/Looks/Oak wood/Oak.mdl 2.0 oak.png",
    ]


def test_a_writer_of_the_script_writes_pictures_and_arrays_through_a_backend(ran, tmp_path):
    """0.5 of a float image is 128 of 255, rounded to even: 127.5 becomes 128."""
    lines, _ = ran(f"""{LOOKING_DOWN}
from omni.replicator.core import BackendDispatch
from omni.replicator.core.scripts.functional import write_np
disk = rep.backends.get("DiskBackend")
disk.initialize(output_dir="made")
disk.schedule(rep.functional.write_image, path="grey.png", data=np.full((2, 2), 0.5, np.float32))
disk.schedule(rep.functional.write_json, path="deep/a.json", data={{"size": np.int64(3)}})
old = BackendDispatch({{"paths": {{"out_dir": "made"}}}})
old.schedule(write_np, path="b.npy", data=np.arange(3))
old.write_image("rgb.jpg", np.zeros((2, 2, 4), np.uint8))
rep.BackendDispatch.wait_until_done()
basic = rep.writers.get("BasicWriter")
basic.initialize(backend=disk, distance_to_camera=True)
basic.attach(product)
rep.orchestrator.step(delta_time=0.0)
print(sorted(os.listdir("made")), open("made/deep/a.json").read(), np.load("made/b.npy").tolist())
app.close()
""")
    files = "['b.npy', 'deep', 'distance_to_camera_0000.npy', 'grey.png', 'rgb.jpg']"
    assert lines == [f'{files} {{"size": 3}} [0, 1, 2]']
    from PIL import Image

    assert Image.open(tmp_path / "made" / "grey.png").getpixel((0, 0)) == 128


def test_an_augmented_annotator_gives_changed_data_and_a_device_is_only_said(ran):
    lines, err = ran(f"""{LOOKING_DOWN}
rgb = rep.annotators.get("LdrColor", device="cuda").augment("RgbaToRgb")
double = rep.AnnotatorRegistry.Augmentation.from_function(lambda data, factor=1.0: data * factor)
depth = rep.AnnotatorRegistry.get_annotator("distance_to_camera").augment(double, factor=2.0)
rgb.attach(product), depth.attach([product])
rep.orchestrator.step(delta_time=0.0)
plain = rep.AnnotatorRegistry.get_annotator("distance_to_camera").attach(product)
rep.orchestrator.step(delta_time=0.0)
print(rgb.get_data().shape, round(float(depth.get_data()[3, 4] / plain.get_data()[3, 4]), 6))
app.close()
""")
    assert lines == ["(6, 8, 3) 2.0"]
    assert "annotator-on-host: LdrColor" in err


def test_missing_assets_of_create_are_said_and_generators_repeat_their_numbers(ran):
    lines, err = ran(f"""{SCENE}
rep.create.from_usd("/nowhere/cup.usd")
rep.functional.create.reference(usd_path="/nowhere/plate.usd", name="Plate")
first, second = (rep.rng.ReplicatorRNG(seed=7).generator.uniform() for _ in range(2))
print(first == second, bool(stage.GetPrimAtPath("/Plate")))
app.close()
""")
    assert lines == ["True True"]
    assert "cup.usd does not exist" in err
    assert "plate.usd does not exist" in err


def test_the_module_of_backends_has_what_the_attribute_has(ran):
    lines, _ = ran(f"""{APP}
import omni.replicator.core as rep
import omni.replicator.core.backends
print(rep.backends.get("DiskBackend") is not None, omni.replicator.core.backends.BackendDispatch is rep.BackendDispatch)
app.close()
""")
    assert lines == ["True True"]


def test_writers_write_augmented_and_added_annotators(run_script, tmp_path):
    """Colours to HSV and back keep a red cube red; a shift of a depth reaches the written file."""
    code, out, err = run_script(
        f"""import numpy as np
from PIL import Image
from isaacsim import SimulationApp
app = SimulationApp()
import omni.replicator.core as rep

def shift(data_in, by):
    data_in += by
    return data_in

def noise(data_in, seed):
    return data_in + np.random.default_rng(seed).normal(0, 2, data_in.shape)

rep.create.cube(position=(0, 0, 0), semantics=[("class", "box")])
product = rep.create.render_product(rep.create.camera(position=(0, 0, 5), look_at=(0, 0, 0)), (32, 32))
make = rep.annotators.Augmentation.from_function
hsv, rgb = (make(one) for one in (rep.augmentations_default.aug_rgb_to_hsv, rep.augmentations_default.aug_hsv_to_rgb))
plain = rep.annotators.get("rgb").attach(product)
depth = rep.annotators.get("distance_to_camera").attach(product)
rep.annotators.register("noisy", rep.annotators.augment_compose(rep.annotators.get("rgb"), [make(noise, seed=None)]))
noisy = rep.annotators.get("noisy").attach(product)
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir={str(tmp_path / "out")!r}, rgb=True, distance_to_camera=True)
writer.add_annotator(rep.annotators.get("rgb").augment_compose([hsv, rgb], name="rgb"))
writer.augment_annotator("distance_to_camera", make(shift), by=10.0)
writer.attach([product])
rep.orchestrator.step()
found = np.array(Image.open({str(tmp_path / "out" / "rgb_0000.png")!r})).astype(int)
print(abs(found - plain.get_data()).max() <= 8, found.max() > 50)
far = np.load({str(tmp_path / "out" / "distance_to_camera_0000.npy")!r})
print(np.allclose(far, depth.get_data() + 10.0))
print(noisy.get_data().dtype, np.array_equal(noisy.get_data(), plain.get_data()))
print(np.array_equal(noisy.get_data(), noisy.get_data()))
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["True True", "True", "uint8 False", "True"]


def test_hue_saturation_and_value_are_those_of_pure_colours(run_script):
    code, out, err = run_script(
        """import numpy as np
import omni.replicator.core as rep
colours = np.array([[[255, 0, 0, 9], [0, 255, 0, 9], [0, 0, 255, 9], [7, 7, 7, 9], [0, 0, 0, 9]]], np.uint8)
turned = rep.augmentations_default.aug_rgb_to_hsv(colours)
print(turned[0].tolist())
print(rep.augmentations_default.aug_hsv_to_rgb(turned)[0].tolist())
"""
    )
    assert code == 0, err
    first, second = out.splitlines()
    assert first == "[[0, 255, 255, 9], [85, 255, 255, 9], [171, 255, 255, 9], [0, 0, 7, 9], [0, 0, 0, 9]]"
    assert second == "[[255, 0, 0, 9], [3, 255, 0, 9], [0, 3, 255, 9], [7, 7, 7, 9], [0, 0, 0, 9]]"


def test_a_coloured_segmentation_is_a_number_of_four_bytes_a_pixel(ran):
    lines, _ = ran(f"""{LOOKING_DOWN}
from isaacsim.core.utils.semantics import add_labels
add_labels(stage.GetPrimAtPath("/World/Cube"), labels=["box"], instance_name="class")
seen = rep.AnnotatorRegistry.get_annotator("semantic_segmentation", init_params={{"colorize": True}})
seen.attach(product)
rep.orchestrator.step()
found = seen.get_data()
colors = np.frombuffer(found["data"], dtype=np.uint8).reshape(*found["data"].shape, -1)
print(found["data"].shape, found["data"].dtype, colors.shape)
print(found["info"]["idToLabels"][str(tuple(colors[3, 4].tolist()))])
app.close()
""")
    assert lines == ["(6, 8) uint32 (6, 8, 4)", "{'class': 'box'}"]


def test_a_writer_of_several_products_gets_their_data_at_once(ran):
    lines, _ = ran(f"""{LOOKING_DOWN}
large = rep.create.render_product("/World/Camera", (16, 12), name="Large")
small = rep.create.render_product("/World/Camera", (4, 2), name="Small")
class Sizes(rep.Writer):
    def __init__(self):
        self.annotators.append(rep.AnnotatorRegistry.get_annotator("rgb"))
    def write(self, data):
        print({{name: found.shape for name, found in data.items()}})
rep.WriterRegistry.register(Sizes)
sizes = rep.WriterRegistry.get("Sizes")
sizes.initialize()
sizes.attach([large, small])
rep.orchestrator.step()
print(rep.Writer.annotators)
sizes.detach()
rep.orchestrator.step()
app.close()
""")
    assert lines == ["{'rgb-Large': (12, 16, 4), 'rgb-Small': (2, 4, 4)}", "()"]
