"""Equations of motion, contacts of pairs and readings of sensors, against numbers worked out on paper."""

from importlib import import_module

import numpy as np
import pytest

import graph.isaac
from graph.sim import App
from graph.sim.entered import current

PENDULUM = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "World" {
    def PhysicsScene "Scene" {
        float physics:gravityMagnitude = 10
    }
    def Xform "Robot" (prepend apiSchemas = ["PhysicsArticulationRootAPI"]) {
        def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
            float physics:mass = 1
        }
        def Xform "arm" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]) {
            float physics:mass = 2
            point3f physics:centerOfMass = (0.5, 0, 0)
            float3 physics:diagonalInertia = (0.01, 0.01, 0.01)
        }
        def PhysicsFixedJoint "hold" {
            rel physics:body1 = </World/Robot/base>
        }
        def PhysicsRevoluteJoint "hinge" (prepend apiSchemas = ["PhysicsJointStateAPI:angular"]) {
            uniform token physics:axis = "Y"
            rel physics:body0 = </World/Robot/base>
            rel physics:body1 = </World/Robot/arm>
        }
    }
}
"""


@pytest.fixture
def pendulum(tmp_path):
    """An arm of 2 kg, its centre 0.5 m from a hinge about Y on a fixed base, level, with g = 10 m/s2."""
    file = tmp_path / "pendulum.usda"
    file.write_text(PENDULUM)
    with App(stage=str(file)) as app, graph.isaac.importable():
        robot = import_module("isaacsim.core.experimental.prims").Articulation("/World/Robot")
        app.play()
        app.update()
        robot.set_dof_positions([0.0])
        robot.set_dof_velocities([0.0])
        yield robot


def test_the_base_is_the_first_link(pendulum):
    assert pendulum.link_names == ["base", "arm"]


def test_inertia_of_a_pendulum_is_that_of_its_mass_at_its_arm(pendulum):
    # I + m l^2 = 0.01 + 2 * 0.25
    assert pendulum.get_mass_matrices().numpy() == pytest.approx(np.array([[[0.51]]]))
    assert pendulum.mass_matrix_shape == (1, 1)


def test_gains_and_limits_of_a_playing_robot_act_at_once(pendulum):
    # A damper alone, so strong that 10 N m bend its speed by 1e-5 rad/s; then none: the arm falls to its new limit.
    world = current()
    pendulum.set_dof_gains([0.0], [1e6])
    pendulum.set_dof_velocity_targets([0.2])
    world.update(30)
    assert pendulum.get_dof_velocities().numpy() == pytest.approx(np.array([[0.2]]), abs=1e-4)
    pendulum.set_dof_gains([0.0], [0.0])
    pendulum.set_dof_positions([0.0])
    pendulum.set_dof_limits([-0.1], [0.1])
    world.update(240)
    assert pendulum.get_dof_positions().numpy() == pytest.approx(np.array([[0.1]]), abs=5e-3)
    assert not [one for one in world.warnings if one.code == "edit-not-live"]


def test_gravity_compensation_holds_a_level_pendulum(pendulum):
    # Turning about +Y moves the arm down: m g l = 2 * 10 * 0.5 must act against it.
    assert pendulum.get_dof_gravity_compensation_forces().numpy() == pytest.approx(np.array([[-10.0]]))
    assert pendulum.get_dof_coriolis_and_centrifugal_compensation_forces().numpy() == pytest.approx(
        np.array([[0.0]]), abs=1e-9
    )


def test_jacobian_of_a_link_on_the_hinge_is_its_axis(pendulum):
    # The link's origin is on the axis: it turns about Y and does not move; the fixed base has no row.
    assert pendulum.jacobian_matrix_shape == (1, 6, 1)
    assert pendulum.get_jacobian_matrices().numpy()[0, 0, :, 0] == pytest.approx([0, 0, 0, 0, 1, 0])


def test_armature_is_authored_and_adds_to_the_inertia_at_the_next_play(pendulum):
    app = App.current()
    app.stop()
    app.update()
    pendulum.set_dof_armatures([0.25])
    assert pendulum.get_dof_armatures().numpy() == pytest.approx(np.array([[0.25]]))
    app.play()
    app.update()
    assert pendulum.get_mass_matrices().numpy() == pytest.approx(np.array([[[0.76]]]))


def test_a_joint_of_a_missing_asset_is_said_with_the_missing_file(tmp_path):
    file = tmp_path / "scene.usda"
    file.write_text('#usda 1.0\ndef Xform "Robot" (prepend references = @robot.usd@) {}\n')
    with App(stage=str(file)), graph.isaac.importable():
        wrappers = import_module("isaacsim.core.experimental.prims")
        with pytest.raises(ValueError, match=r"/Robot has no joint 'hinge': /Robot is empty because .*robot\.usd"):
            wrappers.Articulation("/Robot").get_dof_indices("hinge")


@pytest.fixture
def resting():
    """A cube of 2 kg that rests on the ground, z = 0, after 60 steps."""
    with App() as app, graph.isaac.importable():
        objects, prims = (import_module(f"isaacsim.core.experimental.{one}") for one in ("objects", "prims"))
        objects.GroundPlane("/World/Ground")
        objects.Cube("/World/Cube", sizes=1.0, positions=[0.0, 0.0, 0.5])
        prims.GeomPrim("/World/Cube", apply_collision_apis=True)
        yield app, prims.RigidPrim("/World/Cube", masses=[2.0], contact_filter_paths=["/World/Ground"])


def run(app, updates=60):
    app.play()
    for _ in range(updates):
        app.update()


def test_contacts_with_a_filtered_prim_carry_the_weight(resting):
    app, cube = resting
    run(app)
    forces, points, normals, _, counts, starts = (one.numpy() for one in cube.get_contact_force_data(dt=1 / 60))
    assert (counts.tolist(), starts.tolist()) == ([[len(forces)]], [[0]])
    assert forces.sum() == pytest.approx(2 * 9.81, rel=0.02)
    assert normals[:, 2] == pytest.approx([1] * len(forces), abs=1e-6)
    assert points[:, 2] == pytest.approx([0] * len(points), abs=0.01)
    assert cube.get_contact_force_matrix(dt=1 / 60).numpy() == pytest.approx(
        np.array([[[0, 0, 2 * 9.81]]]), rel=0.02, abs=0.05
    )


def test_rays_of_a_sensor_end_where_they_hit(resting):
    app, _ = resting
    sensors = import_module("isaacsim.sensors.experimental.physics")

    sensor = sensors.RaycastSensor(
        sensors.Raycast.create(
            "/World/Cube/Rays",
            ray_origins=[[2, 0, 0], [2, 0, 0]],
            ray_directions=[[0, 0, -1], [0, 0, 1]],
            min_range=0.1,
            max_range=20.0,
            output_frame="WORLD",
            report_hit_prim_paths=True,
        )
    )
    assert not sensor.get_sensor_reading().is_valid
    assert sensor.get_data()["hit_positions"].shape == (0, 3)
    run(app, 3)
    reading = sensor.get_sensor_reading()
    assert (reading.is_valid, reading.ray_count) == (True, 2)
    assert reading.depths.tolist() == pytest.approx([0.5, 20.0], abs=5e-3)
    assert reading.hit_positions[0].tolist() == pytest.approx([2, 0, 0], abs=5e-3)
    assert reading.hit_prim_paths[0].startswith("/World/Ground")


def test_rays_that_do_not_fit_together_give_no_reading_and_say_so(resting):
    app, _ = resting
    sensors = import_module("isaacsim.sensors.experimental.physics")
    from pxr import Sdf, Vt

    prim = app.stage.DefinePrim("/World/Bad", "IsaacRaycastSensor")
    prim.CreateAttribute("numRays", Sdf.ValueTypeNames.UInt).Set(2)
    prim.CreateAttribute("rayDirections", Sdf.ValueTypeNames.Float3Array).Set(Vt.Vec3fArray([(1, 0, 0)]))
    sensor = sensors.RaycastSensor("/World/Bad")
    run(app, 3)
    assert not sensor.get_sensor_reading().is_valid
    assert [one.code for one in app.warnings if one.where == "/World/Bad"] == ["raycast-sensor-off"]


def test_a_contact_sensor_reads_the_weight_and_an_imu_what_holds_it(resting):
    app, _ = resting
    sensors = import_module("isaacsim.sensors.experimental.physics")

    contact = sensors.ContactSensor(sensors.Contact.create("/World/Cube/Contact", min_threshold=0.1))
    imu = sensors.IMUSensor(sensors.IMU.create("/World/Cube/Imu"))
    run(app)
    touch, felt = contact.get_sensor_reading(), imu.get_sensor_reading()
    assert (touch.is_valid, touch.in_contact) == (True, True)
    assert touch.value == pytest.approx(2 * 9.81, rel=0.02)
    assert felt.is_valid
    assert felt.linear_acceleration_z == pytest.approx(9.81, abs=0.05)
    assert felt.orientation_w == pytest.approx(1, abs=1e-3)


def test_a_sensor_must_be_alone_of_its_type_and_below_a_body(resting):
    sensors = import_module("isaacsim.sensors.experimental.physics")

    with pytest.raises(ValueError, match=r"/World/Cube is a Cube, not an IsaacImuSensor"):
        sensors.IMUSensor("/World/Cube")
    with pytest.raises(ValueError, match="below a rigid body"):
        sensors.Contact.create("/World/Ground/Contact")
    with pytest.raises(RuntimeError, match="no parent prim"):
        sensors.IMU.create("/Imu")
    with pytest.raises(ValueError, match="one element for each ray"):
        sensors.Raycast.create("/World/Cube/R", ray_origins=[[0, 0, 0]], ray_directions=[[1, 0, 0], [0, 1, 0]])
    assert [sensors.IMU.create("/World/Cube/Imu").path for _ in range(2)] == ["/World/Cube/Imu", "/World/Cube/Imu_01"]


def test_schemas_of_physx_are_asked_for_by_their_classes(resting):
    app, _ = resting
    with graph.isaac.importable():
        schema = import_module("pxr.PhysxSchema")
    prim = app.stage.GetPrimAtPath("/World/Cube")
    assert not prim.HasAPI(schema.PhysxContactReportAPI)
    schema.PhysxContactReportAPI.Apply(prim)
    assert prim.HasAPI(schema.PhysxContactReportAPI)
    assert prim.RemoveAPI(schema.PhysxContactReportAPI)
    assert not prim.HasAPI(schema.PhysxContactReportAPI)
    assert prim.HasAPI(import_module("pxr.UsdPhysics").RigidBodyAPI)


def test_angles_of_a_quarter_turn_do_not_depend_on_the_length_of_its_quaternion():
    with graph.isaac.importable():
        utils = import_module("isaacsim.core.experimental.utils.transform")
    for axis in range(3):
        turn = np.zeros(4)
        turn[[0, axis + 1]] = 0.7071  # a length of 0.99999
        for extrinsic in (True, False):
            angles = utils.quaternion_to_euler_angles(turn, extrinsic=extrinsic).numpy()
            assert angles == pytest.approx(np.pi / 2 * np.eye(3)[axis], abs=1e-3)


def test_a_camera_looks_along_its_negative_z():
    with graph.isaac.importable():
        utils = import_module("isaacsim.core.experimental.utils.transform")
    matrix = utils.look_at_matrix([10, 0, 0], [0, 0, 0])
    assert [-one for one in matrix.GetRow3(2)] == pytest.approx([-1, 0, 0])
    assert list(matrix.ExtractTranslation()) == pytest.approx([10, 0, 0])
    turn = utils.quaternion_to_rotation_matrix(utils.look_at_quaternion([10, 0, 0], [0, 0, 0])).numpy()
    assert -turn[:, 2] == pytest.approx([-1, 0, 0], abs=1e-6)
    straight_down = utils.look_at_quaternion([0, 0, 10], [0, 0, 0]).numpy()
    assert np.linalg.norm(straight_down) == pytest.approx(1)


def test_former_labels_become_present_ones():
    with App() as app, graph.isaac.importable():
        labels = import_module("isaacsim.core.experimental.utils.semantics")
        former = import_module("Semantics").SemanticsAPI
        prim = app.stage.DefinePrim("/World/Box", "Cube")
        old = former.Apply(prim, "class")
        old.CreateSemanticTypeAttr().Set("class")
        old.CreateSemanticDataAttr().Set("box")
        assert labels.upgrade_prim_semantics_to_labels("/World/Box") == ["/World/Box"]
        assert labels.get_labels(prim) == {"class": ["box"]}
        assert labels.upgrade_prim_semantics_to_labels("/World/Box") == []
        labels.remove_all_labels(prim)
        assert labels.get_labels(prim) == {"class": []}


def test_a_free_robot_is_placed_as_a_whole_with_its_joints_as_they_are(tmp_path):
    file = tmp_path / "free.usda"
    joint = PENDULUM.index('def PhysicsFixedJoint "hold"')
    file.write_text(PENDULUM[:joint] + PENDULUM[PENDULUM.index("def PhysicsRevoluteJoint") :])
    with App(stage=str(file)) as app, graph.isaac.importable():
        prims, usdrt = import_module("isaacsim.core.experimental.prims"), import_module("usdrt")
        robot = prims.Articulation("/World/Robot")
        app.play()
        app.update()
        robot.set_dof_positions([np.pi / 2])
        half = np.sqrt(0.5)
        robot.set_world_poses([[1, 2, 3]], [[half, 0, 0, half]])  # a quarter turn about z
        robot.set_velocities([[0, 0, 0]], [[0, 0, 0]])
        robot.set_dof_velocities([0.0])
        base, arm = (app.fabric.world_matrix(f"/World/Robot/{name}") for name in ("base", "arm"))
        assert base[:3, 3] == pytest.approx([1, 2, 3])
        assert base[:3, 0] == pytest.approx([0, 1, 0], abs=1e-9)  # its x axis
        assert arm[:3, 3] == pytest.approx([1, 2, 3])
        assert arm[:3, 0] == pytest.approx([0, 0, -1], abs=1e-9)  # turned by the hinge, about y, then with the base
        assert robot.get_dof_positions().numpy() == pytest.approx(np.array([[np.pi / 2]]))
        app.update(6)
        found = usdrt.Usd.Stage.Attach(0).GetPrimAtPath("/World/Robot/base").GetAttribute("physics:velocity")
        assert tuple(found.Get()) == pytest.approx((0, 0, -1), abs=1e-5)  # 6 steps of 1/60 s at 10 m/s2
        assert usdrt.Usd.Stage.Attach(0).GetPrimAtPath("/ExternalSimulationTime").HasAttribute("omni:time")
