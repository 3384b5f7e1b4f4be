import math

import numpy as np
import pytest

from graph.base.errors import RunError
from tests.support.physics_worlds import GROUND, steps


def joint(kind, body0=None, body1=None, pos0=(0, 0, 0), pos1=(0, 0, 0), **attributes):
    values = {"physics:localPos0": list(pos0), "physics:localPos1": list(pos1)}
    values |= {f"physics:body{i}": body for i, body in enumerate((body0, body1)) if body}
    values |= {name.replace("__", ":"): value for name, value in attributes.items()}
    return {"type": f"Physics{kind}Joint", "attributes": values}


def pendulum(start_degrees, **more):
    """A point mass 1 m below a hinge on Y at 3 m, turned out by an angle about Y."""
    angle = math.radians(start_degrees)
    place = [-math.sin(angle), 0, 3 - math.cos(angle)]
    inertia = {"physics:diagonalInertia": [1e-6, 1e-6, 1e-6]}
    return {
        "/Bob": {
            "rigid_body": True,
            "mass": 1.0,
            "translate": place,
            "rotate": [0, start_degrees, 0],
            "attributes": inertia,
        },
        "/Hinge": joint("Revolute", None, "/Bob", (0, 0, 3), (0, 0, 1), physics__axis="Y", **more),
    }


def wheel(**drive):
    inertia = {"physics:diagonalInertia": [0.01, 0.01, 0.01]}
    return {
        "/Wheel": {"rigid_body": True, "mass": 1.0, "translate": [0, 0, 3], "attributes": inertia},
        "/Axle": joint("Revolute", None, "/Wheel", (0, 0, 3), physics__axis="Z", **drive),
    }


def crossings(physics, count, hz):
    """Times at which the pendulum passes its lowest point, interpolated."""
    times, before = [], physics.data.qpos[0]
    for k in range(1, count + 1):
        physics.step()
        now = physics.data.qpos[0]
        if before * now < 0:
            times.append((k - 1 + before / (before - now)) / hz)
        before = now
    return times


def test_a_pendulum_swings_with_its_period(world):
    physics, _, warnings = world(pendulum(5), hz=1000)
    assert physics.articulation("/Bob").positions == pytest.approx([math.radians(5)])
    times = crossings(physics, 10_000, 1000)
    # 2 pi sqrt(l / g) (1 + a2 / 16) for l = 1 m, a = 5 degrees
    period = 2 * math.pi * math.sqrt(1 / 9.81) * (1 + math.radians(5) ** 2 / 16)
    assert 2 * np.diff(times).mean() == pytest.approx(period, rel=1e-4)
    assert warnings == []


def test_limits_stop_a_joint(world):
    physics, _, _ = world(pendulum(80, physics__lowerLimit=-30.0, physics__upperLimit=90.0))
    lowest = min(np.degrees(physics.data.qpos[0]) for _ in range(480) if not physics.step())
    assert -33 < lowest < -29.9


def test_a_velocity_drive_reaches_its_speed_and_holds_it(world):
    physics, _, _ = world(wheel(drive__angular__physics__damping=10.0, drive__angular__physics__targetVelocity=180.0))
    # tau = I / (10 * 180 / pi) s = 17 us: one step is enough.
    steps(physics, 60)
    assert physics.articulation("/Wheel").velocities == pytest.approx([math.pi])


@pytest.mark.parametrize("hz", [60, 240, 1000])
def test_a_drive_never_exceeds_its_force_and_does_not_chatter_at_its_target(world, hz):
    drive = {"damping": 1e6, "targetVelocity": 5730.0, "maxForce": 1.0}
    physics, _, _ = world(wheel(**{f"drive__angular__physics__{key}": value for key, value in drive.items()}), hz=hz)
    steps(physics, hz // 2)
    # 1 N m on 0.01 kg m2 for 0.5 s
    assert physics.data.qvel[0] == pytest.approx(50.0, rel=1e-6)
    steps(physics, hz)
    for _ in range(10):
        physics.step()
        assert physics.data.qvel[0] == pytest.approx(math.radians(5730), rel=1e-6)


@pytest.mark.parametrize("hz", [60, 240])
def test_a_new_target_is_reached_and_not_passed_in_the_step_that_follows_it(world, hz):
    """What is left for one step is 0.05 N m s; the force at its limit would give 1000 / hz of them."""
    drive = {"damping": 100.0, "maxForce": 1000.0}
    physics, _, _ = world(wheel(**{f"drive__angular__physics__{key}": value for key, value in drive.items()}), hz=hz)
    steps(physics, 10)
    physics.articulation("/Wheel").set_targets(velocities=[5.0])
    for _ in range(10):
        physics.step()
        assert 0 < physics.data.qvel[0] <= 5.0 * (1 + 1e-6)
    assert physics.data.qvel[0] == pytest.approx(5.0, rel=1e-3)


@pytest.mark.parametrize("hz", [60, 240])
def test_a_stiff_drive_with_little_force_arrives_and_stays(world, hz):
    drive = {"stiffness": 1e6, "damping": 1e5, "targetPosition": 90.0, "maxForce": 2.0}
    physics, _, _ = world(wheel(**{f"drive__angular__physics__{key}": value for key, value in drive.items()}), hz=hz)
    steps(physics, 3 * hz)
    assert np.degrees(physics.data.qpos[0]) == pytest.approx(90.0, abs=0.01)
    assert abs(physics.data.qvel[0]) < 1e-3


@pytest.mark.parametrize("hz", [60, 120, 240])
@pytest.mark.parametrize("stiffness", [1e3, 1e5, 1e7])
def test_stiff_position_drives_are_stable_and_exact(world, hz, stiffness):
    drive = {"stiffness": stiffness, "damping": stiffness / 100, "targetPosition": 30.0}
    prims = wheel(**{f"drive__angular__physics__{key}": value for key, value in drive.items()})
    physics, _, _ = world(prims, hz=hz)
    steps(physics, 2 * hz)
    assert np.degrees(physics.data.qpos[0]) == pytest.approx(30.0, abs=1e-5)
    assert abs(physics.data.qvel[0]) < 1e-6


def test_an_acceleration_drive_does_not_care_about_the_inertia(world):
    def settled(inertia):
        prims = wheel(drive__angular__physics__damping=0.1, drive__angular__physics__targetVelocity=180.0)
        prims["/Axle"]["attributes"]["drive:angular:physics:type"] = "acceleration"
        prims["/Wheel"]["attributes"]["physics:diagonalInertia"] = [inertia] * 3
        physics, _, _ = world(prims)
        steps(physics, 24)
        return physics.data.qvel[0]

    assert settled(0.01) == pytest.approx(settled(1.0))
    # v = pi (1 - exp(-t k)), k = 0.1 * 180 / pi, t = 0.1 s; backward Euler at 240 Hz
    assert settled(0.01) == pytest.approx(math.pi * (1 - (1 + 18 / math.pi / 240) ** -24))


def test_a_sliding_drive_in_centimetres_is_the_same_as_in_metres(world):
    def slid(unit):
        prims = {
            "/Block": {
                "type": "Cube",
                "size": 0.5 / unit,
                "rigid_body": True,
                "mass": 2.0,
                "translate": [0, 0, 1 / unit],
            },
            "/Rail": joint("Prismatic", None, "/Block", (0, 0, 1 / unit), physics__axis="X"),
        }
        prims["/Rail"]["attributes"] |= {
            "drive:linear:physics:stiffness": 50.0,
            "drive:linear:physics:damping": 5.0,
            "drive:linear:physics:targetPosition": 0.3 / unit,
            "physics:upperLimit": 2.0 / unit,
            "physics:lowerLimit": -2.0 / unit,
        }
        physics, _, _ = world(prims, meters_per_unit=unit)
        steps(physics, 60)
        return physics

    metres, centimetres = slid(1.0), slid(0.01)
    assert metres.data.qpos[0] == pytest.approx(centimetres.data.qpos[0])
    assert centimetres.articulation("/Block").positions == pytest.approx(100 * metres.articulation("/Block").positions)


def robot(damping=500.0):
    prims = {
        **GROUND,
        "/Robot": {"schemas": ["PhysicsArticulationRootAPI"]},
        "/Robot/base": {"rigid_body": True, "mass": 20.0, "translate": [0, 0, 0.3]},
        "/Robot/base/hull": {"type": "Cube", "size": 1.0, "scale": [0.8, 0.4, 0.2]},
    }
    for name, x, y in (("fl", 0.25, 0.25), ("fr", 0.25, -0.25), ("rl", -0.25, 0.25), ("rr", -0.25, -0.25)):
        shape = {"type": "Cylinder", "axis": "Y", "radius": 0.15, "height": 0.08}
        prims[f"/Robot/{name}"] = {**shape, "rigid_body": True, "mass": 1.0, "translate": [x, y, 0.15]}
        prims[f"/Robot/joint_{name}"] = joint(
            "Revolute",
            "/Robot/base",
            f"/Robot/{name}",
            (x, y, -0.15),
            physics__axis="Y",
            drive__angular__physics__damping=damping,
        )
    return prims


@pytest.mark.parametrize("hz", [60, 240])
@pytest.mark.parametrize("damping", [1.0, 500.0, 1e6])
def test_a_wheeled_robot_drives_as_its_wheels_turn(world, hz, damping):
    physics, _, warnings = world(robot(damping), hz=hz)
    wheels = physics.articulation("/Robot")
    assert wheels.joint_names == ("joint_fl", "joint_fr", "joint_rl", "joint_rr")
    steps(physics, hz)
    start = physics.positions[0].copy()
    wheels.set_targets(velocities=[4.0] * 4)
    steps(physics, 5 * hz)
    moved = physics.positions[0] - start
    assert wheels.velocities == pytest.approx([4.0] * 4, rel=2e-3)
    # 4 rad/s on 0.15 m for 5 s is 3 m, less v2 / (2 mu g) = 0.04 m while it speeds up on sliding wheels.
    assert moved[0] == pytest.approx(2.96, abs=0.03)
    assert moved[1:] == pytest.approx([0, 0], abs=1e-3)
    assert warnings == []


def test_an_articulation_is_found_by_its_root_by_a_body_or_by_a_joint(world):
    physics, _, _ = world(robot())
    names = physics.articulation("/Robot").joint_names
    assert physics.articulation("/Robot/base").joint_names == names
    assert physics.articulation("/Robot/joint_rl").joint_names == names
    with pytest.raises(RunError, match=r"/Ground: no revolute or prismatic joint is there"):
        physics.articulation("/Ground")


def test_nan_leaves_a_joint_alone_and_a_wrong_width_changes_nothing(world):
    physics, _, _ = world(robot())
    wheels = physics.articulation("/Robot")
    wheels.set_targets(velocities=[1.0, 2.0, 3.0, 4.0])
    wheels.set_targets(velocities=[math.nan, 5.0, math.nan, math.nan], positions=[])
    wheels.set_targets(velocities=[9.0], joints=[3])
    assert physics.drives.targets[:, 1].tolist() == [1.0, 5.0, 3.0, 9.0]
    with pytest.raises(ValueError, match=r"velocities have shape \(2,\); there are 4 joints"):
        wheels.set_targets(velocities=[1.0, 2.0])
    with pytest.raises(ValueError, match="efforts have shape"):
        wheels.set_targets(velocities=[0.0] * 4, efforts=[1.0])
    with pytest.raises(ValueError, match="infinite"):
        wheels.set_targets(positions=[math.inf, 0, 0, 0])
    assert physics.drives.targets[:, 1].tolist() == [1.0, 5.0, 3.0, 9.0]


def test_an_effort_acts_on_joints_without_a_drive_too(world):
    physics, _, _ = world(wheel())
    arm = physics.articulation("/Axle")
    assert arm.driven.tolist() == [False]
    arm.set_targets(efforts=[0.5], velocities=[3.0])
    steps(physics, 240)
    assert arm.velocities == pytest.approx([50.0])  # 0.5 N m on 0.01 kg m2 for 1 s


def test_a_joint_written_child_first_turns_the_same_way(world):
    prims = {
        "/Base": {"type": "Cube", "size": 0.2, "rigid_body": True, "attributes": {"physics:kinematicEnabled": True}},
        "/Wheel": {"rigid_body": True, "mass": 1.0, "translate": [0, 0, 1]},
    }
    drive = {"drive__angular__physics__damping": 10.0, "drive__angular__physics__targetVelocity": 90.0}
    forward = joint("Revolute", "/Base", "/Wheel", (0, 0, 1), physics__axis="Z", **drive)
    backward = joint("Revolute", "/Wheel", "/Base", (0, 0, 0), (0, 0, 1), physics__axis="Z", **drive)
    for written, turned in ((forward, 1), (backward, -1)):
        physics, _, _ = world({**prims, "/J": written})
        steps(physics, 240)
        assert physics.velocities()[1, 5] == pytest.approx(turned * math.pi / 2)
        assert physics.articulation("/J").velocities == pytest.approx([math.pi / 2])


def test_a_body_out_of_its_joint_is_put_there_and_it_is_reported(world):
    prims = pendulum(0)
    prims["/Bob"]["translate"] = [0.5, 0, 2]
    physics, _, warnings = world(prims)
    assert physics.positions[0] == pytest.approx([0, 0, 2], abs=1e-9)
    assert [(code, where) for code, where, _ in warnings] == [("joint-frames-apart", "/Hinge")]


def test_four_bars_close_their_loop(world):
    def bar(x, z, length, along):
        size = [length, 0.05, 0.05] if along == "x" else [0.05, 0.05, length]
        return {"type": "Cube", "size": 1.0, "scale": size, "translate": [x, 0, z], "rigid_body": True}

    prims = {"/Left": bar(0, 1.5, 1, "z"), "/Top": bar(0.5, 1, 1, "x"), "/Right": bar(1, 1.5, 1, "z")}
    # Cubes are scaled, and so are the joints' places in them.
    prims |= {
        "/J1": joint("Revolute", None, "/Left", (0, 0, 2), (0, 0, 0.5), physics__axis="Y"),
        "/J2": joint("Revolute", "/Left", "/Top", (0, 0, -0.5), (-0.5, 0, 0), physics__axis="Y"),
        "/J3": joint("Revolute", "/Top", "/Right", (0.5, 0, 0), (0, 0, -0.5), physics__axis="Y"),
        "/J4": joint("Revolute", None, "/Right", (1, 0, 2), (0, 0, 0.5), physics__axis="Y"),
    }
    prims["/Top"]["velocity"] = [1, 0, 0]
    physics, _, warnings = world(prims, hz=500)
    steps(physics, 500)
    paths = list(physics.body_paths)
    left, top, right = (physics.positions[paths.index(path)] for path in ("/Left", "/Top", "/Right"))
    assert right - left == pytest.approx([1, 0, 0], abs=5e-3)
    assert physics.quaternions[paths.index("/Top")] == pytest.approx([1, 0, 0, 0], abs=5e-3)
    assert abs(np.linalg.norm(top - [0.5, 0, 2]) - 1) < 5e-3
    # the loop could start to move only as a whole, and just one bar asks for it
    assert [(code, where) for code, where, _ in warnings] == [("velocity-not-possible", "/Top")]


def test_a_ball_joint_and_a_fixed_joint_hold_their_bodies(world):
    prims = {
        "/A": {"type": "Sphere", "radius": 0.1, "rigid_body": True, "translate": [0, 0.5, 2]},
        "/B": {"type": "Sphere", "radius": 0.1, "rigid_body": True, "translate": [0, 1.0, 2]},
        "/Socket": joint("Spherical", None, "/A", (0, 0, 2), (0, -0.5, 0)),
        "/Weld": joint("Fixed", "/A", "/B", (0, 0.5, 0)),
    }
    physics, _, warnings = world(prims)
    steps(physics, 100)
    assert np.linalg.norm(physics.positions[0] - [0, 0, 2]) == pytest.approx(0.5)
    assert np.linalg.norm(physics.positions[1] - [0, 0, 2]) == pytest.approx(1.0)
    assert physics.positions[1, 2] < 1.9
    assert warnings == []


def test_two_fixed_joints_between_two_bodies_are_one_weld(world):
    ball = {"type": "Sphere", "radius": 0.1, "rigid_body": True}
    prims = {
        "/A": ball,
        "/B": {**ball, "translate": [3, 0, 0]},
        "/J": joint("Fixed", "/A", "/B", (3, 0, 0)),
        "/K": joint("Fixed", "/B", "/A", (-3, 0, 0)),
    }
    physics, _, warnings = world(prims)
    steps(physics, 100)
    assert physics.positions[1] - physics.positions[0] == pytest.approx([3, 0, 0], abs=1e-9)
    assert physics.positions[0, 2] == pytest.approx(-9.81 * 5050 / 240**2)
    assert warnings == []


def test_what_is_wrong_with_a_joint_is_reported(world):
    body = {"/A": {"type": "Cube", "size": 0.1, "rigid_body": True}}
    for wrong, code, said in (
        (joint("Revolute", "/A", "/A"), "bad-joint", "ties /A to itself"),
        (joint("Revolute", "/Nowhere", "/A"), "bad-joint", "there is no prim /Nowhere"),
        (
            joint("Revolute", None, "/A", physics__lowerLimit=10.0, physics__upperLimit=-10.0),
            "bad-joint",
            "lower limit",
        ),
    ):
        _, _, warnings = world({**body, "/J": wrong})
        assert [(each[0], each[1]) for each in warnings] == [(code, "/J")]
        assert said in warnings[0][2]
