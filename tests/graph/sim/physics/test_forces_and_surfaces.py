"""PhysX's schemas that act on rigid bodies: forces, moving surfaces, locked axes, triggers."""

import math

import numpy as np
import pytest

from graph.sim import App
from tests.support.physics_worlds import METRES, fallen, physics_of, stage_of, steps

FREE = 'def PhysicsScene "S" { float physics:gravityMagnitude = 0\n}\n'
GROUND = 'def Plane "Ground" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { uniform token axis = "Z"\n}\n'


def body(*lines, name="A", at=(0, 0, 0), turn=(1, 0, 0, 0), apis=(), kind="Xform"):
    applied = "".join(f', "{api}"' for api in apis)
    return f"""
def {kind} "{name}" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"{applied}])
{{
    float physics:mass = 2
    float3 physics:diagonalInertia = (0.5, 0.6, 0.7)
    double3 xformOp:translate = {at}
    quatf xformOp:orient = {turn}
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]
    {chr(10).join(lines)}
}}
"""


def box(*lines, **options):
    apis = ("PhysicsCollisionAPI", *options.pop("apis", ()))
    return body("double size = 1", *lines, kind="Cube", apis=apis, **options)


QUARTER_ABOUT_Z = (math.sqrt(0.5), 0, 0, math.sqrt(0.5))
WORLD = "bool physxForce:worldFrameEnabled = 1"
AS_FORCE = 'uniform token physxForce:mode = "force"'


def forced(*lines, **options):
    return body(*lines, apis=["PhysxForceAPI"], **options)


def test_a_force_of_the_stage_moves_a_body_as_newton_says(usda):
    """6 N on 2 kg: 3 m/s2, semi-implicitly 3 dt2 n (n + 1) / 2 = 1.50625 m after 1 s at 240 Hz."""
    physics, warnings = usda(FREE + forced("vector3f physxForce:force = (6, 0, 0)", AS_FORCE, WORLD))
    steps(physics, 240)
    assert physics.positions[0] == pytest.approx([fallen(240, 1 / 240, 3), 0, 0], abs=1e-9)
    assert warnings == []


def test_the_default_mode_is_acceleration_in_the_bodys_own_frame(usda):
    """3 m/s2 along its X, which a quarter turn about Z has made the world's Y."""
    physics, _ = usda(FREE + forced("vector3f physxForce:force = (3, 0, 0)", turn=QUARTER_ABOUT_Z))
    steps(physics, 240)
    assert physics.positions[0] == pytest.approx([0, fallen(240, 1 / 240, 3), 0], abs=1e-6)


def test_a_local_force_turns_with_its_body(usda):
    """At 1 rad/s about Z, 3 m/s2 along its own X: v = 3 (sin t, 1 - cos t); a step's force is that of its beginning."""
    spin = f"vector3f physics:angularVelocity = (0, 0, {math.degrees(1)})"
    physics, _ = usda(FREE + forced("vector3f physxForce:force = (3, 0, 0)", spin), hz=1000)
    steps(physics, 1000)
    wanted = [3 * math.sin(1), 3 * (1 - math.cos(1)), 0]
    assert physics.velocities()[0, :3] == pytest.approx(wanted, abs=3e-3)


@pytest.mark.parametrize(
    ("lines", "rate"),
    [
        (("vector3f physxForce:torque = (0, 0, 1.4)", AS_FORCE), 2.0),  # 1.4 N m / 0.7 kg m2
        (("vector3f physxForce:torque = (0, 0, 90)",), math.pi / 2),  # 90 deg/s2, whatever the inertia
        (("vector3f physxForce:torque = (0, 0, 90)", WORLD), math.pi / 2),
    ],
)
def test_a_torque_of_the_stage_turns_a_body(usda, lines, rate):
    physics, _ = usda(FREE + forced(*lines))
    steps(physics, 240)
    assert physics.velocities()[0, 3:] == pytest.approx([0, 0, rate], rel=1e-6, abs=1e-9)


def test_forces_count_in_units_of_the_stage():
    """600 kg cm/s2 on 2 kg are 3 m/s2."""
    text = FREE + forced("vector3f physxForce:force = (600, 0, 0)", AS_FORCE, WORLD)
    physics, _ = physics_of(stage_of(text, METRES.replace("metersPerUnit = 1", "metersPerUnit = 0.01")))
    steps(physics, 240)
    assert physics.positions[0, 0] == pytest.approx(fallen(240, 1 / 240, 3), rel=1e-9)


def test_a_force_that_is_off_or_no_number_does_nothing(usda):
    off = "bool physxForce:forceEnabled = 0"
    physics, warnings = usda(FREE + forced("vector3f physxForce:force = (6, 0, 0)", off))
    steps(physics, 24)
    assert physics.positions[0] == pytest.approx(0)
    physics, warnings = usda(FREE + forced("vector3f physxForce:force = (nan, 0, 0)"))
    assert [(code, where) for code, where, _ in warnings] == [("bad-force", "/A.physxForce:force")]


def test_a_force_written_while_playing_acts_from_the_next_update_on_besides_the_users():
    """Weight 2 g is held by the stage's 2 g; the user's 4 N then give 2 m/s2."""
    with App(stage_of(forced("vector3f physxForce:force = (0, 0, 0)", AS_FORCE, WORLD))) as app:
        app.play()
        app.stage.GetPrimAtPath("/A").GetAttribute("physxForce:force").Set((0, 0, 2 * 9.81))
        app.update(steps=60)
        assert app.simulation.tensors.positions[0] == pytest.approx(0, abs=1e-6)
        app.simulation.tensors.set_forces(forces=[4, 0, 0])
        app.update(steps=60)
        assert app.simulation.tensors.linear_velocities[0] == pytest.approx([2, 0, 0], abs=1e-6)
        assert app.warnings.codes() == []


# -- surfaces ----------------------------------------------------------------------------------------------------------

BELT = {"name": "Belt", "at": (0, 0, -0.5)}
KINEMATIC = "bool physics:kinematicEnabled = 1"


def on_a_belt(*lines, apis=("PhysxSurfaceVelocityAPI",), turn=(1, 0, 0, 0)):
    return box(*lines, KINEMATIC, apis=apis, turn=turn, **BELT) + box(at=(0, 0, 0.5))


SPEED = "vector3f physxSurfaceVelocity:surfaceVelocity = (0.3, 0, 0)"


@pytest.mark.parametrize(
    ("lines", "velocity"),
    [
        ((SPEED,), (0, 0.3)),
        ((SPEED, "bool physxSurfaceVelocity:surfaceVelocityLocalSpace = 0"), (0.3, 0)),
        ((SPEED, "bool physxSurfaceVelocity:surfaceVelocityEnabled = 0"), (0, 0)),
    ],
)
def test_what_lies_on_a_moving_surface_gets_its_velocity(usda, lines, velocity):
    """Friction 0.5: 0.3 m/s are reached in 0.3 / (0.5 g) = 0.06 s. The belt's own X is the world's Y."""
    physics, warnings = usda(on_a_belt(*lines, turn=QUARTER_ABOUT_Z))
    steps(physics, 120)
    row = physics.body_paths.index("/A")
    assert physics.velocities()[row, :2] == pytest.approx(velocity, abs=2e-3)
    assert physics.positions[physics.body_paths.index("/Belt")] == pytest.approx([0, 0, -0.5])
    assert warnings == []


def test_a_turning_surface_carries_what_lies_off_its_middle_round(usda):
    """Its speed is 90 deg/s times its distance r from the axis."""
    turning = "vector3f physxSurfaceVelocity:surfaceAngularVelocity = (0, 0, 90)"
    belt = box(turning, KINEMATIC, apis=["PhysxSurfaceVelocityAPI"], **BELT)
    lines = "double size = 0.1\n double3 xformOp:translate = (0.2, 0, 0.05)"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    apis = '"PhysicsRigidBodyAPI", "PhysicsCollisionAPI"'
    small = f'def Cube "A" (prepend apiSchemas = [{apis}]) {{ {lines}\n {order}\n}}\n'
    physics, _ = usda(belt + small)
    steps(physics, 60)
    row = physics.body_paths.index("/A")
    distance = np.linalg.norm(physics.positions[row, :2])
    assert np.linalg.norm(physics.velocities()[row, :2]) == pytest.approx(distance * math.pi / 2, rel=0.05)


def test_a_kinematic_body_with_a_velocity_is_a_belt_as_in_physx(usda):
    physics, warnings = usda(on_a_belt("vector3f physics:velocity = (0.3, 0, 0)", apis=()))
    steps(physics, 120)
    assert physics.velocities()[physics.body_paths.index("/A"), 0] == pytest.approx(0.3, abs=2e-3)
    assert physics.positions[physics.body_paths.index("/Belt")] == pytest.approx([0, 0, -0.5])
    assert warnings == []


def test_a_surface_without_colliders_is_reported(usda):
    _, warnings = usda(body(SPEED, apis=["PhysxSurfaceVelocityAPI"]))
    assert [code for code, *_ in warnings] == ["bad-surface-velocity"]


def test_a_surface_velocity_written_while_playing_counts_from_the_next_update_on():
    with App(stage_of(on_a_belt(SPEED))) as app:
        app.play()
        app.update(steps=30)
        app.stage.GetPrimAtPath("/Belt").GetAttribute("physxSurfaceVelocity:surfaceVelocity").Set((0, 0.2, 0))
        app.update(steps=60)
        row = app.simulation.tensors.body_paths.index("/A")
        assert app.simulation.tensors.linear_velocities[row, :2] == pytest.approx([0, 0.2], abs=2e-3)
        assert app.warnings.codes() == []


# -- locked axes -------------------------------------------------------------------------------------------------------


def locked(places=0, turns=0, *lines, **options):
    locks = (f"int physxRigidBody:lockedPosAxis = {places}", f"int physxRigidBody:lockedRotAxis = {turns}")
    return body(*locks, *lines, apis=["PhysxRigidBodyAPI"], **options)


@pytest.mark.parametrize(("mask", "free"), [(1, (0, 1, 1)), (4, (1, 1, 0)), (3, (0, 0, 1)), (7, (0, 0, 0))])
def test_a_body_keeps_its_place_on_locked_axes(usda, mask, free):
    """Thrown at (1, 2, 3) m/s without gravity; the turn about X is 90 degrees in 1 s."""
    motion = ("vector3f physics:velocity = (1, 2, 3)", "vector3f physics:angularVelocity = (90, 0, 0)")
    physics, _ = usda(FREE + locked(mask, 0, *motion, at=(5, 6, 7)))
    steps(physics, 240)
    assert physics.positions[0] - [5, 6, 7] == pytest.approx(np.multiply(free, [1, 2, 3]), abs=1e-6)
    assert physics.rotations[0] @ [0, 1, 0] == pytest.approx([0, 0, 1], abs=1e-4)


def test_a_body_that_must_not_turn_slides_upright(usda):
    """It falls as any body does, and its spin is reported as impossible."""
    spin = "vector3f physics:angularVelocity = (90, 0, 0)"
    physics, warnings = usda(locked(0, 7, spin, turn=QUARTER_ABOUT_Z))
    start = physics.rotations[0].copy()
    steps(physics, 240)
    assert physics.positions[0] == pytest.approx([0, 0, -fallen(240, 1 / 240)], abs=1e-6)
    assert physics.rotations[0] == pytest.approx(start, abs=1e-12)
    assert [code for code, *_ in warnings] == ["velocity-not-possible"]


def test_a_body_that_may_turn_about_one_axis_turns_about_that_of_the_world(usda):
    """Its own axes lie otherwise: it is tipped by a quarter turn about X. 90 deg/s about the world's Z for 1 s."""
    tipped = (math.sqrt(0.5), math.sqrt(0.5), 0, 0)
    physics, warnings = usda(FREE + locked(0, 3, "vector3f physics:angularVelocity = (0, 0, 90)", turn=tipped))
    start = physics.rotations[0].copy()
    steps(physics, 240)
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    assert physics.rotations[0] == pytest.approx(quarter @ start, abs=1e-6)
    assert warnings == []


def test_locks_that_cannot_be_had_are_reported(usda):
    joint = 'def PhysicsRevoluteJoint "J" { rel physics:body1 = </A>\n}\n'
    for text in (locked(1) + joint, locked(1, 0, KINEMATIC) + body(name="B"), locked(0, 2)):
        _, warnings = usda(text)
        assert [code for code, *_ in warnings if code != "body-without-volume"] == ["physics-setting-stored"]


def test_a_locked_body_keeps_its_state_when_the_world_is_compiled_again():
    lines = ("vector3f physics:velocity = (1, 0, 0)", "vector3f physics:angularVelocity = (0, 0, 90)")
    with App(stage_of(FREE + locked(4, 3, *lines) + body(name="B", at=(0, 5, 0)))) as app:
        app.play()
        app.update(steps=30)
        before = [app.physics.positions.copy(), app.physics.rotations.copy(), app.physics.velocities()]
        with app.edit(when_playing="recompile") as stage:
            stage.GetPrimAtPath("/A").GetAttribute("physics:mass").Set(3.0)
            stage.RemovePrim("/B")
        after = [app.physics.positions, app.physics.rotations, app.physics.velocities()]
        for old, new in zip(before, after, strict=True):
            assert new[0] == pytest.approx(old[0], abs=1e-9)


# -- triggers ----------------------------------------------------------------------------------------------------------


def trigger(kind="Cube", at=(0, 0, 1), *lines):
    return f"""
def {kind} "Gate" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysxTriggerAPI"])
{{
    double3 xformOp:translate = {at}
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {chr(10).join(lines)}
}}
"""


def test_a_body_falls_through_a_trigger_that_knows_it_meanwhile():
    """From z = 3 a box of 1 m enters a gate from z = 0.5 to 1.5 when it has fallen 1 m, and leaves after 3 m."""
    text = trigger("Cube", (0, 0, 1), "double size = 1") + box(at=(0, 0, 3))
    with App(stage_of(text), physics_hz=240, loop_hz=240) as app:
        app.play()
        seen = {}
        for update in range(1, 241):
            app.update()
            fall = fallen(update, 1 / 240)
            assert app.simulation.tensors.positions[0] == pytest.approx([0, 0, 3 - fall], abs=1e-6)
            seen[update] = app.simulation.tensors.triggered
            if abs(fall - 1) > 0.01 and abs(fall - 3) > 0.01:
                assert seen[update] == {"/Gate": ("/A",) if 1 < fall < 3 else ()}
        assert app.warnings.codes() == []


def test_a_trigger_on_a_body_weighs_nothing_and_goes_with_it(usda):
    """The mass of a box of 1 m at 1000 kg/m3, its trigger twice as large around it."""
    text = """
def Xform "A" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
{
    def Cube "Solid" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double size = 1
    }
    def Cube "Zone" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysxTriggerAPI"]) { double size = 2
    }
}
"""
    physics, warnings = usda(FREE + text + box("vector3f physics:velocity = (-1, 0, 0)", name="B", at=(3.5, 0, 0)))
    assert physics.masses[0] == pytest.approx(1000)
    assert physics.triggered() == {"/A/Zone": ()}
    steps(physics, 528)  # 2.2 m: its face is at 0.8 m, those of the zone and the solid are at 1 m and 0.5 m
    assert physics.triggered() == {"/A/Zone": ("/B",)}
    assert warnings == []


def test_rays_of_grippers_and_what_stands_still_pass_a_trigger_by(usda):
    text = trigger("Cube", (0, 0, 1)) + 'def Cube "Wall" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { }\n' + body()
    physics, _ = usda(text.replace("{ }", "{\n}"))
    assert physics.triggered() == {"/Gate": ()}
