"""What a scene begins with, and what it cannot begin with."""

import pytest

from tests.support.physics_worlds import GROUND, steps

BALL = {"type": "Sphere", "radius": 0.5, "rigid_body": True}


def codes(warnings):
    return [(code, where) for code, where, _ in warnings]


def test_bodies_inside_each_other_are_reported_with_their_depth(world):
    """Balls of radius 0.5 m, 0.8 m apart: 2 * 0.5 - 0.8 = 0.2 m."""
    apart = {"/A": {**BALL, "translate": [0, 0, 5]}, "/B": {**BALL, "translate": [0.8, 0, 5]}}
    _, _, warnings = world(apart)
    assert codes(warnings) == [("bodies-overlap", "/A")]
    assert "it and /B overlap by 0.2 m when play begins; they are thrown apart" in warnings[0][2]


def test_only_the_deepest_pair_is_named_and_the_others_are_counted(world):
    """The middle ball is 0.2 m in one neighbour and 0.3 m in the other."""
    prims = {f"/{name}": {**BALL, "translate": [x, 0, 5]} for name, x in (("A", 0), ("B", 0.8), ("C", 1.5))}
    _, _, warnings = world(prims)
    assert codes(warnings) == [("bodies-overlap", "/B")]
    assert "/C overlap by 0.3 m when play begins, and so does 1 other pair" in warnings[0][2]


def test_a_body_that_rests_on_or_slightly_in_the_ground_is_not_reported(world):
    for height in (0.5, 0.495):
        _, _, warnings = world({**GROUND, "/A": {**BALL, "translate": [0, 0, height]}})
        assert warnings == []


PAIR = """
def PhysicsScene "S" {{ float physics:gravityMagnitude = 0
}}
def Xform "A" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{{
    float physics:mass = 1
    float3 physics:diagonalInertia = (1, 1, 1)
    {first}
}}
def Xform "B" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{{
    float physics:mass = 1
    float3 physics:diagonalInertia = (1, 1, 1)
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {second}
}}
def PhysicsFixedJoint "J" {{
    rel physics:body0 = </A>
    rel physics:body1 = </B>
    point3f physics:localPos0 = (1, 0, 0)
}}
"""


def test_a_velocity_that_a_fixed_joint_forbids_is_reported(usda):
    still = "vector3f physics:velocity = (0, 0, 0)"
    physics, warnings = usda(PAIR.format(first=still, second="vector3f physics:velocity = (1, 0, 0)"))
    assert codes(warnings) == [("velocity-not-possible", "/B")]
    assert "it starts with (0, 0, 0) m/s, not (1, 0, 0): its joints allow no other" in warnings[0][2]
    assert physics.velocities() == pytest.approx(0)


def test_velocities_that_fit_a_fixed_joint_are_not_reported(usda):
    """A turns about Z at 1 rad/s and moves at (0, 2, 0): B, 1 m along X, moves at (0, 3, 0)."""
    spin = "vector3f physics:angularVelocity = (0, 0, 57.29577951308232)"
    _, warnings = usda(
        PAIR.format(
            first=f"vector3f physics:velocity = (0, 2, 0)\n    {spin}",
            second=f"vector3f physics:velocity = (0, 3, 0)\n    {spin}",
        )
    )
    assert warnings == []


HINGE = """
def PhysicsScene "S" {{ float physics:gravityMagnitude = 0
}}
def Xform "A" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{{
    float physics:mass = 1
    float3 physics:diagonalInertia = (0.01, 0.01, 0.01)
    vector3f physics:angularVelocity = (0, 0, {speed})
}}
def PhysicsRevoluteJoint "J" {{
    rel physics:body1 = </A>
    uniform token physics:axis = "Z"
    float physics:lowerLimit = -30
    float physics:upperLimit = {upper}
}}
"""


@pytest.mark.parametrize("hz", [60, 240, 1000])
@pytest.mark.parametrize("speed", [30, 300, 1000])
def test_a_joint_passes_its_limit_by_at_most_its_way_in_one_step(usda, hz, speed):
    """What stops it acts from the first step on that ends beyond the limit: at most v dt behind it."""
    physics, _ = usda(HINGE.format(speed=speed, upper=30), hz=hz)
    highest = 0.0
    for _ in range(2 * hz):
        physics.step()
        highest = max(highest, physics.data.qpos[0] * 57.29577951308232)
    assert highest <= 30 + speed / hz + 1e-6
    assert abs(physics.data.qvel[0] * 57.29577951308232) < 0.3 * speed  # it hardly comes back


def test_a_limit_that_is_not_a_number_is_reported_and_counts_as_none(usda):
    physics, warnings = usda(HINGE.format(speed=360, upper="nan"))
    assert codes(warnings) == [("bad-joint", "/J.physics:upperLimit")]
    steps(physics, 240)
    assert physics.data.qpos[0] == pytest.approx(6.283185307179586, rel=1e-4)


DRIVE = """
def Xform "A" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{{
    float physics:mass = 1
    float3 physics:diagonalInertia = (0.01, 0.01, 0.01)
}}
def PhysicsPrismaticJoint "J" (prepend apiSchemas = ["PhysicsDriveAPI:linear"]) {{
    rel physics:body1 = </A>
    uniform token physics:axis = "Z"
    {line}
}}
"""


@pytest.mark.parametrize(
    ("name", "value"),
    [("stiffness", "inf"), ("damping", "inf"), ("stiffness", "3.4e38"), ("damping", "-1"), ("targetPosition", "inf")],
)
def test_a_gain_that_no_engine_can_use_is_reported_and_the_body_falls(usda, name, value):
    """0 is taken, so that after 0.25 s at 240 Hz the body has fallen g dt2 n (n + 1) / 2 = 0.3117 m."""
    physics, warnings = usda(DRIVE.format(line=f"float drive:linear:physics:{name} = {value}"))
    assert codes(warnings) == [("bad-joint", f"/J.drive:linear:physics:{name}")]
    steps(physics, 60)
    assert physics.positions[0, 2] == pytest.approx(-9.81 / 240**2 * 60 * 61 / 2, rel=1e-6)


@pytest.mark.parametrize("force", ["inf", "3.4028235e38"])
def test_a_joint_that_never_breaks_is_not_reported(usda, force):
    _, warnings = usda(DRIVE.format(line=f"float physics:breakForce = {force}\n float physics:breakTorque = {force}"))
    assert warnings == []


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("float physics:gravityMagnitude = nan", "gravityMagnitude"),
        ("float physics:gravityMagnitude = inf", "gravityMagnitude"),
        ("vector3f physics:gravityDirection = (0, nan, 0)", "gravityDirection"),
    ],
)
def test_gravity_that_is_not_a_number_is_reported_and_that_of_the_earth_acts(usda, line, name):
    text = DRIVE.format(line="") + f'def PhysicsScene "S" {{ {line}\n}}\n'
    physics, warnings = usda(text)
    assert codes(warnings) == [("bad-gravity", f"/S.physics:{name}")]
    steps(physics, 60)
    assert physics.positions[0, 2] == pytest.approx(-9.81 / 240**2 * 60 * 61 / 2, rel=1e-4)


@pytest.mark.parametrize("turn", ["(nan, 0, 0, 0)", "(0, 0, 0, 0)"])
def test_a_frame_of_a_joint_that_is_none_is_reported(usda, turn):
    _, warnings = usda(DRIVE.format(line=f"quatf physics:localRot0 = {turn}"))
    assert [code for code, *_ in warnings] == ["bad-joint"]


def test_a_drive_stiffer_than_the_engine_takes_controls_still_holds_its_target(usda):
    """1e11 N/m to 0.5 m are 5e10 N, and MuJoCo drops controls above 1e10. The 1 kg hang 9.81 / 1e11 m lower."""
    lines = ("stiffness = 1e11", "damping = 1e9", "targetPosition = 0.5")
    physics, warnings = usda(DRIVE.format(line="\n".join(f"float drive:linear:physics:{line}" for line in lines)))
    steps(physics, 240)
    assert physics.positions[0, 2] == pytest.approx(0.5, abs=1e-6)
    assert warnings == []
