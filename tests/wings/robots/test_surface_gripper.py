"""A suction cup above a 2 kg box: what it holds, how hard, how long it tries."""

import pytest

from graph import ComputeError
from graph.testing import run_node

CUP = "/World/Arm/Cup"


@pytest.fixture
def cup(stage, world):
    """A function that opens a world: an arm driven up and down at 1 m, a cup under it, a box below on a stand."""
    from pxr import Gf, Sdf, UsdGeom, UsdPhysics

    def open_world(gap=0.005, lift=0.0, **attributes):
        def solid(path, size, position, mass=None):
            cube = UsdGeom.Cube.Define(stage, path)
            cube.GetSizeAttr().Set(1)
            cube.AddTranslateOp().Set(position)
            cube.AddScaleOp().Set(size)
            UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
            if mass:
                UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
                UsdPhysics.MassAPI.Apply(cube.GetPrim()).GetMassAttr().Set(mass)

        solid("/World/Arm", (0.2, 0.2, 0.1), (0, 0, 1), 5.0)
        solid("/World/Box", (0.4, 0.4, 0.2), (0, 0, 0.95 - gap - 0.1), 2.0)
        solid("/World/Stand", (0.2, 0.2, 0.1), (0, 0, 0.95 - gap - 0.25))
        slide = UsdPhysics.PrismaticJoint.Define(stage, "/World/Slide")
        slide.GetAxisAttr().Set("Z")
        slide.GetBody1Rel().SetTargets(["/World/Arm"])
        slide.GetLocalPos0Attr().Set((0, 0, 1))
        drive = UsdPhysics.DriveAPI.Apply(slide.GetPrim(), "linear")
        drive.GetStiffnessAttr().Set(1e5)
        drive.GetDampingAttr().Set(1e4)
        drive.GetTargetPositionAttr().Set(lift)
        point = UsdPhysics.Joint.Define(stage, "/World/Arm/Point")
        point.GetBody0Rel().SetTargets(["/World/Arm"])
        point.GetLocalPos0Attr().Set((0, 0, -0.5))  # in the scaled cube's own units
        point.GetPrim().CreateAttribute("isaac:forwardAxis", Sdf.ValueTypeNames.Token).Set("Z")
        point.GetLocalRot0Attr().Set(Gf.Quatf(0, 1, 0, 0))  # its z looks down
        gripper = stage.DefinePrim(CUP, "IsaacSurfaceGripper")
        gripper.CreateRelationship("isaac:attachmentPoints").SetTargets(["/World/Arm/Point"])
        for name, value in attributes.items():
            gripper.CreateAttribute(f"isaac:{name}", Sdf.ValueTypeNames.Float).Set(value)
        return world(physics_hz=240, loop_hz=60)

    return open_world


def grip(app, updates, **pulses):
    inputs = {"SurfaceGripper": [CUP]}
    return run_node("SurfaceGripper", inputs=inputs, pulses=pulses, updates=updates, app=app)


def height(app, path="/World/Box"):
    return app.fabric.world_matrix(path)[2, 3]


def raise_arm(app, to=0.5, updates=60):
    app.physics.articulation("/World/Arm").set_targets(positions=[to])
    app.update(updates)


def test_a_closed_cup_lifts_the_box_and_lets_it_go(cup):
    app = cup()
    grip(app, 2, Close=[0])
    gripper = app.physics.gripper(CUP)
    assert (gripper.status, gripper.held) == ("Closed", ("/World/Box",))
    apart = height(app, "/World/Arm") - height(app)
    raise_arm(app)
    assert height(app, "/World/Arm") == pytest.approx(1.5, abs=0.01)
    assert height(app, "/World/Arm") - height(app) == pytest.approx(apart, abs=2e-3)
    grip(app, 30, Open=[0])
    assert (gripper.status, gripper.held) == ("Open", ())
    assert height(app) < 1.0


def test_an_open_cup_holds_nothing(cup):
    app = cup()
    app.play()
    raise_arm(app)
    assert height(app) == pytest.approx(0.845, abs=5e-3)


def test_toggling_closes_and_opens(cup):
    app = cup()
    states = []
    app.on("end", lambda: states.append(app.physics.gripper(CUP).status))
    grip(app, 3, Toggle=[0, 1, 2])
    assert states == ["Closed", "Open", "Closed"]


def test_a_box_beyond_its_reach_is_not_held(cup):
    app = cup(gap=0.02)
    grip(app, 2, Close=[0])
    assert app.physics.gripper(CUP).status == "Open"


def test_its_reach_can_be_set(cup):
    app = cup(gap=0.02, maxGripDistance=0.03)
    grip(app, 2, Close=[0])
    assert app.physics.gripper(CUP).status == "Closed"


def test_it_tries_for_its_retry_interval(cup):
    app = cup(gap=0.3, retryInterval=0.5)
    states = []
    app.on("end", lambda: states.append(app.physics.gripper(CUP).status))
    grip(app, 40, Close=[0])
    assert states.index("Open") == pytest.approx(30, abs=1)
    assert set(states[:29]) == {"Closing"}


@pytest.mark.parametrize(("limit", "held"), [(15.0, False), (25.0, True)])
def test_it_lets_go_of_more_than_its_limit(cup, limit, held):
    app = cup(coaxialForceLimit=limit)
    grip(app, 2, Close=[0])
    for step in range(60):
        raise_arm(app, 0.02 * (step + 1) / 60, 1)  # 19.62 N hang on it, and little more while it rises so slowly
    assert (app.physics.gripper(CUP).status == "Closed") is held


def test_its_joint_ties_nothing_and_warns_of_nothing(cup):
    app = cup()
    app.play()
    assert not list(app.warnings)
    assert [joint.path for joint in app.physics.joints] == ["/World/Slide"]


def test_a_disabled_node_does_nothing(cup):
    app = cup()
    inputs = {"SurfaceGripper": [CUP], "enabled": False}
    run_node("SurfaceGripper", inputs=inputs, pulses={"Close": [0]}, app=app)
    assert app.physics.gripper(CUP).status == "Open"


def test_what_is_not_a_gripper_is_reported(cup):
    with pytest.raises(ComputeError, match="/World/Box: no surface gripper is there"):
        run_node("SurfaceGripper", inputs={"SurfaceGripper": ["/World/Box"]}, pulses={"Close": [0]}, app=cup())
