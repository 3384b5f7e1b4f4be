"""With Fabric off the stage is the world: sensors see to the last bit what they see with Fabric on."""

from __future__ import annotations

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.sim import App
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Gf, Usd, UsdGeom, UsdPhysics
from sensors import Lidar, LidarSensor

PRIMS = {
    "/World": {"translate": [0.3, -0.2, 0.1], "rotate": [0, 0, 30]},
    "/World/Ground": {"type": "Plane"},
    "/World/Wall": {"type": "Cube", "size": 2, "translate": [6, 0, 1], "rotate": [0, 0, 17]},
    "/World/Tilted": {"rotate": [10, 20, 30], "scale": 1.5, "translate": [2, 1, 1]},
    "/World/Tilted/Box": {
        "type": "Cube", "size": 0.4, "scale": [1, 2, 0.5], "rigid_body": True, "angular_velocity": [40, 60, 80],
    },
    "/World/Skewed": {"scale": [1, 2, 1], "translate": [-3, 1, 2]},
    "/World/Skewed/Box": {
        "type": "Cube", "size": 0.3, "rotate": [0, 0, 40], "rigid_body": True, "angular_velocity": [90, 0, 30],
    },
    "/World/Cart": {"type": "Cube", "size": 1, "scale": [1, 0.6, 0.3], "translate": [0, 0, 0.7], "rigid_body": True,
                    "velocity": [1.5, 0.3, 0], "rotate": [0, 0, 25]},
    "/World/Cart/Mast": {"translate": [0.1, 0, 1.2], "rotate": [0, 5, 15]},
    "/World/Cart/Mast/Trunk": {"type": "Cylinder", "radius": 0.2, "height": 0.1, "translate": [0.3, 0.3, 0.5]},
    "/World/Cart/Mast/Trunk/Ball": {"type": "Sphere", "radius": 0.1, "rigid_body": True, "translate": [0, 0, 1]},
}  # fmt: skip


def frames(fabric, act=lambda app: None, motion="frozen", unit=1.0, updates=30):
    """Everything that two lidars, one still and one carried, deliver."""
    stage = open_stage()
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    fidelity = {"fabric": "on" if fabric else "off", "lidar.motion": motion, "lidar.bins": 3}
    with App(
        stage, physics_hz=240, loop_hz=60, fidelity=fidelity, settings={"/app/sensors/nv/lidar/publishNormals": True}
    ) as app:
        app.add_prims(PRIMS)
        sensors = []
        for path, place in (("/World/Lidar", [0, 0, 1.0]), ("/World/Cart/Mast/Lidar", [0, 0, 0.3])):
            lidar = Lidar.create(path, config="Example_Rotary_2D", translations=place, app=app, aux_output_level="FULL")
            sensors.append(LidarSensor(lidar, annotators=["generic-model-output"]))
        app.play()
        out = []
        for number in range(updates):
            if number == updates // 2:
                act(app)
            app.update()
            for sensor in sensors:
                data, _ = sensor.get_data("generic-model-output")
                out.append(None if data is None else bytes(data))
        poses = app.fabric.world_matrices(list(PRIMS))
        return out, poses


@pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])
def test_fabric_on_and_off_give_the_same_bytes(motion):
    on, placed_on = frames(True, motion=motion)
    off, placed_off = frames(False, motion=motion)
    assert sum(data is not None for data in on) >= 8
    assert on == off
    assert np.array_equal(placed_on, placed_off)


def test_the_bytes_are_the_same_in_other_units_too():
    assert frames(True, unit=0.01)[0] == frames(False, unit=0.01)[0]


def test_a_body_that_is_placed_is_seen_the_same_in_both():
    def place(app):
        pose = np.eye(4)
        pose[:3, 3] = 1.0, 2.0, 3.0
        app.fabric.set_world_matrix("/World/Cart", pose)

    assert frames(True, place)[0] == frames(False, place)[0]


def write_translate(app, path, value):
    app.stage.GetPrimAtPath(path).GetAttribute("xformOp:translate").Set(Gf.Vec3d(*value))


def test_a_still_wall_that_is_moved_on_the_stage_is_seen_the_same_in_both():
    on, off = (frames(fabric, lambda app: write_translate(app, "/World/Wall", [4, 1, 1])) for fabric in (True, False))
    assert on[0] == off[0]
    assert on[0] != frames(True)[0]


def test_a_body_that_is_added_is_seen_the_same_in_both():
    def add(app):
        app.add_prims({"/World/New": {"type": "Sphere", "rigid_body": True, "translate": [2, -2, 2]}}, "recompile")

    on, off = frames(True, add), frames(False, add)
    assert on[0] == off[0]
    assert on[0] != frames(True)[0]


def on_stage(app, path):
    matrix = UsdGeom.XformCache(Usd.TimeCode.Default()).GetLocalToWorldTransform(app.stage.GetPrimAtPath(path))
    return np.array(matrix).T


@pytest.mark.parametrize("unit", [1.0, 0.01])
def test_physics_writes_local_transforms_after_every_step(unit):
    stage = open_stage()
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    with App(stage, physics_hz=240, loop_hz=60, fidelity={"fabric": "off"}) as app:
        app.add_prims(PRIMS)
        app.play()
        seen = []
        app.on("physics_post_step", lambda: seen.append(on_stage(app, "/World/Cart")[2, 3]))
        app.update(30)
        assert len(set(seen)) == 120
        for path in PRIMS:
            assert on_stage(app, path) == pytest.approx(app.fabric.world_matrix(path), abs=1e-9), path
        ops = [op.GetOpName() for op in UsdGeom.Xformable(stage.GetPrimAtPath("/World/Cart")).GetOrderedXformOps()]
        assert ops == ["xformOp:translate", "xformOp:orient", "xformOp:scale"]


def test_with_fabric_on_physics_writes_nothing():
    with App(fidelity={"fabric": "on"}) as app:
        app.add_prims(PRIMS)
        before = app.stage.GetRootLayer().ExportToString()
        app.play()
        app.update(10)
        assert app.stage.GetRootLayer().ExportToString() == before


def test_what_the_scene_animates_or_writes_in_single_precision_is_written_all_the_same():
    stage = open_stage()
    cube = UsdGeom.Cube.Define(stage, "/Moving")
    translate = cube.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat)
    translate.Set(Gf.Vec3f(0, 0, 9), 0.0)
    translate.Set(Gf.Vec3f(0, 0, 11), 10.0)
    single = UsdGeom.Cube.Define(stage, "/Single")
    single.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat).Set(Gf.Vec3f(5, 0, 9))
    single.AddRotateXYZOp().Set((0, 0, 45))
    for each in (cube, single):
        UsdPhysics.RigidBodyAPI.Apply(each.GetPrim())
    before = stage.GetRootLayer().ExportToString()
    with App(stage, fidelity={"fabric": "off"}) as app:
        app.play()
        app.update(30)
        for path in ("/Moving", "/Single"):
            assert on_stage(app, path) == pytest.approx(app.fabric.world_matrix(path), abs=1e-5)
        assert on_stage(app, "/Single")[2, 3] < 8
        app.stop()
        assert stage.GetRootLayer().ExportToString() == before


def test_a_body_in_an_instance_cannot_be_written_and_is_named(tmp_path):
    stage = open_stage()
    stage.DefinePrim("/Kit", "Xform")
    UsdPhysics.RigidBodyAPI.Apply(UsdGeom.Cube.Define(stage, "/Kit/Box").GetPrim())
    copy = stage.DefinePrim("/Copy", "Xform")
    copy.GetReferences().AddInternalReference("/Kit")
    copy.SetInstanceable(True)
    with (
        App(stage, fidelity={"fabric": "off"}) as app,
        pytest.raises(UserError, match="/Copy/Box: it lies in an instance"),
    ):
        app.play()
