"""PhysX lidars, suction grippers and samples as scripts call them, against numbers worked out on paper."""

from importlib import import_module

import numpy as np
import pytest

import graph.isaac
from graph.isaac.kit import kit_of
from graph.sim import App
from tests.support.without_wing import needs_wing


@pytest.fixture
def kit():
    """An App with Isaac Sim's names, and a function that imports them."""
    with App() as app, graph.isaac.importable():
        yield app, import_module


def solid(app, path, position, size=1.0, mass=None):
    from pxr import UsdGeom, UsdPhysics

    cube = UsdGeom.Cube.Define(app.stage, path)
    cube.GetSizeAttr().Set(1)
    cube.AddTranslateOp().Set(tuple(position))
    cube.AddScaleOp().Set((size, size, size))
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    if mass:
        UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
        UsdPhysics.MassAPI.Apply(cube.GetPrim()).GetMassAttr().Set(mass)


@needs_wing("physx")
def test_a_lidar_of_physx_sees_a_wall_in_one_direction(kit):
    app, imported = kit
    _, lidar = imported("omni.kit.commands").execute(
        "RangeSensorCreateLidar", path="/Lidar", horizontal_resolution=1.0, rotation_rate=0.0, max_range=10.0
    )
    solid(app, "/Wall", (-2.5, 0, 0))  # its near face is 2 m away, behind the sensor: column 0 looks along -180 degrees
    solid(app, "/Ball", (3, 3, 3), 0.2, mass=1.0)
    reading = imported("omni.isaac.range_sensor._range_sensor").acquire_lidar_sensor_interface()
    assert reading.get_depth_data("/Lidar").size == 0  # before play
    app.play()
    app.update()
    app.update()
    path = str(lidar.GetPath())
    assert reading.is_lidar_sensor(path)
    assert not reading.is_lidar_sensor("/Wall")
    assert (reading.get_num_cols(path), reading.get_num_rows(path)) == (360, 1)
    depth = reading.get_linear_depth_data(path)
    assert depth[0, 0] == pytest.approx(2.0, abs=1e-5)
    assert depth[180, 0] == 10.0
    assert reading.get_depth_data(path)[[0, 180], 0].tolist() == [65535 // 5, 65535]
    assert reading.get_intensity_data(path)[[0, 180], 0].tolist() == [255, 0]
    assert reading.get_point_cloud_data(path)[0, 0] == pytest.approx([-2, 0, 0], abs=1e-5)
    assert reading.get_azimuth_data(path)[[0, 90]] == pytest.approx([-np.pi, -np.pi / 2])


@needs_wing("physx")
def test_a_rotating_lidar_gives_whole_turns_in_its_frame(kit):
    app, imported = kit
    kinds = imported("isaacsim.sensors.physx")
    lidar = kinds.RotatingLidarPhysX("/Lidar", rotation_frequency=10.0, fov=(360, 30), resolution=(2.0, 5.0))
    with pytest.raises(Exception, match="not both"):
        kinds.RotatingLidarPhysX("/Other", rotation_frequency=10.0, rotation_dt=0.1)
    solid(app, "/Wall", (-2.5, 0, 0))
    solid(app, "/Ball", (3, 3, 3), 0.2, mass=1.0)
    lidar.add_linear_depth_data_to_frame()
    lidar.add_point_cloud_data_to_frame()
    app.play()
    lidar.initialize()
    sizes = []
    for _ in range(8):
        app.update()
        sizes.append(lidar.get_current_frame()["linear_depth"].shape)
    # A turn lasts 6 updates of 1/60 s, and is not whole where the sensor began within it.
    assert sizes[:5] == [(0, 0)] * 5
    assert sizes[-1] == (180, 7)
    assert lidar.get_current_frame()["linear_depth"][0, 3] == pytest.approx(2.0, abs=1e-5)
    assert lidar.get_current_frame()["physics_step"] == app.simulation.get_num_physics_steps()
    assert lidar.get_valid_range() == pytest.approx((0.4, 2000.0))
    assert lidar.get_fov() == (360, 30)
    lidar.remove_point_cloud_data_from_frame()
    assert "point_cloud" not in lidar.get_current_frame()


def cup(app, imported):
    """A heavy arm held in the air by a stiff drive, a cup on its lower side, a box 5 mm below on a stand."""
    from pxr import Gf, Sdf, UsdPhysics

    solid(app, "/Arm", (0, 0, 1), 0.1, mass=5.0)
    solid(app, "/Box", (0, 0, 0.845), 0.2, mass=1.0)
    solid(app, "/Stand", (0, 0, 0.695), 0.1)
    slide = UsdPhysics.PrismaticJoint.Define(app.stage, "/Slide")
    slide.GetAxisAttr().Set("Z")
    slide.GetBody1Rel().SetTargets(["/Arm"])
    slide.GetLocalPos0Attr().Set((0, 0, 1))
    drive = UsdPhysics.DriveAPI.Apply(slide.GetPrim(), "linear")
    drive.GetStiffnessAttr().Set(1e5)
    drive.GetDampingAttr().Set(1e4)
    point = UsdPhysics.Joint.Define(app.stage, "/Arm/Point")
    point.GetBody0Rel().SetTargets(["/Arm"])
    point.GetLocalPos0Attr().Set((0, 0, -0.5))  # in the scaled cube's own units
    point.GetLocalRot0Attr().Set(Gf.Quatf(0, 1, 0, 0))
    point.GetPrim().CreateAttribute("isaac:forwardAxis", Sdf.ValueTypeNames.Token).Set("Z")
    made = imported("isaacsim.robot.surface_gripper").create_surface_gripper(app.stage, "/Arm")
    made.GetRelationship("isaac:attachmentPoints").SetTargets(["/Arm/Point"])
    return str(made.GetPath())


@needs_wing("robots")
def test_a_suction_gripper_holds_a_box_until_it_opens(kit):
    app, imported = kit
    path = cup(app, imported)
    assert path == "/Arm/SurfaceGripper"
    gripper = imported("isaacsim.robot.manipulators.grippers").SurfaceGripper("/Arm", path)
    view = imported("isaacsim.robot.surface_gripper").GripperView(path, max_grip_distance=[0.02], retry_interval=[1.0])
    status = imported("isaacsim.robot.surface_gripper._surface_gripper").GripperStatus
    assert view.get_surface_gripper_properties()[0] == pytest.approx([0.02])
    app.play()
    app.update()
    gripper.initialize(articulation_num_dofs=3)
    assert gripper.is_open()
    assert gripper.get_default_state() == {"opened": True}
    assert gripper.forward("close").joint_positions == [None] * 3
    app.update()
    assert gripper.is_closed()
    assert view.get_gripped_objects() == [["/Box"]]
    assert view.get_surface_gripper_status() == [status.Closed]
    view.apply_gripper_action([0.2])  # too weak to count
    assert gripper.is_closed()
    view.apply_gripper_action([-0.5])
    assert gripper.is_open()
    assert view.get_gripped_objects() == [[]]
    with pytest.raises(ValueError, match="one for each of the 1 grippers"):
        view.apply_gripper_action([1.0, 1.0])
    app.stop()
    assert gripper.is_open()


def test_a_gripper_that_is_not_there_stays_open_and_is_named_once(kit):
    app, imported = kit
    solid(app, "/Arm", (0, 0, 1), 0.1, mass=5.0)
    gripper = imported("isaacsim.robot.manipulators.grippers").SurfaceGripper("/Arm", "/Arm/Nothing")
    app.play()
    app.update()
    gripper.close()
    assert gripper.is_open()
    assert [one.where for one in app.warnings if one.code == "no-surface-gripper"] == ["/Arm/Nothing"]


@pytest.mark.parametrize(
    ("module", "playing"), [("isaacsim.examples.interactive.base_sample", False), ("isaacsim.examples.base", True)]
)
def test_a_sample_builds_its_scene_and_resets_it(kit, module, playing):
    app, imported = kit
    calls = []

    class Sample(imported(module).BaseSample):
        def setup_scene(self):
            solid(app, "/World/Ball", (0, 0, 5), 0.2, mass=1.0)
            calls.append("scene")

        async def setup_post_load(self):
            calls.append(("loaded", app.timeline.is_playing()))

        async def setup_post_reset(self):
            calls.append(("reset", app.timeline.is_playing()))

    async def drive():
        sample = Sample()
        sample.set_world_settings(physics_dt=1 / 120)
        await sample.load_world_async()
        rate = app.simulation.get_physics_dt()
        await sample.reset_async()
        await sample.clear_async()
        return rate

    assert kit_of(app).finish(drive()) == pytest.approx(1 / 120)
    assert calls == ["scene", ("loaded", playing), ("reset", playing)]
    assert not app.stage.GetPrimAtPath("/World/Ball")
