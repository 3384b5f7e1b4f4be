"""Contact forces and joint sensors, by hand."""

import pytest

from graph import ComputeError
from graph.testing import run_node


@pytest.fixture
def box(stage, world):
    """A function that opens a world with a 2 kg box resting on the ground, and a contact sensor in its middle."""
    from pxr import Gf, UsdGeom, UsdPhysics

    def open_world(height=0.5, unit=1.0, **attributes):
        UsdGeom.SetStageMetersPerUnit(stage, unit)
        UsdPhysics.CollisionAPI.Apply(UsdGeom.Plane.Define(stage, "/World/Ground").GetPrim())
        cube = UsdGeom.Cube.Define(stage, "/World/Box")
        cube.GetSizeAttr().Set(1 / unit)
        cube.AddTranslateOp().Set((0, 0, height / unit))
        for api in (UsdPhysics.RigidBodyAPI, UsdPhysics.CollisionAPI):
            api.Apply(cube.GetPrim())
        UsdPhysics.MassAPI.Apply(cube.GetPrim()).GetMassAttr().Set(2.0)
        sensor = stage.DefinePrim("/World/Box/Sensor", "IsaacContactSensor")
        for name, value in attributes.items():
            sensor.GetAttribute(name).Set(Gf.Vec2f(*value) if name == "threshold" else value)
        return world(physics_hz=240, loop_hz=60)

    return open_world


def touch(app, updates=60, prims=("/World/Box/Sensor",)):
    inputs = {"csPrim": list(prims)}
    return run_node(
        "IsaacReadContactSensor", inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app
    )


def test_a_resting_box_is_held_with_its_weight(box):
    trace = touch(box())
    assert trace.value("value") == pytest.approx(19.62, rel=1e-3)
    assert trace.value("inContact")
    assert trace.value("sensorTime") == pytest.approx(1.0)
    assert trace.fired("execOut") == list(range(60))


def test_a_falling_box_touches_nothing(box):
    trace = touch(box(height=50), 5)
    assert (trace.value("inContact"), trace.value("value")) == (False, 0)
    assert trace.fired("execOut") == [0, 1, 2, 3, 4]


@pytest.mark.parametrize(
    ("threshold", "found"), [((20, 100), (False, 0)), ((10, 15), (True, 15)), ((0, 100), (True, 19.62))]
)
def test_a_force_below_the_threshold_reads_zero_and_one_above_reads_as_the_most(box, threshold, found):
    trace = touch(box(threshold=threshold))
    assert (trace.value("inContact"), trace.value("value")) == (found[0], pytest.approx(found[1], rel=1e-3))


def test_thresholds_are_in_units_of_the_stage(box):
    # In centimetres 1500 kg cm/s2 are 15 N.
    assert touch(box(unit=0.01, threshold=(1000, 1500))).value("value") == pytest.approx(15)


@pytest.mark.parametrize(("radius", "touched"), [(0.8, False), (0.9, True), (-1.0, True)])
def test_only_contacts_within_the_radius_count(box, radius, touched):
    # The corners of the box are sqrt(3) / 2 = 0.87 m from its middle.
    assert touch(box(radius=radius)).value("inContact") is touched


def test_a_sensor_that_is_off_reads_nothing(box):
    assert touch(box(enabled=False), 3).fired("execOut") == []


@pytest.mark.parametrize(
    ("prims", "message"),
    [(["/World/Ground"], "/World/Ground: it is on no rigid body"), ([], "input csPrim names 0 prims")],
)
def test_a_sensor_without_body_is_reported(box, prims, message):
    with pytest.raises(ComputeError, match=message):
        touch(box(), 1, prims)


@pytest.fixture
def lift(stage, world):
    """A function that opens a centimetre world: /World/Lift, 3 kg on a vertical slide driven to 20 cm, a wheel."""
    from pxr import UsdGeom, UsdPhysics

    def link(name, place, mass):
        prim = UsdGeom.Xform.Define(stage, f"/World/Lift/{name}")
        prim.AddTranslateOp().Set(place)
        UsdPhysics.RigidBodyAPI.Apply(prim.GetPrim())
        api = UsdPhysics.MassAPI.Apply(prim.GetPrim())
        api.GetMassAttr().Set(mass)
        api.GetDiagonalInertiaAttr().Set((100.0, 100.0, 100.0))
        return f"/World/Lift/{name}"

    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdPhysics.ArticulationRootAPI.Apply(UsdGeom.Xform.Define(stage, "/World/Lift").GetPrim())
    platform, wheel = link("platform", (0, 0, 0), 2.0), link("wheel", (0, 0, 0), 1.0)
    slide = UsdPhysics.PrismaticJoint.Define(stage, "/World/Lift/slide")
    slide.GetAxisAttr().Set("Z")
    slide.GetBody1Rel().SetTargets([platform])
    drive = UsdPhysics.DriveAPI.Apply(slide.GetPrim(), "linear")
    drive.GetStiffnessAttr().Set(1e5)
    drive.GetDampingAttr().Set(1e4)
    drive.GetTargetPositionAttr().Set(20.0)
    spin = UsdPhysics.RevoluteJoint.Define(stage, "/World/Lift/spin")
    spin.GetAxisAttr().Set("Z")
    spin.GetBody0Rel().SetTargets([platform])
    spin.GetBody1Rel().SetTargets([wheel])
    return lambda: world(physics_hz=240, loop_hz=60)


def run(app, node, prim, updates=120, **inputs):
    inputs = {"prim": prim, **inputs}
    return run_node(node, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def test_the_effort_of_a_slide_is_the_weight_it_holds(lift):
    trace = run(lift(), "IsaacReadEffortSensor", ["/World/Lift/slide"])
    assert trace.value("value") == pytest.approx(3 * 9.81, rel=1e-3)
    assert trace.value("sensorTime") == pytest.approx(2.0)
    assert trace.fired("execOut") == list(range(120))


def test_a_free_joint_has_no_effort(lift):
    assert run(lift(), "IsaacReadEffortSensor", ["/World/Lift/spin"], 3).value("value") == 0


def test_the_deprecated_input_enabled_of_the_effort_sensor_has_no_effect(lift):
    trace = run(lift(), "IsaacReadEffortSensor", ["/World/Lift/slide"], 3, enabled=False)
    assert trace.fired("execOut") == [0, 1, 2]


@pytest.mark.parametrize(
    ("prims", "message"),
    [
        (["/World/Lift"], "/World/Lift is not a joint; give prim one of /World/Lift/slide, /World/Lift/spin"),
        (["/World"], "/World is not a joint"),
        (["/World/Gone"], "there is no prim /World/Gone"),
    ],
)
def test_what_is_not_a_joint_is_reported(lift, prims, message):
    with pytest.raises(ComputeError, match=message):
        run(lift(), "IsaacReadEffortSensor", prims, 1)


def test_all_joints_of_a_robot_are_read(lift):
    trace = run(lift(), "IsaacReadJointState", ["/World/Lift"])
    assert trace.value("jointNames") == ["slide", "spin"]
    # 29.43 N, which is 2943 kg cm/s2, over a stiffness of 1e5 kg/s2 leave it 0.02943 cm low.
    assert trace.value("jointPositions") == pytest.approx([20 - 0.02943, 0], abs=1e-4)
    assert trace.value("jointVelocities") == pytest.approx([0, 0], abs=1e-3)
    assert trace.value("jointEfforts") == pytest.approx([29.43, 0], rel=1e-3)
    assert trace.value("jointDofTypes").tolist() == [1, 0]
    assert trace.value("stageMetersPerUnit") == pytest.approx(0.01)
    assert trace.fired("execOut") == list(range(120))


def test_a_world_in_which_nothing_moves_has_no_joints(world, stage):
    stage.DefinePrim("/World/Lift")
    with pytest.raises(ComputeError, match="/World/Lift has no joints that move"):
        run(world(), "IsaacReadJointState", ["/World/Lift"], 1)
