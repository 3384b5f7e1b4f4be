"""Randomised scenes of `omni.replicator.core`: what is drawn, for which frames, and what the writers then see."""

import math

import pytest

SCENE = """
import os
import numpy as np
import omni.replicator.core as rep
import omni.usd
from pxr import UsdGeom, UsdLux
stage = omni.usd.get_context().get_stage()
UsdGeom.SetStageMetersPerUnit(stage, 1.0)
UsdGeom.SetStageUpAxis(stage, "Z")
UsdLux.DomeLight.Define(stage, "/World/Dome")
cube = UsdGeom.Cube.Define(stage, "/World/Cube")
UsdGeom.XformCommonAPI(UsdGeom.Camera.Define(stage, "/World/Camera")).SetTranslate((0, 0, 6))
def depths():
    names = sorted(one for one in os.listdir("frames") if one.endswith(".npy"))
    return [round(float(np.load("frames/" + name)[3, 4]), 3) for name in names]
def place(path="/World/Cube"):
    matrix = UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(0)
    return [round(one, 6) for one in matrix.ExtractTranslation()]
"""
WRITTEN = """
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir="frames", distance_to_image_plane=True)
writer.attach([rep.create.render_product("/World/Camera", (8, 6))])
"""
APP = "from isaacsim import SimulationApp\napp = SimulationApp({'headless': True})\n"
CLIMB = """
with rep.new_layer():
    with rep.trigger.on_frame(num_frames=3):
        with rep.get.prims(path_pattern="^/World/Cube$"):
            rep.modify.pose(position=rep.distribution.sequence([(0, 0, 0), (0, 0, 1), (0, 0, 2)]))
"""

UPDATES = """
while not rep.orchestrator.get_is_started():
    app.update()
while rep.orchestrator.get_is_started():
    app.update()
for _ in range(3):
    app.update()
"""


@pytest.fixture
def ran(run_script, tmp_path, monkeypatch):
    """The lines that a script prints; it must end well."""
    monkeypatch.chdir(tmp_path)

    def run(text, *options):
        code, out, err = run_script(text, *options)
        assert code == 0, err
        return out.splitlines()

    return run


@pytest.mark.parametrize(
    "drive",
    [
        "rep.orchestrator.run_until_complete()",
        "rep.orchestrator.run()\n" + UPDATES,
        "import omni.timeline\nomni.timeline.get_timeline_interface().play()\nrep.orchestrator.run()\n" + UPDATES,
        "for _ in range(3):\n    rep.orchestrator.step(delta_time=0.0)",
    ],
    ids=["until complete", "run at rest", "run while playing", "steps"],
)
def test_a_trigger_moves_a_prim_before_each_of_its_frames(ran, drive):
    """The cube's top is at 1, then 2, then 3 m, the camera at 6 m."""
    end = "\nrep.orchestrator.wait_until_complete()\nprint(depths())\napp.close()\n"
    assert ran(f"{APP}{SCENE}{WRITTEN}{CLIMB}{drive}{end}") == ["[5.0, 4.0, 3.0]"]


def test_a_snippet_captures_all_frames_without_play(ran):
    assert ran(f"{SCENE}{WRITTEN}{CLIMB}rep.orchestrator.run()\nprint(depths(), place())\n")[0] == (
        "[5.0, 4.0, 3.0] [0.0, 0.0, 2.0]"
    )


DRAWN = """
seen = []
class Note(rep.Writer):
    def __init__(self):
        self.annotators = []
    def write(self, data):
        seen.append(place())
rep.WriterRegistry.register(Note)
note = rep.WriterRegistry.get("Note")
note.initialize()
note.attach([rep.create.render_product("/World/Camera", (8, 6))])
with rep.trigger.on_frame(num_frames=4, interval=1):
    with rep.get.prim_at_path("/World/Cube"):
        rep.modify.pose(position=rep.distribution.uniform((-1, 2, 0), (1, 3, 0)))
rep.orchestrator.run_until_complete()
print(seen)
app.close()
"""


def test_draws_stay_in_bounds_and_repeat_with_their_seed(ran):
    [first] = ran(f"{APP}{SCENE}rep.set_global_seed(3)\n{DRAWN}")
    places = eval(first)
    assert len({tuple(one) for one in places}) == 4
    assert all(-1 <= x <= 1 and 2 <= y <= 3 and z == 0 for x, y, z in places)
    assert ran(f"{APP}{SCENE}rep.set_global_seed(3)\n{DRAWN}") == [first]
    assert ran(f"{APP}{SCENE}rep.set_global_seed(4)\n{DRAWN}") != [first]


def test_registered_randomizers_change_labelled_prims_materials_and_new_lights(ran):
    lines = ran(f"""{APP}{SCENE}
boxes = rep.create.cube(count=2, semantics=[("class", "box")], position=rep.distribution.uniform((1, 1, 1), (2, 2, 2)))
paths = [str(prim.GetPath()) for prim in boxes.get_output_prims()["prims"]]
print(all(1 <= one <= 2 for path in paths for one in place(path)), place(paths[0]) != place(paths[1]))
red = rep.create.material_omnipbr(diffuse=(1, 0, 0), roughness=0.5)
blue = rep.create.material_omnipbr(diffuse=(0, 0, 1))
def dress():
    found = rep.get.prims(semantics=[("class", "box")])
    with found:
        rep.randomizer.materials(rep.distribution.choice([red, blue], weights=[0.0, 1.0]))
        rep.modify.attribute("size", rep.distribution.choice([4.0]))
    return found.node
def lights():
    made = rep.create.light(light_type="Sphere", intensity=rep.distribution.normal(500, 0), temperature=6500)
    return made.node
for one in (dress, lights):
    rep.randomizer.register(one)
with rep.trigger.on_frame(num_frames=2):
    rep.randomizer.dress()
    rep.randomizer.lights()
rep.orchestrator.run_until_complete()
from pxr import UsdShade
for path in paths:
    bound = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path + "/Cube")).GetDirectBinding().GetMaterial()
    color = bound.GetPrim().GetChildren()[0].GetAttribute("inputs:diffuse_color_constant").Get()
    print(tuple(color), stage.GetPrimAtPath(path + "/Cube").GetAttribute("size").Get())
lamps = rep.get.sphere_light().get_output_prims()["prims"]
print(len(lamps), lamps[0].GetAttribute("inputs:intensity").Get())
app.close()
""")
    assert lines == ["True True", "(0.0, 0.0, 1.0) 4.0", "(0.0, 0.0, 1.0) 4.0", "1 500.0"]


def test_triggers_of_time_and_events_act_when_they_are_due(ran):
    """At 60 updates a second, each step is 1/60 s: another 0.05 s is over at every third step."""
    lines = ran(f"""{APP}{SCENE}
with rep.trigger.on_time(interval=0.05):
    with rep.get.prim_at_path("/World/Cube"):
        rep.modify.pose(position=rep.distribution.sequence([(float(n), 0, 0) for n in range(9)]))
with rep.trigger.on_custom_event("lift"):
    with rep.get.prim_at_path("/World/Camera"):
        rep.modify.pose(position=rep.distribution.sequence([(0, 0, 7), (0, 0, 8)]))
seen = []
for number in range(9):
    if number in (2, 5):
        rep.utils.send_og_event("lift")
    rep.orchestrator.step(pause_timeline=False)
    seen.append((place()[0], place("/World/Camera")[2]))
print([one for one, _ in seen])
print([one for _, one in seen])
app.close()
""")
    # Each step begins at the time that the one before reached: 0, 1/60, ..., 8/60 s.
    assert lines == [str([float(n // 3) for n in range(9)]), "[6.0, 6.0, 7.0, 7.0, 7.0, 8.0, 8.0, 8.0, 8.0]"]


def test_a_group_of_shapes_is_moved_together_and_a_torus_is_a_ring(ran):
    lines = ran(f"""{APP}{SCENE}
steel = rep.create.material_omnipbr(metallic=1.0)
ring = rep.create.torus(semantics=[("class", "torus")], material=steel)
hidden = rep.create.plane(scale=10, visible=False)
mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Replicator/Torus_Xform/Torus"))
points = np.array(mesh.GetPointsAttr().Get())
faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
corners = points[faces].astype(float)
print(round(float(np.hypot(points[:, 0], points[:, 1]).max()), 3), round(float(points[:, 2].max()), 3))
print(round(float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6), 3))
print(UsdGeom.Imageable(stage.GetPrimAtPath("/Replicator/Plane_Xform/Plane")).ComputeVisibility())
with rep.trigger.on_frame(num_frames=2):
    with rep.create.group([ring, rep.get.prim_at_path("/World/Cube")]):
        rep.modify.pose(position=rep.distribution.choice([(0, 0, 3)]), scale=rep.distribution.uniform(2, 2))
rep.orchestrator.run_until_complete()
print(place("/Replicator/Torus_Xform"), place())
app.close()
""")
    # Of 24 x 24 cells: the tube is a polygon of 12 sin(15 deg) r2, and a wedge of 15 deg has the area sin(15 deg) r dr.
    tube = 12 * math.sin(math.radians(15)) * 0.125**2
    ring = 24 * math.sin(math.radians(15)) * 0.375
    assert lines[0] == "0.5 0.125"
    assert float(lines[1]) == pytest.approx(tube * ring, abs=0.0006)
    assert lines[2:] == ["invisible", "[0.0, 0.0, 3.0] [0.0, 0.0, 3.0]"]
