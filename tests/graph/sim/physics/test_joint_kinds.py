import math

import numpy as np
import pytest

from tests.support.physics_worlds import fallen, steps


def body(name, at=(0, 0, 0), mass=1.0, inertia=(0.01, 0.01, 0.01), more="", turned=None):
    turn = "" if turned is None else f"quatf xformOp:orient = {tuple(turned)}\n"
    order = '["xformOp:translate", "xformOp:orient"]' if turned is not None else '["xformOp:translate"]'
    return f"""
def Xform "{name}" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{{
    float physics:mass = {mass}
    float3 physics:diagonalInertia = {tuple(inertia)}
    double3 xformOp:translate = {tuple(at)}
    {turn}uniform token[] xformOpOrder = {order}
    {more}
}}
"""


def joint(kind, name="J", schemas=(), body0=None, body1="/A", pos0=(0, 0, 0), pos1=(0, 0, 0), more=""):
    ends = "".join(f"rel physics:body{i} = <{path}>\n" for i, path in enumerate((body0, body1)) if path)
    applied = f"(prepend apiSchemas = {list(schemas)})".replace("'", '"') if schemas else ""
    return f"""
def Physics{kind}Joint "{name}" {applied}
{{
    {ends}
    point3f physics:localPos0 = {tuple(pos0)}
    point3f physics:localPos1 = {tuple(pos1)}
    {more}
}}
"""


def values(*lines):
    """Attributes, one each."""
    return "\n".join(lines)


def axis(name):
    return f'uniform token physics:axis = "{name}"'


def cones(first, second):
    angles = (f"float physics:coneAngle{i}Limit = {angle}" for i, angle in enumerate((first, second)))
    return values(axis("X"), *angles)


def drive(kind, **numbers):
    return values(*(f"float drive:{kind}:physics:{name} = {value}" for name, value in numbers.items()))


def locked(*axes):
    """LimitAPI names and attributes that lock axes of a D6."""
    return [f"PhysicsLimitAPI:{a}" for a in axes], "\n".join(
        f"float limit:{a}:physics:low = 1\nfloat limit:{a}:physics:high = -1" for a in axes
    )


ALL = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")


@pytest.mark.parametrize("free", ["transX", "transY", "transZ"])
def test_a_d6_with_one_free_axis_slides_along_it_alone(usda, free):
    schemas, limits = locked(*(a for a in ALL if a != free))
    down = {"transX": (1, 0, 0), "transY": (0, 1, 0), "transZ": (0, 0, 1)}[free]
    scene = (
        f'def PhysicsScene "S" {{ vector3f physics:gravityDirection = {down}\n float physics:gravityMagnitude = 2\n }}'
    )
    physics, warnings = usda(scene + body("A", (1, 2, 3)) + joint("", schemas=schemas, pos0=(1, 2, 3), more=limits))
    steps(physics, 240)
    assert physics.positions[0] - [1, 2, 3] == pytest.approx(fallen(240, 1 / 240, 2) * np.array(down), abs=1e-6)
    assert physics.articulation("/J").joint_names == (f"J:{free}",)
    assert warnings == []


@pytest.mark.parametrize("turned", ["rotX", "rotY", "rotZ"])
@pytest.mark.parametrize("order", [("/B", "/A"), ("/A", "/B")])
def test_a_d6_with_one_turning_axis_is_driven_about_it_whichever_body_comes_first(usda, turned, order):
    schemas, limits = locked(*(a for a in ALL if a != turned))
    motor = drive(turned, damping=10, targetVelocity=90)
    hinge = joint(
        "", schemas=[*schemas, f"PhysicsDriveAPI:{turned}"], body0=order[0], body1=order[1], more=values(limits, motor)
    )
    base = body("B", more="bool physics:kinematicEnabled = 1")
    physics, warnings = usda(base + body("A") + hinge)
    steps(physics, 480)
    sign = 1 if order[1] == "/A" else -1
    wanted = np.zeros(3)
    wanted[ALL.index(turned) - 3] = sign * math.pi / 2
    number = physics.body_paths.index("/A")
    assert physics.velocities()[number, 3:] == pytest.approx(wanted, abs=1e-4)
    assert physics.articulation("/J").velocities == pytest.approx([math.pi / 2], abs=1e-4)
    assert warnings == []


@pytest.mark.parametrize("order", [("/B", "/A"), ("/A", "/B")])
def test_a_d6_starts_where_its_bodies_stand_and_its_axes_are_driven_one_by_one(usda, order):
    schemas, limits = locked("transZ")
    aims = {"transX": 0.4, "transY": -0.3, "rotX": 20.0, "rotY": -30.0, "rotZ": 40.0}
    drives = "\n".join(
        f"float drive:{a}:physics:stiffness = 100\nfloat drive:{a}:physics:damping = 10\n"
        f"float drive:{a}:physics:targetPosition = {aim}"
        for a, aim in aims.items()
    )
    half = math.radians(25) / 2
    start = (math.cos(half), 0, 0, math.sin(half))
    more = body("A", (0.2, 0.1, 0), inertia=(0.1, 0.1, 0.1), turned=start)
    base = body("B", more="bool physics:kinematicEnabled = 1")
    text = (
        base
        + more
        + joint(
            "",
            schemas=[*schemas, *(f"PhysicsDriveAPI:{a}" for a in aims)],
            body0=order[0],
            body1=order[1],
            more=limits + "\n" + drives,
        )
    )
    physics, warnings = usda('def PhysicsScene "S" { float physics:gravityMagnitude = 0\n }' + text, hz=500)
    a = physics.body_paths.index("/A")
    assert physics.positions[a] == pytest.approx([0.2, 0.1, 0], abs=1e-6)
    assert physics.quaternions[a] == pytest.approx(start, abs=1e-6)
    steps(physics, 500 * 8)
    names = [name.partition(":")[2] for name in physics.articulation("/J").joint_names]
    reached = dict(zip(names, physics.articulation("/J").positions, strict=True))
    for name, aim in aims.items():
        assert reached[name] == pytest.approx(math.radians(aim) if name.startswith("rot") else aim, abs=2e-3)
    # the second frame in the first: shifted, then turned about Z, Y, X
    from graph.sim.physics.d6_joints import turn

    wanted = turn(2, math.radians(40)) @ turn(1, math.radians(-30)) @ turn(0, math.radians(20))
    pose = physics.rotations[a]
    if order[0] == "/A":
        pose = pose.T
        assert -pose @ physics.positions[a] == pytest.approx([0.4, -0.3, 0], abs=3e-3)
    else:
        assert physics.positions[a] == pytest.approx([0.4, -0.3, 0], abs=3e-3)
    assert pose == pytest.approx(wanted, abs=5e-3)
    assert warnings == []


def test_a_d6_of_which_everything_is_locked_holds_and_one_of_which_nothing_is_lets_go(usda):
    schemas, limits = locked(*ALL)
    held, _ = usda(
        body("A", (0, 0, 1))
        + body("B", (1, 0, 1))
        + joint("", schemas=schemas, body0="/B", pos0=(-1, 0, 0), more=limits)
    )
    steps(held, 100)
    assert np.ptp(held.positions, axis=0) == pytest.approx([1, 0, 0], abs=1e-9)
    free, _ = usda(body("A", (0, 0, 1), inertia=(1, 2, 3)) + joint("", pos0=(0, 0, 1)))
    steps(free, 100)
    assert free.positions[0, 2] == pytest.approx(1 - 9.81 * (100 / 240) ** 2 / 2, abs=1e-9)  # exact, as of a chain


@pytest.mark.parametrize("order", [(None, "/A"), ("/A", None)])
def test_a_sliding_joint_stops_at_its_limits(usda, order):
    """Along X under 2 m/s2, from 0 to 0.5 m: MuJoCo's limits give way by less than 2 cm at 1.4 m/s, then come to it."""
    scene = (
        'def PhysicsScene "S" { vector3f physics:gravityDirection = (1, 0, 0)\n float physics:gravityMagnitude = 2\n }'
    )
    low, high = (-0.2, 0.5) if order[1] else (-0.5, 0.2)
    rail = joint(
        "Prismatic",
        body0=order[0],
        body1=order[1],
        more=f'uniform token physics:axis = "X"\nfloat physics:lowerLimit = {low}\nfloat physics:upperLimit = {high}',
    )
    physics, warnings = usda(scene + body("A") + rail)
    most = max(physics.positions[0, 0] for _ in range(480) if not physics.step())
    assert 0.5 <= most < 0.52
    assert physics.positions[0] == pytest.approx([0.5, 0, 0], abs=1e-3)
    assert warnings == []


def test_a_distance_joint_is_a_string_and_a_rod(usda):
    string, _ = usda(body("A", (0.5, 0, 0)) + joint("Distance", more="float physics:maxDistance = 1"), hz=500)
    steps(string, 50)
    assert string.positions[0] == pytest.approx([0.5, 0, -fallen(50, 1 / 500)], abs=1e-6)  # slack: it falls
    farthest = max(np.linalg.norm(string.positions[0]) for _ in range(2000) if not string.step())
    # caught at v = sqrt(2 g 0.87) = 4.1 m/s by a critically damped limit of 0.02 s: v 0.02 / e = 3 cm farther
    assert farthest < 1.035
    rod, _ = usda(
        body("A", (1, 0, 0)) + joint("Distance", more="float physics:minDistance = 1\nfloat physics:maxDistance = 1"),
        hz=500,
    )
    lengths = [np.linalg.norm(rod.positions[0]) for _ in range(2000) if not rod.step()]
    assert min(lengths) > 0.98
    assert max(lengths) < 1.02


@pytest.mark.parametrize("cone", [20.0, 60.0])
def test_a_ball_joint_swings_no_farther_than_its_cone(usda, cone):
    """A rod along X from the socket; gravity swings it down until its axis leaves the first frame's by the cone."""
    socket = joint(
        "Spherical",
        pos1=(-1, 0, 0),
        more=cones(cone, cone),
    )
    physics, warnings = usda(body("A", (1, 0, 0), inertia=(0.1, 0.1, 0.1)) + socket, hz=500)
    worst = 0.0
    for _ in range(3000):
        physics.step()
        worst = max(worst, math.degrees(math.acos(np.clip(physics.rotations[0][0, 0], -1, 1))))
    assert cone - 1 < worst < cone + 4
    assert warnings == []


@pytest.mark.parametrize(
    ("velocity", "turn", "spin"),
    [((0, 0, 0), (0, 90, 0), math.pi / 2), ((0, 0, -2), (0, 0, 0), 2.0), ((0, 0, -2), (0, math.degrees(2), 0), 2.0)],
)
@pytest.mark.parametrize("kind", ["Spherical", "Revolute"])
def test_a_body_on_a_joint_starts_with_the_velocity_that_it_is_given(usda, kind, velocity, turn, spin):
    """A metre from the joint, v = 2 m/s across is 2 rad/s, whether the turn, the velocity or both are written."""
    more = values(f"vector3f physics:velocity = {velocity}", f"vector3f physics:angularVelocity = {turn}")
    hinge = joint(kind, pos1=(-1, 0, 0), more=axis("Y") if kind == "Revolute" else "")
    physics, _ = usda(body("A", (1, 0, 0), more=more) + hinge)
    assert physics.velocities()[0] == pytest.approx([0, 0, -spin, 0, spin, 0], abs=1e-6)


def test_a_cone_that_is_wider_one_way_lets_the_joint_swing_so(usda):
    """Y is the axis of the first angle: under gravity along -Z the rod turns about Y."""
    for first, second, most in ((10.0, 50.0, 10.0), (50.0, 10.0, 50.0)):
        more = cones(first, second)
        physics, _ = usda(
            body("A", (1, 0, 0), inertia=(0.1, 0.1, 0.1)) + joint("Spherical", pos1=(-1, 0, 0), more=more), hz=500
        )
        worst = max(
            math.degrees(-math.asin(np.clip(physics.rotations[0][2, 0], -1, 1)))
            for _ in range(1000)
            if not physics.step()
        )
        assert most - 1 < worst < most + 4


def test_a_spring_and_a_damper_swing_as_on_paper(usda):
    """m x'' = -k x - c x': w = sqrt(k/m - (c/2m)2), decay c/2m; m 2 kg, k 200 N/m, c 2 Ns/m."""
    rail = joint(
        "Prismatic",
        schemas=["PhysicsDriveAPI:linear"],
        more=values(axis("X"), drive("linear", stiffness=200, damping=2)),
    )
    text = 'def PhysicsScene "S" { float physics:gravityMagnitude = 0\n }' + body("A", (0.1, 0, 0), mass=2.0)
    physics, _ = usda(text + rail, hz=2000)
    times, tops, before, fastest = [], [], 0.1, 0.0
    for n in range(1, 2000 * 3):
        physics.step()
        now = physics.positions[0, 0]
        if before * now < 0:
            times.append((n - 1 + before / (before - now)) / 2000)
            tops.append(fastest)
            fastest = 0.0
        fastest = max(fastest, abs(now))
        before = now
    w, decay = math.sqrt(100 - 0.25), 0.5
    assert np.diff(times).mean() == pytest.approx(math.pi / w, rel=2e-3)
    # implicit steps damp by w2 dt / 2 more: 0.025 / s
    assert -np.diff(np.log(tops[1:])).mean() * w / math.pi == pytest.approx(decay, abs=0.03)


def test_two_joints_that_mimic_move_as_one_with_their_ratio(usda):
    turn = joint(
        "Revolute",
        "Lead",
        schemas=["PhysicsDriveAPI:angular"],
        more=values(axis("Z"), drive("angular", stiffness=1, damping=0.1, targetPosition=30)),
    )
    follower = joint(
        "Revolute",
        "Follow",
        schemas=["PhysxMimicJointAPI:rotZ"],
        body1="/B",
        more=values(
            axis("Z"),
            "rel physxMimicJoint:rotZ:referenceJoint = </Lead>",
            "float physxMimicJoint:rotZ:gearing = 2",
            "float physxMimicJoint:rotZ:offset = -10",
        ),
    )
    newton = joint(
        "Prismatic",
        "Slide",
        schemas=["NewtonMimicAPI"],
        body1="/C",
        more=values(
            axis("X"),
            "rel newton:mimicJoint = </Lead>",
            "float newton:mimicCoef0 = 0.1",
            "float newton:mimicCoef1 = 0.01",
        ),
    )
    physics, warnings = usda(
        'def PhysicsScene "S" { float physics:gravityMagnitude = 0\n }'
        + body("A")
        + body("B")
        + body("C")
        + turn
        + follower
        + newton,
        hz=500,
    )
    steps(physics, 3000)
    lead, follow, slide = (float(physics.articulation(path).positions[0]) for path in ("/Lead", "/Follow", "/Slide"))
    assert math.degrees(follow) == pytest.approx(-2 * math.degrees(lead) + 10, abs=0.2)  # q + 2 q_lead - 10 = 0
    assert slide == pytest.approx(0.1 + 0.01 * math.degrees(lead), abs=2e-3)
    assert math.degrees(lead) > 5
    assert warnings == []


def test_of_a_loop_the_joint_with_limits_or_a_drive_keeps_its_coordinate(usda):
    """A slider crank: the sliding joint and the motor hang in the tree; a plain hinge closes the loop."""
    parts = body("A", (0.5, 0, 0)) + body("B", (1.5, 0, 0)) + body("C", (2, 0, 0))
    motor = "float drive:angular:physics:damping = 10\nfloat drive:angular:physics:targetVelocity = 90"
    joints = joint(
        "Revolute",
        "Crank",
        schemas=["PhysicsDriveAPI:angular"],
        pos1=(-0.5, 0, 0),
        more=f'uniform token physics:axis = "Y"\n{motor}',
    )
    joints += joint(
        "Revolute",
        "Pin",
        body0="/A",
        body1="/B",
        pos0=(0.5, 0, 0),
        pos1=(-0.5, 0, 0),
        more='uniform token physics:axis = "Y"',
    )
    joints += joint(
        "Revolute", "Wrist", body0="/B", body1="/C", pos0=(0.5, 0, 0), more='uniform token physics:axis = "Y"'
    )
    joints += joint("Prismatic", "Rail", body1="/C", pos0=(2, 0, 0), more='uniform token physics:axis = "X"')
    physics, warnings = usda(parts + joints, hz=1000)
    assert warnings == []
    steps(physics, 500)
    c = physics.body_paths.index("/C")
    # 90 degrees per second for 0.5 s: crank and rod, 1 m each, both stand at 45 degrees to the rail
    assert physics.positions[c, 0] == pytest.approx(2 * math.cos(math.pi / 4), abs=2e-2)
    assert np.abs(physics.positions[c, 1:]).max() < 1e-6


def test_what_a_joint_leaves_out_is_reported(usda):
    _, warnings = usda(body("A") + joint("Fixed", body0="/B", more="float physics:breakForce = 100") + body("B"))
    assert [(code, where) for code, where, _ in warnings] == [("break-force", "/J")]
    _, warnings = usda(
        body("A") + joint("Revolute", schemas=["NewtonMimicAPI"], more="rel newton:mimicJoint = </Nowhere>")
    )
    assert [(code, where) for code, where, _ in warnings] == [("bad-mimic", "/J")]
    assert "/Nowhere" in warnings[0][2]


def test_armature_slows_what_a_torque_turns(usda):
    """0.01 kg m2 and 0.03 of armature under a drive of force 0.4 N m: 10 rad/s2."""
    motor = drive("angular", damping=1000, targetVelocity=100000, maxForce=0.4)
    more = values(axis("Z"), "float physxJoint:armature = 0.03", motor)
    physics, _ = usda(body("A") + joint("Revolute", schemas=["PhysicsDriveAPI:angular", "PhysxJointAPI"], more=more))
    steps(physics, 240)
    assert physics.articulation("/J").velocities == pytest.approx([10.0], rel=1e-6)


@pytest.mark.parametrize("mass", ["-1", "nan", "inf"])
def test_an_invalid_mass_is_reported_and_counts_as_not_written(usda, mass):
    physics, warnings = usda(body("A", mass=mass, inertia=(0, 0, 0)))
    assert [(code, where) for code, where, _ in warnings if code == "bad-mass"] == [("bad-mass", "/A.physics:mass")]
    assert physics.model.body_mass[1] == 1.0  # nothing else gives it one


def test_an_authored_inertia_turns_as_it_says(usda):
    """A free body spun about its middle axis wobbles; about a principal axis it keeps its spin."""
    spin = "vector3f physics:angularVelocity = (0, 0, 360)"
    scene = 'def PhysicsScene "S" { float physics:gravityMagnitude = 0\n }'
    physics, _ = usda(scene + body("A", inertia=(1, 2, 3), more=spin), hz=1000)
    assert sorted(physics.model.body_inertia[1]) == pytest.approx([1, 2, 3])
    steps(physics, 1000)
    assert physics.velocities()[0, 3:] == pytest.approx([0, 0, 2 * math.pi], abs=1e-6)
    # a symmetric top (I, I, 1.5 I): its axis goes round the momentum at w3 (I3 - I) / I = w3 / 2 in the body
    tilt = "vector3f physics:angularVelocity = (36, 0, 360)"
    top, _ = usda(scene + body("A", inertia=(1, 1, 1.5), more=tilt), hz=4000)
    w3 = 2 * math.pi
    steps(top, 2000)
    local = top.rotations[0].T @ top.velocities()[0, 3:]
    angle = w3 / 2 * 2000 / 4000
    assert local == pytest.approx([0.2 * math.pi * math.cos(angle), 0.2 * math.pi * math.sin(angle), w3], abs=0.01)
