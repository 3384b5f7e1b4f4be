import math

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node

# Three wheels at 0, 120, 240 degrees on a circle of 0.5 m, axles outwards (the joint's x), driving across (90 degrees).
ANGLES = [0, 2 * math.pi / 3, 4 * math.pi / 3]
THREE = {
    "wheelRadius": [0.1],
    "wheelPositions": [[0.5 * math.cos(a), 0.5 * math.sin(a), 0] for a in ANGLES],
    "wheelOrientations": [[math.cos(a / 2), 0, 0, math.sin(a / 2)] for a in ANGLES],
    "mecanumAngles": [90],
}


def drive(velocity, **inputs):
    given = {**THREE, "inputVelocity": velocity, **inputs}
    return run_node("HolonomicController", inputs=given, pulses={"execIn": [0]}).value("jointVelocityCommand")


def test_the_wheels_share_a_sideways_velocity():
    # Directions: (0, 1), (-sin 120, cos 120), (-sin 240, cos 240). Their sum of squares is 1.5: speed x 2 / 3 / radius.
    assert drive([0, 0.3, 0]) == pytest.approx([2.0, -1.0, -1.0])


def test_the_wheels_share_a_forward_velocity():
    half = math.sqrt(3) / 2
    assert drive([0.3, 0, 0]) == pytest.approx([0, -2 * half, 2 * half], abs=1e-12)


def test_to_turn_all_wheels_roll_alike():
    # direction x position is (0, 1) x (0.5, 0) = -0.5 for each: three wheels of 0.1 m give 0.15 m2 per rad/s.
    assert drive([0, 0, 0.3]) == pytest.approx([-2.0] * 3)


def test_the_drives_add_up_to_the_velocity():
    positions = np.array(THREE["wheelPositions"])
    directions = np.array([[-math.sin(a), math.cos(a)] for a in ANGLES])
    drives = drive([0.4, -0.7, 1.1])[:, None] * 0.1 * directions
    assert drives.sum(axis=0) == pytest.approx([0.4, -0.7])
    assert (drives[:, 0] * positions[:, 1] - drives[:, 1] * positions[:, 0]).sum() == pytest.approx(1.1)


def test_of_four_wheels_the_least_effort_is_taken():
    places = [[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]]
    turns = [[1, 0, 0, 0]] * 4
    found = drive(
        [0.4, 0, 0],
        wheelPositions=places,
        wheelOrientations=turns,
        wheelAxis=[0, 1, 0],
        mecanumAngles=[-135, -45, -45, -135],
    )
    # -45 degrees from y is (s, s), -135 degrees (s, -s), s = sqrt(1/2): each gives a quarter of 0.4 / (0.1 s).
    assert found == pytest.approx([math.sqrt(2)] * 4)


def test_gains_and_limits():
    assert drive([0, 0.3, 0], linearGain=2.0) == pytest.approx([4.0, -2.0, -2.0])
    assert drive([0, 0, 0.3], angularGain=0.5) == pytest.approx([-1.0] * 3)
    assert drive([0, 3.0, 0], maxLinearSpeed=0.3) == pytest.approx([2.0, -1.0, -1.0])
    assert drive([0, 0, -3.0], maxAngularSpeed=0.3) == pytest.approx([2.0] * 3)
    assert drive([0, 3.0, 0], maxWheelSpeed=4.0) == pytest.approx([4.0, -2.0, -2.0])


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"wheelRadius": [0.1, 0.1]}, "wheelRadius has 2 entries for 3 wheels"),
        ({"wheelRadius": [0.0]}, "wheelRadius has an entry that is not a positive length"),
        ({"wheelOrientations": [[1, 0, 0, 0]]}, "wheelPositions has 3 and wheelOrientations 1 entries"),
        ({"wheelAxis": [0, 0, 0]}, "wheelOrientations, wheelAxis and upAxis must not be zero"),
        (
            {"wheelOrientations": [[1, 0, 0, 0]] * 3},
            "the wheels cannot drive forward, sideways and round independently",
        ),
    ],
)
def test_what_is_not_a_platform_is_reported(inputs, message):
    with pytest.raises(ComputeError, match=message):
        drive([1, 0, 0], **inputs)


@pytest.fixture
def platform(stage):
    """/World/Bot at (1, 2, 0), turned by 90 degrees about z, with wheel joints at (0.3, 0.2, 0) and behind."""
    from pxr import Sdf, UsdGeom, UsdPhysics

    bot = UsdGeom.Xform.Define(stage, "/World/Bot")
    bot.AddTranslateOp().Set((1, 2, 0))
    bot.AddRotateZOp().Set(90)
    UsdGeom.Xform.Define(stage, "/World/Bot/body")
    for name, x in (("front", 0.3), ("back", -0.3)):
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/World/Bot/{name}")
        joint.GetAxisAttr().Set("Y")
        joint.GetBody0Rel().SetTargets(["/World/Bot/body"])
        joint.GetLocalPos0Attr().Set((x, 0.2, 0))
        prim = joint.GetPrim()
        prim.CreateAttribute("isaacmecanumwheel:radius", Sdf.ValueTypeNames.Float).Set(0.125)
        prim.CreateAttribute("isaacmecanumwheel:angle", Sdf.ValueTypeNames.Float).Set(45.0)
    return stage


def setup(app, **inputs):
    return run_node("HolonomicRobotUsdSetup", inputs=inputs, app=app)


def test_wheels_are_read_from_their_joints_in_the_robots_frame(platform, world):
    trace = setup(world(), robotPrim=["/World/Bot"])
    assert trace.value("wheelDofNames") == ["front", "back"]
    assert trace.value("wheelRadius").tolist() == [0.125, 0.125]
    assert trace.value("mecanumAngles").tolist() == [45, 45]
    assert trace.value("wheelPositions") == pytest.approx(np.array([[0.3, 0.2, 0], [-0.3, 0.2, 0]]), abs=1e-6)
    assert trace.value("wheelOrientations") == pytest.approx(np.array([[1, 0, 0, 0]] * 2), abs=1e-6)
    assert trace.value("wheelAxis").tolist() == [0, 1, 0]
    assert trace.value("upAxis").tolist() == [0, 0, 1]


def test_the_centre_may_be_another_prim_and_both_be_given_as_paths(platform, world):
    from pxr import UsdGeom

    UsdGeom.Xform.Define(platform, "/World/Centre").AddTranslateOp().Set((1, 2, 0.5))
    inputs = {"usePath": True, "robotPrimPath": "/World/Bot", "comPrimPath": "/World/Centre"}
    trace = setup(world(), **inputs)
    assert trace.value("wheelPositions")[0] == pytest.approx([-0.2, 0.3, -0.5], abs=1e-6)
    half = math.sqrt(0.5)
    assert trace.value("wheelOrientations")[0] == pytest.approx([half, 0, 0, half], abs=1e-6)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({}, "no robot; set robotPrim"),
        ({"robotPrim": ["/World/Gone"]}, "there is no prim /World/Gone"),
    ],
)
def test_a_robot_that_is_not_there_is_reported(platform, world, inputs, message):
    with pytest.raises(ComputeError, match=message):
        setup(world(), **inputs)


def test_a_robot_without_wheels_is_a_warning(platform, world):
    trace = setup(world(), robotPrim=["/World/Bot/body"])
    assert len(trace.value("wheelRadius")) == 0
    assert [(one.code, one.message.partition(":")[0]) for one in trace.warnings] == [
        ("wheels-missing", "/World/Bot/body has no wheels")
    ]


def test_what_has_wheel_attributes_and_is_not_a_revolute_joint_is_reported(platform, world):
    from pxr import Sdf

    body = platform.GetPrimAtPath("/World/Bot/body")
    body.CreateAttribute("isaacmecanumwheel:angle", Sdf.ValueTypeNames.Float).Set(45.0)
    with pytest.raises(ComputeError, match="a prim below /World/Bot has isaacmecanumwheel:angle and is not a revolute"):
        setup(world(), robotPrim=["/World/Bot"])
