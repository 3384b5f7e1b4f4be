"""Wheeled robots, joints and sensors of bodies as scripts call them, against numbers worked out on paper."""

import math
from importlib import import_module

import numpy as np
import pytest

import graph.isaac
from graph.sim import App
from tests.support.without_wing import needs_wing

ARM = "omniverse://localhost/Isaac/Robots/IsaacSim/SimpleArticulation/simple_articulation.usd"
CUBE = "isaacsim.core.experimental.objects"


def controller(kind, **options):
    with graph.isaac.importable():
        return getattr(import_module("isaacsim.robot.experimental.wheeled_robots.controllers"), kind)(**options)


def test_a_differential_drive_gives_the_left_and_the_right_wheel_and_heeds_a_changed_limit():
    drive = controller("DifferentialController", wheel_radius=0.5, wheel_base=1.0)
    # (v -+ w d / 2) / r = (2 -+ 0.5) / 0.5.
    assert drive.forward([2.0, 1.0]).tolist() == [3.0, 5.0]
    drive.max_wheel_speed = 4
    assert drive.forward([2.0, 1.0]).tolist() == [3.0, 4.0]


@needs_wing("robots")
def test_a_car_steers_all_wheels_about_one_point():
    car = controller("AckermannController", wheel_base=2.0, track_width=1.0, front_wheel_radius=0.5)
    angles, speeds = car.forward([math.atan(2.0 / 4.0), 0.0, 4.0, 0.0, 0.0])
    # The point is 4 m to the left of the back axle's centre; the wheels are 3.5 and 4.5 m from it along that axle.
    assert angles == pytest.approx((math.atan(2 / 3.5), math.atan(2 / 4.5)))
    assert speeds == pytest.approx((math.hypot(2, 3.5) / 0.5, math.hypot(2, 4.5) / 0.5, 7.0, 9.0))


@needs_wing("robots")
@pytest.mark.parametrize("command", [[0.1, 0.0, 1.0], [0.1, 0.2, 1.0, 0.0, 0.0]])
def test_a_car_does_not_steer_without_a_whole_command_or_a_time_step(command):
    car = controller("AckermannController", wheel_base=2.0, track_width=1.0, front_wheel_radius=0.5)
    assert car.forward(command) == (None, None)


@needs_wing("robots")
def test_a_car_speeds_up_at_its_rate():
    car = controller("AckermannController", wheel_base=2.0, track_width=1.0, front_wheel_radius=0.5)
    for _ in range(3):
        _, speeds = car.forward([0.0, 0.0, 1.0, 0.5, 0.2])
    assert speeds == pytest.approx([0.3 / 0.5] * 4)  # 3 steps of 0.1 m/s


@needs_wing("robots")
def test_omniwheels_drive_along_their_axles():
    turned = [[1, 0, 0, 0], [math.sqrt(0.5), 0, 0, math.sqrt(0.5)], [1, 0, 0, 0]]
    body = controller(
        "HolonomicController",
        wheel_radius=[0.1],
        wheel_positions=[[0, 1, 0], [1, 0, 0], [0, -1, 0]],
        wheel_orientations=turned,
        mecanum_angles=[0],
    )
    assert pytest.approx(np.array([[0.1, 0, 0], [0, 0.1, 0], [0.1, 0, 0]])) == body.base_dir.T
    # Wheels 0 and 2 drive along x, wheel 1 along y alone; two share the first way: 1 = 0.1 (a + c), a = c.
    assert body.forward([1.0, 0.0, 0.0])[[0, 2]] == pytest.approx([5.0, 5.0])


@needs_wing("robots")
def test_a_holonomic_drive_names_what_is_missing():
    with pytest.raises(ValueError, match="wheel_positions"):
        controller("HolonomicController", wheel_radius=[0.1])


@needs_wing("robots")
def test_a_path_within_its_limits_begins_and_ends_where_it_was_asked_to():
    with graph.isaac.importable():
        plan = import_module("isaacsim.robot.experimental.wheeled_robots.controllers").quintic_polynomials_planner
    times, xs, ys, _, speeds, accelerations, jerks = plan(0, 0, 0, 0.5, 0, 10, 4, 0, 0.5, 0, 1.0, 1.0, 0.1)
    assert (xs[0], ys[0], speeds[0]) == (0, 0, 0.5)
    assert (xs[-1], ys[-1]) == pytest.approx((10, 4))
    assert times[1] == 0.1
    assert (max(accelerations), max(jerks)) <= (1.0, 1.0)
    with pytest.raises(ValueError, match="keeps max_accel"):
        plan(0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(("angle", "expected"), [(5 * math.pi, math.pi), (1.5 * math.pi, -0.5 * math.pi)])
def test_angles_are_wrapped(angle, expected):
    with graph.isaac.importable():
        wrapped = import_module("isaacsim.robot.wheeled_robots.controllers.stanley_control").normalize_angle
    assert abs(wrapped(angle)) == pytest.approx(abs(expected))
    with pytest.raises(ValueError, match="finite"):
        wrapped(math.nan)


@pytest.fixture
def arm():
    """A stiff arm on a fixed pivot, and a slider on it; it plays."""
    with App() as app, graph.isaac.importable():
        stage = import_module("isaacsim.core.experimental.utils.stage")
        stage.add_reference_to_stage(ARM, "/Articulation")
        robot = import_module("isaacsim.core.experimental.prims").Articulation("/Articulation")
        app.play()
        app.update()
        yield app, robot


@needs_wing("stand_ins")
def test_a_placed_joint_stays_there_because_its_target_moves_with_it(arm):
    app, robot = arm
    robot.set_dof_positions([0.5, 0.2])
    assert robot.get_dof_position_targets().numpy()[0] == pytest.approx([0.5, 0.2])
    app.update(steps=30)
    assert robot.get_dof_positions().numpy()[0] == pytest.approx([0.5, 0.2], abs=1e-3)


@needs_wing("stand_ins")
def test_a_joint_that_was_given_a_speed_goes_on(arm):
    app, robot = arm
    robot.set_dof_velocities([0.3, 0.0])
    app.update()
    assert robot.get_dof_velocities().numpy()[0][0] == pytest.approx(0.3, abs=0.02)


@needs_wing("stand_ins")
def test_a_moving_articulation_is_where_its_base_link_is():
    with App() as app, graph.isaac.importable():
        root = "omniverse://localhost/Isaac/Robots/NVIDIA/Jetbot/jetbot.usd"
        import_module("isaacsim.core.experimental.objects").GroundPlane("/World/Ground")
        robot = import_module("isaacsim.robot.experimental.wheeled_robots.robots").WheeledRobot(
            "/World/Jetbot", wheel_dof_names=["left_wheel_joint", "right_wheel_joint"], usd_path=root
        )
        app.play()
        app.update(steps=30)
        robot.apply_wheel_actions([5.0, 5.0])
        app.update(steps=30)
        before = robot.get_world_poses()[0].numpy()[0]
        app.update(steps=60)
        # Wheels of 3 cm at 5 rad/s: 0.15 m in a second.
        assert np.linalg.norm(robot.get_world_poses()[0].numpy()[0] - before) == pytest.approx(0.15, abs=0.02)


def test_a_sensor_of_a_removed_prim_reads_invalid_and_the_run_goes_on():
    with App() as app, graph.isaac.importable():
        objects, prims = import_module(CUBE), import_module("isaacsim.core.experimental.prims")
        sensors = import_module("isaacsim.sensors.experimental.physics")
        objects.Cube("/World/Cube", sizes=1.0, positions=[0, 0, 5])
        prims.RigidPrim("/World/Cube", masses=[1.0])
        sensor = sensors.IMUSensor(sensors.IMU.create("/World/Cube/imu"))
        app.play()
        app.update(steps=3)
        assert sensor.get_sensor_reading().is_valid
        app.stage.RemovePrim("/World/Cube/imu")
        app.update(steps=2)
        assert not sensor.get_sensor_reading().is_valid


def test_the_data_of_a_contact_sensor_are_one_dictionary_that_raw_contacts_join_and_leave():
    with App() as app, graph.isaac.importable():
        objects, prims = import_module(CUBE), import_module("isaacsim.core.experimental.prims")
        sensors = import_module("isaacsim.sensors.experimental.physics")
        objects.Cube("/World/Cube", sizes=1.0)
        prims.RigidPrim("/World/Cube", masses=[1.0])
        sensor = sensors.ContactSensor(sensors.Contact.create("/World/Cube/contact"))
        app.play()
        app.update(steps=2)
        data = sensor.get_data()
        assert "contacts" not in data
        sensor.add_raw_contact_data_to_frame()
        assert "contacts" in data
        assert sensor.get_data() is data
        sensor.remove_raw_contact_data_from_frame()
        assert "contacts" not in data


def falling_imu():
    """An IMU on a cube in free fall, and the class that reads it."""
    objects, prims = import_module(CUBE), import_module("isaacsim.core.experimental.prims")
    sensors = import_module("isaacsim.sensors.experimental.physics")
    objects.Cube("/World/Cube", sizes=1.0, positions=[0, 0, 50])
    prims.RigidPrim("/World/Cube", masses=[1.0])
    return sensors.IMUSensor(sensors.IMU.create("/World/Cube/imu")), sensors.IMUSensor


def test_a_second_reader_of_an_imu_has_its_readings_at_once():
    with App() as app, graph.isaac.importable():
        first, kind = falling_imu()
        app.play()
        app.update(steps=3)
        second = kind("/World/Cube/imu").get_sensor_reading()
        assert second == first.get_sensor_reading()
        assert (second.is_valid, second.linear_acceleration_z) == (True, pytest.approx(0, abs=1e-6))


def test_an_imu_reads_what_physics_steps_without_updates():
    with App() as app, graph.isaac.importable():
        sensor, _ = falling_imu()
        manager = import_module("isaacsim.core.simulation_manager").SimulationManager
        app.timeline.play()
        manager.initialize_physics()
        manager.step(steps=3)
        reading = sensor.get_sensor_reading(read_gravity=False)
        assert (reading.is_valid, reading.linear_acceleration_z) == (True, pytest.approx(-9.81, abs=1e-6))


def test_an_imu_begins_again_after_a_stop():
    with App() as app, graph.isaac.importable():
        sensor, _ = falling_imu()
        app.play()
        app.update(steps=3)
        app.stop()
        app.update()
        assert not sensor.get_sensor_reading().is_valid
        app.play()
        app.update(steps=2)
        assert sensor.get_sensor_reading().is_valid


def test_a_controller_of_one_attribute_reads_and_sets_it():
    with App(), graph.isaac.importable():
        og = import_module("omni.graph.core")
        keys = og.Controller.Keys
        og.Controller.edit("/G", {keys.CREATE_NODES: [("a", "omni.graph.nodes.ConstantDouble")]})
        one = og.Controller(og.Controller.attribute("/G/a.inputs:value"))
        one.set(2.5)
        assert one.get() == 2.5


@needs_wing("stand_ins")
def test_an_output_is_there_when_a_script_first_reads_it(run_script):
    code, out, err = run_script(f"""
from isaacsim import SimulationApp
app = SimulationApp()
import omni.graph.core as og, omni.timeline
from isaacsim.core.experimental.utils.stage import add_reference_to_stage
add_reference_to_stage("{ARM}", "/Articulation")
keys = og.Controller.Keys
og.Controller.edit({{"graph_path": "/G", "evaluator_name": "execution"}}, {{
    keys.CREATE_NODES: [
        ("tick", "omni.graph.action.OnPlaybackTick"),
        ("joints", "isaacsim.sensors.physics.IsaacReadJointState"),
    ],
    keys.CONNECT: [("tick.outputs:tick", "joints.inputs:execIn")],
    keys.SET_VALUES: [("joints.inputs:prim", ["/Articulation"])],
}})
omni.timeline.get_timeline_interface().play()
for _ in range(3):
    app.update()
print(len(og.Controller.get("/G/joints.outputs:jointEfforts")))
app.close()
""")
    assert (code, out.split()) == (0, ["2"]), err
