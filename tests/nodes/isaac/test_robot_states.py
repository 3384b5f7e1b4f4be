"""What joints do and bear, what they are called, where links are."""

import math

import pytest

from graph import ComputeError
from graph.testing import run_node

ROOT = "/World/Arm"


@pytest.fixture
def arm(stage, world):
    """A function that opens a world with an arm of 2 kg along +x: its centre 0.5 m from a held hinge about y."""
    from pxr import Sdf, UsdGeom, UsdPhysics

    root = UsdGeom.Xform.Define(stage, ROOT)
    UsdPhysics.ArticulationRootAPI.Apply(root.GetPrim())
    root.AddTranslateOp().Set((0, 0, 3))
    link = UsdGeom.Xform.Define(stage, f"{ROOT}/Link")
    link.AddTranslateOp().Set((0.5, 0, 0))
    UsdPhysics.RigidBodyAPI.Apply(link.GetPrim())
    mass = UsdPhysics.MassAPI.Apply(link.GetPrim())
    mass.GetMassAttr().Set(2.0)
    mass.GetDiagonalInertiaAttr().Set((0.1, 0.1, 0.1))
    joint = UsdPhysics.RevoluteJoint.Define(stage, f"{ROOT}/shoulder")
    joint.GetPrim().CreateAttribute("isaac:nameOverride", Sdf.ValueTypeNames.String).Set("arm_1")
    joint.GetAxisAttr().Set("Y")
    joint.GetBody1Rel().SetTargets([f"{ROOT}/Link"])
    joint.GetLocalPos0Attr().Set((0, 0, 3))
    joint.GetLocalPos1Attr().Set((-0.5, 0, 0))

    def open_world(stiffness=1e6, limit=None):
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
        drive.GetStiffnessAttr().Set(stiffness)
        drive.GetDampingAttr().Set(stiffness / 20)
        if limit is not None:
            joint.GetUpperLimitAttr().Set(limit)
        return world(physics_hz=240)

    return open_world


def state(app, updates=120, **inputs):
    inputs = {"robotPath": ROOT, **inputs}
    return run_node(
        "IsaacArticulationState", inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app
    )


def test_a_held_arm_bears_its_weight_and_the_torque_of_it(arm):
    trace = state(arm())
    assert trace.value("jointNames") == ["shoulder"]
    assert trace.value("jointPositions") == pytest.approx([0], abs=1e-4)
    assert trace.value("jointVelocities") == pytest.approx([0], abs=1e-4)
    # 2 kg at 0.5 m: gravity turns it by +9.81 N m about y, the drive holds with -9.81 N m.
    assert trace.value("measuredJointEfforts") == pytest.approx([-9.81], rel=1e-3)
    assert trace.value("measuredJointForces")[0] == pytest.approx([0, 0, 19.62], abs=0.01)
    assert trace.value("measuredJointTorques")[0] == pytest.approx([0, -9.81, 0], abs=0.01)


def test_a_limit_holds_as_a_drive_does(arm):
    trace = state(arm(stiffness=0.0, limit=0.0), updates=300)
    assert trace.value("measuredJointEfforts") == pytest.approx([-9.81], rel=0.01)


def test_a_free_arm_bears_nothing_along_its_hinge(arm):
    trace = state(arm(stiffness=0.0), updates=1)
    assert trace.value("measuredJointEfforts") == pytest.approx([0], abs=1e-9)
    # It starts to fall: 9.81 N m over 0.1 + 2 * 0.25 = 0.6 kg m2 is 16.35 rad/s2.
    assert trace.value("jointVelocities") == pytest.approx([16.35 / 60], rel=0.01)


def test_joints_are_chosen_by_name_or_index(arm):
    app = arm()
    assert state(app, 1, jointNames=["shoulder"]).value("jointNames") == ["shoulder"]
    assert state(app, 1, jointIndices=[0]).value("jointPositions").shape == (1,)
    with pytest.raises(ComputeError, match="no joint elbow; the robot has shoulder"):
        state(app, 1, jointNames=["elbow"])


def test_a_state_without_robot_is_refused(arm):
    with pytest.raises(ComputeError, match="no robot; set targetPrim or robotPath"):
        state(arm(), 1, robotPath="")


def test_names_that_override_are_resolved_to_prim_names(arm):
    inputs = {"targetPrim": ROOT, "jointNames": ["arm_1", "other"]}
    trace = run_node("IsaacJointNameResolver", inputs=inputs, pulses={"execIn": [0]}, app=arm())
    assert trace.value("jointNames") == ["shoulder", "other"]
    assert trace.value("robotPath") == ROOT
    assert trace.fired("execOut") == [0]


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        ("", "no robot; set targetPrim or robotPath"),
        ("/World/Gone", "there is no prim /World/Gone"),
        ("/World/Ground", "/World/Ground is not a robot: it has no joints"),
    ],
)
def test_what_has_no_joints_to_name_is_reported(arm, robot, message):
    app = arm()
    app.stage.DefinePrim("/World/Ground", "Xform")
    with pytest.raises(ComputeError, match=message):
        run_node("IsaacJointNameResolver", inputs={"robotPath": robot}, pulses={"execIn": [0]}, app=app)


def test_links_are_placed_in_a_parent_prim(stage, arm):
    from pxr import UsdGeom

    base = UsdGeom.Xform.Define(stage, "/World/Base")
    base.AddTranslateOp().Set((0, 1, 3))
    base.AddRotateZOp().Set(90)
    inputs = {"parentPrim": "/World/Base", "targetPrims": [ROOT]}
    trace = run_node("IsaacComputeTransformTree", inputs=inputs, pulses={"execIn": [0]}, app=arm())
    assert trace.value("parentFrames") == ["Base"]
    assert trace.value("childFrames") == ["Link"]
    # (0.5, -1, 0) m from the base, seen with its x along +y and its y along -x.
    assert trace.value("translations")[0] == pytest.approx([-1, -0.5, 0], abs=1e-3)
    half = math.sqrt(0.5)
    assert trace.value("orientations")[0] == pytest.approx([0, 0, -half, half], abs=1e-3)
    assert trace.fired("execOut") == [0]


def test_sites_of_a_robot_are_frames_in_their_links(arm, stage):
    """The arm's link lies along x; the mount is 0.2 m up in it."""
    from pxr import UsdGeom

    mount = UsdGeom.Xform.Define(stage, f"{ROOT}/Link/mount")
    mount.AddTranslateOp().Set((0, 0, 0.2))
    mount.GetPrim().AddAppliedSchema("IsaacSiteAPI")
    UsdGeom.Xform.Define(stage, f"{ROOT}/Link/other")
    trace = run_node("IsaacComputeTransformTree", inputs={"targetPrims": [ROOT]}, pulses={"execIn": [0]}, app=arm())
    assert list(zip(trace.value("parentFrames"), trace.value("childFrames"), strict=True))[-1] == ("Link", "mount")
    assert trace.value("translations")[-1] == pytest.approx([0, 0, 0.2], abs=1e-6)
    assert "other" not in trace.value("childFrames")


def test_a_tree_needs_prims_that_are_there(arm):
    app = arm()
    with pytest.raises(ComputeError, match="nothing to place; set targetPrims"):
        run_node("IsaacComputeTransformTree", pulses={"execIn": [0]}, app=app)
    inputs = {"targetPrims": ["/World/Gone"]}
    with pytest.raises(ComputeError, match="there is no prim /World/Gone"):
        run_node("IsaacComputeTransformTree", inputs=inputs, pulses={"execIn": [0]}, app=app)


def test_a_parent_that_is_its_own_target_is_placed_in_itself(arm, stage):
    from pxr import UsdGeom

    UsdGeom.Xform.Define(stage, "/World/Base").AddTranslateOp().Set((0, 1, 3))
    UsdGeom.Xform.Define(stage, "/World/Base/Top").AddTranslateOp().Set((0, 0, 2))
    inputs = {"parentPrim": "/World/Base", "targetPrims": ["/World/Base", "/World/Base/Top"]}
    trace = run_node("IsaacComputeTransformTree", inputs=inputs, pulses={"execIn": [0]}, app=arm())
    assert trace.value("parentFrames") == ["Base", "Base"]
    assert trace.value("childFrames") == ["Base", "Top"]
    assert [list(one) for one in trace.value("translations")] == [[0, 0, 0], [0, 0, 2]]


def test_a_camera_that_stands_for_a_lidar_keeps_its_axes(arm, stage):
    from pxr import UsdGeom

    UsdGeom.Camera.Define(stage, "/World/Eye")
    lidar = UsdGeom.Camera.Define(stage, "/World/Lidar").GetPrim()
    lidar.AddAppliedSchema("IsaacRtxLidarSensorAPI")
    inputs = {"targetPrims": ["/World/Eye", "/World/Lidar"]}
    trace = run_node("IsaacComputeTransformTree", inputs=inputs, pulses={"execIn": [0]}, app=arm())
    eye, lidar_turn = ([abs(one) for one in turn] for turn in trace.value("orientations"))
    assert eye == pytest.approx([1, 0, 0, 0])  # half a turn about x: optical axes
    assert lidar_turn == pytest.approx([0, 0, 0, 1])
