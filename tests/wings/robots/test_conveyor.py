"""What lies on a belt is carried along by friction, as fast as friction allows."""

import math

import pytest

from graph import ComputeError
from graph.testing import run_node

BELT = "/World/Belt"


@pytest.fixture
def belt(stage, world):
    """A function that opens a world with a kinematic belt (top at z = 0), turned about z, and a box that lies on it."""
    from pxr import UsdGeom, UsdPhysics, UsdShade

    def open_world(turn=0.0, friction=0.5, place=(0, 0), unit=1.0, integrator=None, tilt=0.0, kinematic=True):
        UsdGeom.SetStageMetersPerUnit(stage, unit)
        material = UsdShade.Material.Define(stage, "/World/Rubber")
        surface = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        surface.GetDynamicFrictionAttr().Set(friction)

        def solid(path, size, position):
            cube = UsdGeom.Cube.Define(stage, path)
            cube.GetSizeAttr().Set(1)
            cube.AddTranslateOp().Set(tuple(part / unit for part in position))
            if path == BELT:
                cube.AddRotateZOp().Set(turn)
                cube.AddRotateYOp().Set(tilt)
            cube.AddScaleOp().Set(tuple(part / unit for part in size))
            body = UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
            UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
            UsdShade.MaterialBindingAPI.Apply(cube.GetPrim()).Bind(material, materialPurpose="physics")
            return body

        solid(BELT, (20, 20, 0.2), (0, 0, -0.1)).GetKinematicEnabledAttr().Set(kinematic)
        box = solid("/World/Box", (0.5, 0.5, 0.1), (*place, 0.05))
        UsdPhysics.MassAPI.Apply(box.GetPrim()).GetMassAttr().Set(2.0)
        fidelity = {} if integrator is None else {"physics.integrator": integrator}
        return world(physics_hz=240, loop_hz=60, fidelity=fidelity)

    return open_world


def carry(app, updates, **inputs):
    """Position of the box after each update, from a run of the belt."""
    seen = []
    app.on("end", lambda: seen.append(app.fabric.world_matrix("/World/Box")[:3, 3].copy()))
    given = {"conveyorPrim": [BELT], "velocity": 1.0, **inputs}
    run_node("IsaacConveyor", inputs=given, pulses={"onStep": range(updates)}, updates=updates, app=app)
    return seen


def speed(seen, axis=0):
    return (seen[-1][axis] - seen[-2][axis]) * 60


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete", "euler", "rk4"])
def test_a_box_is_taken_to_the_speed_of_the_belt_and_stays_there(belt, integrator):
    app = belt(integrator=integrator)
    seen = carry(app, 60)
    assert speed(seen) == pytest.approx(1.0, abs=1e-3)
    assert seen[-1][1] == pytest.approx(0, abs=1e-3)
    assert app.fabric.world_matrix(BELT)[:3, 3] == pytest.approx([0, 0, -0.1])


def test_friction_is_what_takes_it_there(belt):
    # With friction 0.1 it gains 0.981 m/s each second: after half a second half of that, over 0.1226 m.
    seen = carry(belt(friction=0.1), 33)
    assert speed(seen) == pytest.approx(0.981 * 32 / 60, rel=0.03)


def test_the_direction_is_along_the_belts_own_axes(belt):
    seen = carry(belt(turn=90.0), 60)
    assert speed(seen, 1) == pytest.approx(1.0, abs=1e-3)
    assert speed(seen, 0) == pytest.approx(0.0, abs=1e-3)


def test_a_belt_may_run_backwards_sideways_and_stop(belt):
    app = belt()
    assert speed(carry(app, 60, velocity=-0.5, direction=[0, 1, 0]), 1) == pytest.approx(-0.5, abs=1e-3)
    assert speed(carry(app, 60, velocity=0.0), 1) == pytest.approx(0.0, abs=1e-3)


def test_speeds_are_in_units_of_the_stage(belt):
    seen = carry(belt(unit=0.01), 60, velocity=100.0)
    assert speed(seen) == pytest.approx(100.0, abs=0.1)


def test_on_a_curved_belt_the_box_goes_round_its_origin(belt):
    # 90 degrees a second on a circle of 2 m. Friction 0.9 can hold (pi / 2)^2 * 2 = 4.9 m/s2.
    seen = carry(belt(place=(2, 0), friction=0.9), 120, velocity=90.0, direction=[0, 0, 1], curved=True)
    assert math.hypot(seen[-1][0], seen[-1][1]) == pytest.approx(2.0, abs=0.2)
    moved = math.hypot(seen[-1][0] - seen[-2][0], seen[-1][1] - seen[-2][1]) * 60
    assert moved == pytest.approx(math.pi / 2 * math.hypot(seen[-1][0], seen[-1][1]), rel=0.02)


def test_the_box_pushes_a_free_belt_the_other_way(belt, stage):
    from pxr import UsdGeom, UsdPhysics

    app = belt(kinematic=False, friction=0.5)
    UsdPhysics.Scene.Define(stage, "/World/Physics")
    base = UsdPhysics.PrismaticJoint.Define(stage, "/World/Rail")
    base.GetAxisAttr().Set("X")
    base.GetBody1Rel().SetTargets([BELT])
    base.GetLocalPos0Attr().Set((0, 0, -0.1))
    UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath(BELT)).GetMassAttr().Set(4.0)
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    seen = carry(app, 60)
    # 2 v + 4 u = 0 and v - u = 1: the box goes with 2 / 3 m/s, the belt with -1 / 3.
    assert speed(seen) == pytest.approx(2 / 3, rel=0.02)


def test_a_disabled_node_leaves_the_belt_as_it_is(belt):
    app = belt()
    assert speed(carry(app, 60, enabled=False)) == pytest.approx(0, abs=1e-6)
    carry(app, 60)
    assert speed(carry(app, 30, velocity=3.0, enabled=False)) == pytest.approx(1.0, abs=1e-3)


def test_a_second_play_starts_with_a_still_belt(belt):
    app = belt()
    carry(app, 10)
    app.stop()
    assert speed(carry(app, 30, enabled=False)) == pytest.approx(0, abs=1e-6)


def test_the_discrete_integrator_gives_way_and_that_is_reported(belt):
    inputs = {"conveyorPrim": [BELT], "velocity": 1.0}
    app = belt(integrator="discrete")
    trace = run_node("IsaacConveyor", inputs=inputs, pulses={"onStep": range(3)}, updates=3, app=app)
    assert [(one.code, one.count) for one in trace.warnings] == [("belt-integrator", 1)]


def test_a_texture_that_is_to_move_is_warned_of_once(belt):
    inputs = {"conveyorPrim": [BELT], "animateTexture": True}
    trace = run_node("IsaacConveyor", inputs=inputs, pulses={"onStep": range(3)}, updates=3, app=belt())
    assert [(one.code, one.count) for one in trace.warnings] == [("texture-not-animated", 1)]


@pytest.mark.parametrize(
    ("prims", "message"),
    [([], "conveyorPrim names 0 prims"), (["/World"], "/World is not a rigid body; give it a RigidBodyAPI")],
)
def test_what_is_not_a_belt_is_reported(belt, prims, message):
    with pytest.raises(ComputeError, match=message):
        carry(belt(), 1, conveyorPrim=prims)


@pytest.mark.parametrize("curved", [False, True])
def test_the_prim_of_a_belt_says_its_motion_until_the_stop(belt, stage, curved):
    app = belt()
    seen = carry(app, 30, direction=[0.0, 0.5, 0.0], velocity=2.0, curved=curved)
    names = ("surfaceAngularVelocity", "surfaceVelocity") if curved else ("surfaceVelocity", "surfaceAngularVelocity")
    read = [stage.GetPrimAtPath(BELT).GetAttribute(f"physxSurfaceVelocity:{name}") for name in names]
    assert [tuple(one.Get()) for one in read] == [(0, 1, 0), (0, 0, 0)]
    if not curved:
        assert speed(seen, 1) == pytest.approx(1.0, abs=0.01)
    app.stop()
    assert not any(one and one.Get() for one in read)
