import pytest

from graph import ComputeError
from graph.testing import run_node

ROOT = "/World/Hand"


@pytest.fixture
def hand(stage, world):
    """A function that opens a world with two fingers on driven slides, from 0 to 4 cm (stage units are metres)."""
    from pxr import UsdGeom, UsdPhysics

    UsdPhysics.ArticulationRootAPI.Apply(UsdGeom.Xform.Define(stage, ROOT).GetPrim())

    def open_world(limits=(0.0, 0.04)):
        for name in ("left", "right"):
            finger = UsdGeom.Xform.Define(stage, f"{ROOT}/{name}")
            UsdPhysics.RigidBodyAPI.Apply(finger.GetPrim())
            mass = UsdPhysics.MassAPI.Apply(finger.GetPrim())
            mass.GetMassAttr().Set(0.1)
            mass.GetDiagonalInertiaAttr().Set((1e-4, 1e-4, 1e-4))
            joint = UsdPhysics.PrismaticJoint.Define(stage, f"{ROOT}/{name}_joint")
            joint.GetAxisAttr().Set("X")
            joint.GetBody1Rel().SetTargets([f"{ROOT}/{name}"])
            if limits:
                joint.GetLowerLimitAttr().Set(limits[0])
                joint.GetUpperLimitAttr().Set(limits[1])
            drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "linear")
            drive.GetStiffnessAttr().Set(1e4)
            drive.GetDampingAttr().Set(1e2)
        return world(physics_hz=240, loop_hz=60)

    return open_world


def grip(app, pulses, updates, consumed=(), **inputs):
    given = {
        "articulationRootPrim": [ROOT],
        "jointNames": ["left_joint", "right_joint"],
        "gripperSpeed": [0.01],
        **inputs,
    }
    node = "IsaacGripperController"
    return run_node(node, inputs=given, pulses=pulses, updates=updates, app=app, consumed=list(consumed))


def commands(trace):
    return [round(float(left), 6) for left, _ in trace.values("positionCommands")]


def test_fingers_open_step_by_step_to_their_limits_and_close_again(hand):
    pulses = {"open": [0], "close": [6], "execIn": [*range(1, 6), *range(7, 12)]}
    trace = grip(hand(), pulses, 12)
    assert commands(trace) == [0.01, 0.02, 0.03, 0.04, 0.04, 0.04, 0.03, 0.02, 0.01, 0, 0, 0]
    assert trace.value("outputs:jointNames") == ["left_joint", "right_joint"]


def test_the_fingers_follow_where_nobody_takes_the_commands(hand):
    app = hand()
    grip(app, {"open": [0], "execIn": range(1, 60)}, 60)
    assert app.physics.articulation(ROOT).positions == pytest.approx([0.04, 0.04], abs=1e-4)


def test_commands_that_go_elsewhere_are_not_sent(hand):
    app = hand()
    trace = grip(app, {"open": [0], "execIn": range(1, 60)}, 60, consumed=["positionCommands"])
    assert commands(trace)[-1] == 0.04
    assert app.physics.articulation(ROOT).positions == pytest.approx([0, 0], abs=1e-4)


def test_before_a_command_the_fingers_stay_and_stop_holds_them(hand):
    app = hand()
    trace = grip(app, {"execIn": [0, 1, *range(3, 8)], "open": [2], "stop": [5]}, 8, gripperSpeed=[0.001])
    found = commands(trace)
    assert found[:2] == [0, 0]
    assert found[2:5] == [0.001, 0.002, 0.003]
    assert found[5] < 0.003
    assert found[5:] == [found[5]] * 3


def test_positions_and_speeds_may_be_given_per_joint(hand):
    inputs = {"openPosition": [0.02, 0.03], "closePosition": [0.01], "gripperSpeed": [0.01, 0.02]}
    trace = grip(hand(), {"open": [0], "execIn": [1, 2]}, 3, **inputs)
    assert [one.round(6).tolist() for one in trace.values("positionCommands")] == [
        [0.01, 0.02],
        [0.02, 0.03],
        [0.02, 0.03],
    ]


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"articulationRootPrim": []}, "articulationRootPrim names 0 prims"),
        ({"jointNames": ["thumb"]}, "no joint thumb; the robot has left_joint, right_joint"),
        ({"jointNames": []}, "no jointNames; the robot has left_joint, right_joint"),
        ({"gripperSpeed": []}, "gripperSpeed must be above 0"),
        ({"gripperSpeed": [0.1, 0.0]}, "gripperSpeed must be above 0"),
        ({"openPosition": [1.0, 2.0, 3.0]}, "openPosition has 3 entries for 2 joints"),
    ],
)
def test_what_is_not_a_gripper_is_reported(hand, inputs, message):
    with pytest.raises(ComputeError, match=message):
        grip(hand(), {"open": [0]}, 1, **inputs)


def test_joints_without_limits_need_positions(hand):
    with pytest.raises(ComputeError, match="the joints have no limits to take instead"):
        grip(hand(limits=None), {"open": [0]}, 1)
