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
        ("rep.randomizer.scatter_2d([])", "randomizer.scatter_2d: this randomizer is not here; modify.pose"),
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
