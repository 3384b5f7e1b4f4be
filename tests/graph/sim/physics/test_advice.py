"""What `graph explain` says about the accuracy of physics agrees with what physics then does."""

import math
import re

import pytest

from tests.stability.case import GROUND, world
from tests.stability.contacts import BLOCK, slope
from tests.stability.joints import NO_GRAVITY, robot, spring, swinging

RAIL = {"type": "PhysicsPrismaticJoint", "schemas": "PhysicsDriveAPI:linear"}


def advice(physics):
    physics.step(20)
    return physics.facts()["advice"]


def sprung(stiffness, damping=0.0):
    gains = {"drive:linear:physics:stiffness": stiffness, "drive:linear:physics:damping": damping}
    rail = {**RAIL, "attributes": {"physics:body1": "/Mass", "physics:axis": "X", **gains}}
    mass = {"type": "Cube", "rigid_body": True, "mass": 1.0, "collision": False}
    return {**NO_GRAVITY, "/Mass": mass, "/Rail": rail}


def test_the_options_in_effect_and_the_counts_are_told():
    facts = world(robot(0, 1.0), 240, {}).facts()
    assert {key: facts[key] for key in facts if key != "advice"} == {
        "engine": "mujoco",
        "bodies": 5,
        "joints": 4,
        "drives": 4,
        "integrator": "discrete",
        "solver": "newton",
        "cone": "elliptic",
        "iterations": 100,
        "impratio": 10.0,
    }


def test_what_falls_is_ahead_by_half_a_step():
    """g t dt / 2 after 1 s at 240 Hz: 20.4 mm; with rk4 nothing is said."""
    (line,) = advice(world({"/Ball": BLOCK | {"collision": False}}, 240, {}))
    assert "a falling body by 20.4 mm after 1 s; nothing collides, so physics.integrator=rk4" in line
    assert advice(world({"/Ball": BLOCK}, 240, {"integrator": "rk4"})) == []


def test_without_gravity_nothing_falls():
    assert advice(world({**NO_GRAVITY, "/Ball": BLOCK}, 240, {})) == []


def test_the_error_of_a_spring_is_near_what_is_told():
    """0.9 w dt, w = 10 / s: the oracle's drive."""
    (line,) = advice(world(sprung(100.0, 4.0), 240, {}))
    told = float(re.search(r"error of (\d+)%", line)[1]) / 100
    assert told == pytest.approx(spring(240, {}), rel=0.2)
    assert line.startswith("/Rail: ")
    assert "physics.integrator=rk4" in line


@pytest.mark.parametrize("integrator", ["implicit", "implicitfast", "discrete"])
def test_what_a_spring_without_damping_loses_is_near_what_is_told(integrator):
    """1 - exp(-w2 dt / 2) = 19 % a second at w = 10 / s and 240 Hz; euler takes nothing."""
    (line,) = advice(world(sprung(100.0), 240, {"integrator": integrator}))
    assert "has little damping, and loses 19% of its swing a second" in line
    assert swinging(240, {"integrator": integrator}) == pytest.approx(0.19, rel=0.1)
    assert "answers a step" in advice(world(sprung(100.0), 240, {"integrator": "euler"}))[0]
    assert swinging(240, {"integrator": "euler"}) < 0.03


def test_a_spring_too_stiff_for_rk4_is_told_to_take_a_higher_rate():
    """w = 100 / s at 240 Hz; a damping of 1000 / s beside it is 4.2 a step, beyond rk4's 2.8."""
    (line,) = advice(world(sprung(1e4, 1e3), 240, {}))
    assert line.endswith("it is proportional to the step: raise physics.hz")


@pytest.mark.parametrize("degrees", [10, 20])
def test_the_creep_on_a_slope_is_near_what_is_told(degrees):
    knobs = {"contact_softness": 10}
    physics = world({**slope(degrees), "/Box": BLOCK}, 240, knobs)
    line = advice(physics)[-1]
    told = float(re.search(r"about (\S+) mm/s", line)[1])
    physics.step(240)
    start = physics.positions[0].copy()
    physics.step(480)
    assert told == pytest.approx(math.dist(start, physics.positions[0]) / 2 * 1000, rel=0.5)
    assert line.startswith(f"/Box: on a slope of {degrees} degrees it creeps")


def test_bodies_on_level_ground_do_not_creep_and_pyramids_are_told():
    assert len(advice(world({**GROUND, "/Box": BLOCK}, 240, {}))) == 1
    assert "physics.cone=elliptic" in advice(world({**GROUND, "/Box": BLOCK}, 240, {"cone": "pyramidal"}))[-1]
