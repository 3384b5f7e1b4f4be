import math

import pytest

from graph import ComputeError
from graph.testing import run_node


@pytest.fixture
def chassis(stage, world):
    """A function that opens a world with a cube in free flight: speed (1, 2, 0) m/s, turn rate 90 deg/s about z."""
    from pxr import UsdGeom, UsdPhysics

    scene = UsdPhysics.Scene.Define(stage, "/World/Physics")
    scene.GetGravityMagnitudeAttr().Set(0.0)
    cube = UsdGeom.Cube.Define(stage, "/World/Cube")
    cube.GetSizeAttr().Set(1)
    cube.AddTranslateOp().Set((10, 0, 5))
    cube.AddRotateZOp().Set(90)
    body = UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
    body.GetVelocityAttr().Set((1, 2, 0))
    body.GetAngularVelocityAttr().Set((0, 0, 90))
    return lambda: world(physics_hz=240, loop_hz=60)


def odometry(app, updates, prim="/World/Cube"):
    inputs = {"chassisPrim": prim}
    return run_node("IsaacComputeOdometry", inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def test_motion_is_relative_to_the_pose_of_the_first_reading(chassis):
    trace = odometry(chassis(), 61)
    assert trace.fired("execOut") == list(range(61))
    assert trace.values("position")[0].tolist() == [0, 0, 0]
    # After 1 s it is (1, 2, 0) m on in the world; at the first reading it had turned by 90 deg + 1.5 deg (one update).
    first = math.radians(91.5)
    expected = [
        math.cos(first) * 1 + math.sin(first) * 2,
        -math.sin(first) * 1 + math.cos(first) * 2,
        0,
    ]
    assert trace.value("position") == pytest.approx(expected, abs=1e-3)
    assert trace.value("orientation") == pytest.approx([0, 0, math.sqrt(0.5), math.sqrt(0.5)], abs=1e-4)


def test_velocities_are_given_along_both_sets_of_axes(chassis):
    trace = odometry(chassis(), 1)
    assert trace.value("globalLinearVelocity") == pytest.approx([1, 2, 0], abs=1e-6)
    assert trace.value("angularVelocity") == pytest.approx([0, 0, math.pi / 2], abs=1e-6)
    turn = math.radians(91.5)
    expected = [math.cos(turn) + 2 * math.sin(turn), -math.sin(turn) + 2 * math.cos(turn), 0]
    assert trace.value("linearVelocity") == pytest.approx(expected, abs=1e-3)


def test_accelerations_are_differences_over_simulation_time(chassis):
    trace = odometry(chassis(), 3)
    assert trace.values("linearAcceleration")[0].tolist() == [0, 0, 0]
    before, after = trace.values("linearVelocity")[1:]
    assert trace.value("linearAcceleration") == pytest.approx((after - before) * 60)
    assert trace.value("globalLinearAcceleration") == pytest.approx([0, 0, 0], abs=1e-6)


@pytest.mark.parametrize(
    ("prim", "message"),
    [
        ("/World/Gone", "there is no prim /World/Gone"),
        ("/World", "/World is not a rigid body that can move"),
        ([], "chassisPrim names 0 prims"),
    ],
)
def test_what_is_not_a_chassis_is_reported(chassis, prim, message):
    with pytest.raises(ComputeError, match=message):
        odometry(chassis(), 1, prim)
