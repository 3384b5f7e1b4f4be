"""What joints and bodies have by themselves: friction, damping, top speeds, initial states."""

import math

import numpy as np
import pytest

from tests.support.physics_worlds import METRES, physics_of, stage_of, steps

SCENE = 'def PhysicsScene "S" { float physics:gravityMagnitude = 0\n}\n'


def body(name="A", *lines, apis=()):
    applied = "".join(f', "{api}"' for api in apis)
    return f"""
def Xform "{name}" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"{applied}])
{{
    float physics:mass = 2
    float3 physics:diagonalInertia = (0.5, 0.5, 0.5)
    {chr(10).join(lines)}
}}
"""


def joint(kind, *lines, apis=()):
    applied = "".join(f', "{api}"' for api in apis)
    return f"""
def Physics{kind}Joint "J" (prepend apiSchemas = ["PhysxJointAPI"{applied}])
{{
    rel physics:body1 = </A>
    uniform token physics:axis = "Z"
    {chr(10).join(lines)}
}}
"""


MOTOR = ("float drive:{0}:physics:damping = 1e6", "float drive:{0}:physics:targetVelocity = 1e6")


def motor(kind, effort):
    """A drive that gives a constant effort: it aims at a speed that is never reached."""
    return *(line.format(kind) for line in MOTOR), f"float drive:{kind}:physics:maxForce = {effort}"


@pytest.mark.parametrize(
    "line",
    [
        "float newton:friction = 3",
        "float physxJointAxis:linear:dynamicFrictionEffort = 3",
        "double mjc:frictionloss = 3",
    ],
)
def test_dry_friction_takes_its_effort_from_what_moves(usda, line):
    """7 N of drive, 3 N of friction, 2 kg: 2 m/s2, so 2 m/s after 1 s."""
    lines = joint("Prismatic", line, *motor("linear", 7), apis=["PhysicsDriveAPI:linear"])
    physics, warnings = usda(SCENE + body() + lines)
    steps(physics, 240)
    assert physics.data.qvel[0] == pytest.approx(2.0, rel=5e-3)
    assert warnings == []


def test_the_friction_coefficient_of_physx_is_taken_as_an_effort_and_that_is_reported(usda):
    """7 N m of drive, 3 N m of friction, 0.5 kg m2: 8 rad/s2."""
    lines = joint(
        "Revolute", "float physxJoint:jointFriction = 3", *motor("angular", 7), apis=["PhysicsDriveAPI:angular"]
    )
    physics, warnings = usda(SCENE + body() + lines)
    steps(physics, 240)
    assert physics.data.qvel[0] == pytest.approx(8.0, rel=5e-3)
    assert [(code, where) for code, where, _ in warnings] == [("joint-friction-effort", "/J.physxJoint:jointFriction")]


@pytest.mark.parametrize("name", ["newton:damping", "physxJointAxis:angular:viscousFrictionCoefficient"])
def test_viscous_friction_slows_a_joint_exponentially(usda, name):
    """0.1 N m s per degree is 5.7296 N m s/rad, over 0.5 kg m2 11.459/s: 1 / (1 + 11.459 / 240) in an implicit step."""
    spin = "vector3f physics:angularVelocity = (0, 0, 90)"
    physics, _ = usda(SCENE + body("A", spin) + joint("Revolute", f"float {name} = 0.1"))
    steps(physics, 24)
    rate = math.degrees(0.1) / 0.5
    assert physics.data.qvel[0] == pytest.approx(math.pi / 2 / (1 + rate / 240) ** 24, rel=1e-6)


@pytest.mark.parametrize(
    "line",
    [
        "float physxJoint:maxJointVelocity = 90",
        "float physxJointAxis:angular:maxJointVelocity = 90",
        "float newton:velocityLimit = 90",
    ],
)
def test_a_joint_never_turns_faster_than_its_top_speed(usda, line):
    """7 N m and 0.5 kg m2 reach 90 deg/s in 0.11 s."""
    lines = joint("Revolute", line, *motor("angular", 7), apis=["PhysicsDriveAPI:angular"])
    physics, warnings = usda(SCENE + body() + lines)
    for _ in range(240):
        physics.step()
        assert physics.data.qvel[0] <= math.pi / 2 + 1e-12
    assert physics.data.qvel[0] == pytest.approx(math.pi / 2)
    assert warnings == []


def test_a_free_body_never_goes_nor_turns_faster_than_its_top_speeds(usda):
    """Its centre of mass, 0.5 m off its origin: (6, 8, 0) m/s is cut to 5 m/s, 360 to 90 deg/s."""
    physics, warnings = usda(
        SCENE
        + body(
            "A",
            "vector3f physics:velocity = (6, 8, 0)",
            "vector3f physics:angularVelocity = (0, 360, 0)",
            "point3f physics:centerOfMass = (0.5, 0, 0)",
            "float physxRigidBody:maxLinearVelocity = 5",
            "float physxRigidBody:maxAngularVelocity = 90",
            apis=["PhysxRigidBodyAPI"],
        )
    )
    steps(physics, 1)
    before = physics.centers_of_mass[0].copy()
    steps(physics, 240)
    assert physics.centers_of_mass[0] - before == pytest.approx([3, 4, 0], abs=5e-3)
    assert physics.velocities()[0, 3:] == pytest.approx([0, math.pi / 2, 0], abs=1e-6)
    assert warnings == []


def test_damping_and_top_speeds_of_a_body_that_a_joint_holds_are_reported(usda):
    lines = ("float physxRigidBody:linearDamping = 0.5", "float physxRigidBody:maxLinearVelocity = 5")
    _, warnings = usda(body("A", *lines, apis=["PhysxRigidBodyAPI"]) + joint("Revolute"))
    assert [(code, where) for code, where, _ in warnings] == [
        ("physics-setting-stored", "/A.physxRigidBody:linearDamping"),
        ("physics-setting-stored", "/A.physxRigidBody:maxLinearVelocity"),
    ]


def test_a_joint_starts_where_its_state_says_and_as_fast(usda):
    """90 degrees about Z from where the scene has the body, at 30 deg/s: after 1 s 120 degrees."""
    lines = ("float state:angular:physics:position = 90", "float state:angular:physics:velocity = 30")
    physics, warnings = usda(SCENE + body() + joint("Revolute", *lines, apis=["PhysicsJointStateAPI:angular"]))
    half = math.radians(45)
    assert physics.quaternions[0] == pytest.approx([math.cos(half), 0, 0, math.sin(half)])
    steps(physics, 240)
    assert physics.data.qpos[0] == pytest.approx(math.radians(120), rel=1e-9)
    assert warnings == []


def test_the_state_of_a_sliding_joint_counts_in_units_of_the_stage():
    """25 cm up, at 10 cm/s."""
    lines = ("float state:linear:physics:position = 25", "float state:linear:physics:velocity = 10")
    text = SCENE + body() + joint("Prismatic", *lines, apis=["PhysicsJointStateAPI:linear"])
    physics, _ = physics_of(stage_of(text, head=METRES.replace("metersPerUnit = 1", "metersPerUnit = 0.01")))
    assert physics.positions[0] == pytest.approx([0, 0, 0.25])
    steps(physics, 240)
    assert physics.positions[0] == pytest.approx([0, 0, 0.35], rel=1e-6)


def test_an_axis_of_a_d6_has_a_state_of_its_own(usda):
    locks = ["transX", "transY", "rotX", "rotY", "rotZ"]
    low = [f"float limit:{axis}:physics:low = 1\nfloat limit:{axis}:physics:high = -1" for axis in locks]
    state = "float state:transZ:physics:position = 0.5"
    apis = [f"PhysicsLimitAPI:{axis}" for axis in locks]
    text = joint("", *low, state, apis=apis).replace('uniform token physics:axis = "Z"', "")
    physics, warnings = usda(SCENE + body() + text)
    assert physics.positions[0] == pytest.approx([0, 0, 0.5])
    assert warnings == []


@pytest.mark.parametrize("name", ["newton:friction", "newton:damping", "physxJoint:maxJointVelocity"])
def test_an_invalid_number_of_a_joint_is_reported(usda, name):
    physics, warnings = usda(SCENE + body() + joint("Revolute", f"float {name} = nan"))
    assert [(code, where) for code, where, _ in warnings] == [("bad-joint", f"/J.{name}")]
    assert np.isfinite(physics.model.dof_damping).all()
