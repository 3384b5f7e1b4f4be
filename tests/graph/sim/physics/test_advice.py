"""What `graph explain` says about the accuracy of physics agrees with what physics then does."""

import math
import re

import pytest

from graph.sim.physics.mujoco.advice import step_error
from tests.stability.case import GROUND, material, world
from tests.stability.chains import extremes, rods
from tests.stability.contacts import BLOCK, creep, slope, stopping
from tests.stability.free_bodies import projectile
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


@pytest.mark.parametrize("share", [0.2, 0.5, 0.7, 1.0])
@pytest.mark.parametrize("hz", [240, 960])
def test_the_error_of_a_spring_is_near_what_is_told(share, hz):
    """max |t x''| dt / 2, w = 10 / s: an implicit step turns each rate s of the motion into s + s2 dt / 2."""
    error = spring(hz, {}, share) if share != 1.0 else spring(hz, {}, 0.9999)
    assert step_error(share) * 10 / hz == pytest.approx(error, rel=0.12)
    lines = [line for line in advice(world(sprung(100.0, 20 * share), hz, {})) if "its spring answers" in line]
    if lines:
        told = float(re.search(r"error of (\S+)%", lines[0])[1]) / 100
        assert told == pytest.approx(error, rel=0.2, abs=6e-4)
        assert lines[0].startswith("/Rail: ")
        assert "physics.integrator=rk4" in lines[0]
        assert spring(hz, {"integrator": "rk4"}, min(share, 0.9999)) < 1e-3 * error  # the advice, followed


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


@pytest.mark.parametrize("degrees", [10, 16])
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


# -- every advice, followed -------------------------------------------------------------------------------------------


def test_rk4_where_nothing_collides_makes_a_fall_exact():
    assert projectile(240, {}) > 0.02
    assert projectile(240, {"integrator": "rk4"}) < 1e-9


@pytest.mark.parametrize("count", [3, 10])
@pytest.mark.parametrize("hz", [60, 240])
def test_chains_are_not_told_to_take_rk4_which_would_make_them_diverge(count, hz):
    lines = advice(world(rods(count), hz, {}))
    assert not any("physics.integrator=rk4" in line for line in lines)
    assert any(line.startswith("joints without drives below /Rod0 swing: they keep their energy") for line in lines)
    chosen = advice(world(rods(count), 960, {"integrator": "implicitfast"}))
    assert any(line.endswith("leave physics.integrator out") for line in chosen)
    low, high = extremes(world(rods(count), 960, {}), 960, every=8)
    assert max(-low, high) < 1e-3 * 0.1 * 9.81 * 0.1 * count**2 / 2  # the advice, followed


def test_elliptic_cones_stop_a_slide_along_a_diagonal_where_it_should():
    assert stopping(240, {"cone": "pyramidal"}) > 20 * stopping(240, {"cone": "elliptic"})


def crept(physics, hz):
    """Speed of the creep after a second [mm/s]."""
    physics.step(hz)
    start = physics.positions[0].copy()
    physics.step(2 * hz)
    return math.dist(start, physics.positions[0]) / 2 * 1000


def test_creep_below_the_limit_of_friction_is_in_proportion_to_impratio_and_softness():
    """10 degrees at mu 0.5: a third of what friction holds."""
    prims = {**slope(10), "/Box": BLOCK}
    usual = crept(world(prims, 240, {}), 240)
    assert crept(world(prims, 240, {"impratio": 100}), 240) == pytest.approx(usual / 10, rel=0.1)
    assert crept(world(prims, 240, {"contact_softness": 0.1}), 240) == pytest.approx(usual / 10, rel=0.15)


def test_creep_near_the_limit_of_friction_is_told_to_take_a_higher_rate():
    """35 degrees at mu 0.75: 93 % of what friction holds; firmer friction makes it creep more."""
    binds = {"attributes": {"material:binding:physics": "/Rough"}}
    prims = {**material("/Rough", 0.75), **slope(35), "/Ground": {"type": "Plane", **binds}, "/Box": {**BLOCK, **binds}}
    line = advice(world(prims, 60, {"contact_softness": 10}))[-1]
    assert line.startswith("/Box: on a slope of 35 degrees it creeps at least")
    assert line.endswith("near what friction can hold; raise physics.hz")
    usual = crept(world(prims, 60, {}), 60)
    assert crept(world(prims, 60, {"impratio": 100}), 60) > usual > crept(world(prims, 240, {}), 240)
    assert creep(240, {}) < creep(60, {}) / 2
