"""What an IMU feels, by hand: at rest, falling, turning."""

import math

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from sensors.inertial import InertialUnit

SENSOR = "/World/Box/Imu"


@pytest.fixture
def box(stage, world):
    """A function that opens a world with a 2 kg box of 1 m (centre 0.5 m up, on the ground unless given) and an IMU."""
    from pxr import UsdGeom, UsdPhysics

    def open_world(height=0.5, ground=True, place=(0, 0, 0), turn=(0, 0, 0), gravity=None, widths=None, **body):
        if gravity is not None:
            UsdPhysics.Scene.Define(stage, "/World/Physics").GetGravityMagnitudeAttr().Set(gravity)
        if ground:
            UsdPhysics.CollisionAPI.Apply(UsdGeom.Plane.Define(stage, "/World/Ground").GetPrim())
        cube = UsdGeom.Cube.Define(stage, "/World/Box")
        cube.GetSizeAttr().Set(1)
        cube.AddTranslateOp().Set((0, 0, height))
        rigid = UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
        if ground:
            UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
        UsdPhysics.MassAPI.Apply(cube.GetPrim()).GetMassAttr().Set(2.0)
        for name, value in body.items():
            getattr(rigid, f"Get{name}Attr")().Set(value)
        sensor = stage.DefinePrim(SENSOR, "IsaacImuSensor")
        xform = UsdGeom.Xformable(sensor)
        xform.AddTranslateOp().Set(place)
        xform.AddRotateXYZOp().Set(turn)
        for name, width in (widths or {}).items():
            sensor.GetAttribute(f"{name}FilterWidth").Set(width)
        return world(physics_hz=240, loop_hz=60)

    return open_world


def read(app, updates, **inputs):
    inputs = {"imuPrim": [SENSOR], **inputs}
    return run_node("IsaacReadIMU", inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def test_at_rest_it_feels_gravity_upwards(box):
    trace = read(box(), 60)
    assert trace.value("linAcc") == pytest.approx([0, 0, 9.81], abs=1e-3)
    assert trace.value("angVel") == pytest.approx([0, 0, 0], abs=1e-4)
    assert trace.value("orientation") == pytest.approx([0, 0, 0, 1], abs=1e-4)
    assert trace.value("sensorTime") == pytest.approx(1.0)


def test_the_first_compute_starts_it_and_readings_follow_from_the_next_step_on(box):
    trace = read(box(), 3)
    assert trace.fired("execOut") == [1, 2]
    assert trace.values("sensorTime") == pytest.approx([0, 2 / 60, 3 / 60])
    assert trace.values("linAcc")[0].tolist() == [0, 0, 0]


def test_it_may_leave_gravity_out(box):
    assert read(box(), 60, readGravity=False).value("linAcc") == pytest.approx([0, 0, 0], abs=1e-3)


def test_a_turned_sensor_feels_gravity_along_its_own_axes(box):
    trace = read(box(turn=(90, 0, 0)), 60)
    assert trace.value("linAcc") == pytest.approx([0, 9.81, 0], abs=1e-3)  # its y axis points up
    half = math.sqrt(0.5)
    assert trace.value("orientation") == pytest.approx([half, 0, 0, half], abs=1e-4)


def test_falling_it_feels_nothing(box):
    app = box(height=50, ground=False)
    assert read(app, 10).value("linAcc") == pytest.approx([0, 0, 0], abs=1e-9)
    assert read(app, 2, readGravity=False).value("linAcc") == pytest.approx([0, 0, -9.81], abs=1e-9)


def test_in_a_turn_it_feels_the_pull_to_the_centre(box):
    app = box(ground=False, gravity=0.0, place=(2, 0, 0), AngularVelocity=(0, 0, 90))
    trace = read(app, 30)
    # 2 m from the centre, pi / 2 rad/s: 2 (pi / 2)^2 towards it; half a step of 1/240 s behind, that is 0.19 degrees.
    pull = 2 * (math.pi / 2) ** 2
    assert trace.value("linAcc") == pytest.approx([-pull, pull * math.pi / 2 / 480, 0], abs=2e-3)
    assert trace.value("angVel") == pytest.approx([0, 0, math.pi / 2], abs=1e-6)


def test_readings_are_averaged_over_the_filter_width(box):
    app = box(height=0.7, widths={"linearAcceleration": 8})
    single = []
    app.play()
    unit, wide = InertialUnit(app.world, SENSOR), InertialUnit(app.world, SENSOR, (8, 1, 1))
    app.on("physics_post_step", lambda: single.append(unit.reading().acceleration), order=1)
    app.update(15)
    assert np.std([one[2] for one in single]) > 1  # it has hit the ground
    assert wide.reading().acceleration == pytest.approx(np.mean(single[-8:], axis=0))


def test_a_sensor_that_is_off_reads_nothing(box):
    app = box()
    app.stage.GetPrimAtPath(SENSOR).GetAttribute("enabled").Set(False)
    trace = read(app, 5)
    assert trace.fired("execOut") == []
    assert trace.value("linAcc").tolist() == [0, 0, 0]


def test_on_a_body_that_is_held_it_feels_gravity_and_no_motion(stage, box):
    from pxr import UsdPhysics

    app = box(height=5)
    joint = UsdPhysics.FixedJoint.Define(stage, "/World/Hold")
    joint.GetBody1Rel().SetTargets(["/World/Box"])
    joint.GetLocalPos0Attr().Set((0, 0, 5))
    assert read(app, 3).value("linAcc").tolist() == [0, 0, 9.81]


def test_a_second_play_starts_again(box):
    app = box()
    read(app, 5)
    app.stop()
    assert read(app, 3).fired("execOut") == [1, 2]


@pytest.mark.parametrize(
    ("prims", "message"),
    [
        ([], "input imuPrim names 0 prims"),
        (["/World/Gone"], "there is no prim /World/Gone"),
        (["/World/Ground"], "/World/Ground: it is on no rigid body; put it on one, or below"),
    ],
)
def test_what_is_not_a_sensor_is_reported(box, prims, message):
    with pytest.raises(ComputeError, match=message):
        read(box(), 2, imuPrim=prims)


def test_a_graph_file_may_hold_the_sensor_and_a_graph_that_reads_it(tmp_path):
    from graph.sim import App

    (tmp_path / "imu.yaml").write_text(
        """tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Box: {type: Cube, size: 1.0, translate: [0, 0, 0.5], rigid_body: true, mass: 2.0}
    /World/Box/Imu: {type: IsaacImuSensor, rotate: [90, 0, 0], attributes: {linearAccelerationFilterWidth: 4}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      imu: {type: IsaacReadIMU, inputs: {imuPrim: /World/Box/Imu}}
    connections: [tick.tick -> imu.execIn]
"""
    )
    with App.from_file(tmp_path / "imu.yaml") as app:
        app.play()
        app.update(60)
        assert app.graphs["/World/G"].nodes["imu"].get("linAcc") == pytest.approx([0, 9.81, 0], abs=1e-3)


def test_an_imu_read_in_every_physics_step_has_a_reading_of_each_step_after_the_first(tmp_path):
    """The first compute, in step 1, starts the sensor: 200 steps give 199 readings, each of its own step."""
    from graph.sim import App

    (tmp_path / "g.yaml").write_text(
        "tickgraph: 1\nscene:\n  prims:\n    /World/Box: {type: Cube, size: 0.2, rigid_body: true}\n"
        "clock: {physics_hz: 240, loop_hz: 60}\n"
        "graphs:\n  /G:\n    pipeline_stage: on_demand\n    nodes:\n      step: OnPhysicsStep\n"
        "      imu: {type: IsaacReadIMU, inputs: {imuPrim: /World/Box}}\n      count: Counter\n"
        "    connections: [step.step -> imu.execIn, imu.execOut -> count.execIn]\n"
    )
    with App.from_file(tmp_path / "g.yaml") as app:
        app.play()
        app.update(50)
        nodes = app.graphs["/G"].nodes
        assert nodes["count"].get("count") == 199
        assert nodes["imu"].get("sensorTime") == pytest.approx(200 / 240, abs=1e-6)
