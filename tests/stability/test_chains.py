"""Passive chains keep their energy and closed loops stay closed, with the defaults, at any rate."""

from fractions import Fraction

import numpy as np
import pytest

from graph.sim import App

from .case import GROUND, world
from .chains import CASES, energy, extremes, heavy_top, random_chain, ring, rod, rods, widest_gap


@pytest.mark.parametrize("hz", [60, 240])
@pytest.mark.parametrize(("count", "length"), [(2, 1.0), (3, 0.1), (10, 0.1)])
def test_rods_that_swing_keep_their_energy(count, length, hz):
    """Held out and let go: kinetic energy is what the fall gives, so the sum stays 0. m g L n2 / 2 is the scale."""
    low, high = extremes(world(rods(count, length), hz, {}), 5 * hz, every=hz // 60)
    scale = 0.1 * 9.81 * length * count**2 / 2
    assert max(-low, high) < 1e-3 * scale


def test_sixty_rods_keep_their_energy():
    """177 J from straight out to straight down; 27 J too much before steps were divided."""
    low, high = extremes(world(rods(60), 240, {}), 120, every=4)
    assert max(-low, high) < 0.1


@pytest.mark.parametrize("seed", range(24))
def test_random_chains_of_hinges_and_balls_neither_diverge_nor_gain_energy(seed):
    physics = world(random_chain(seed), 60, {})
    start = energy(physics)
    scale = abs(start) + 9.81 * float(physics.masses @ np.linalg.norm(physics.positions, axis=1))
    _, high = extremes(physics, 180, every=3)
    assert high < 2e-3 * scale


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_top_on_a_ball_joint_precesses_as_on_paper(case):
    assert case.error(case.hz, {}) < case.bound
    assert heavy_top(240, {}) < case.bound


@pytest.mark.parametrize("hz", [60, 240])
def test_a_ring_of_twelve_bars_stays_closed(hz):
    """Hung at a corner it falls and swings; 110 and 25 mm before its steps were divided."""
    physics, worst = world(ring(12), hz, {}), 0.0
    start, scale = energy(physics), 12 * 9.81 * 2
    for _ in range(hz):
        physics.step()
        worst = max(worst, widest_gap(physics, 12))
        assert energy(physics) - start < 0.05 * scale
    assert worst < 6e-4


def limited(degrees):
    """Five rods whose hinges stop at so many degrees to both sides."""
    prims = rods(5, 0.2)
    for n in range(5):
        prims[f"/Hinge{n}"]["attributes"] |= {"physics:lowerLimit": -degrees, "physics:upperLimit": degrees}
    return prims


@pytest.mark.parametrize("hz", [60, 240])
@pytest.mark.parametrize("degrees", [20.0, 60.0])
def test_rods_that_hit_the_limits_of_their_hinges_are_not_thrown_back(degrees, hz):
    """2.45 J from straight out to straight down. At 60 Hz they diverged."""
    _, high = extremes(world(limited(degrees), hz, {}), 3 * hz)
    assert high < 0.4


@pytest.mark.parametrize("integrator", [None, "rk4"])
def test_a_chosen_integrator_is_used_as_it_is(integrator):
    assert bool(world(rods(3), 60, {"integrator": integrator} if integrator else {}).chains) == (integrator is None)


def test_rods_that_sweep_over_the_ground_and_a_box_beside_them_stay_bounded():
    box = {"type": "Cube", "size": 0.2, "rigid_body": True, "translate": [0, 3, 0.1]}
    prims = {**GROUND, **rods(10, height=0.5, collision=True), "/Box": box}
    low, high = extremes(world(prims, 60, {}), 180)
    assert high < 0.05 < -low  # they lose energy to friction with the ground


def test_a_snapshot_that_is_restored_continues_to_the_bit():
    """How a step is divided follows from the state alone."""
    physics = world(rods(4), 60, {})
    physics.step(40)
    taken = physics.snapshot()
    physics.step(40)
    first = physics.positions.copy()
    physics.restore(taken)
    physics.step(40)
    assert (physics.positions == first).all()


def test_steps_and_stamps_are_those_of_any_world():
    with App(physics_hz=240, loop_hz=60) as app:
        counted = []
        app.add_prims(rods(3))
        app.on("physics_post_step", lambda: counted.append(app.simulation.time))
        app.play()
        app.update(steps=3)
        assert counted == [Fraction(n, 240) for n in range(1, 13)]


def test_worlds_without_chains_or_loops_are_stepped_as_before():
    """Wheels are not chains, because inertia stays the same while they turn."""
    from .joints import robot

    ball = {"type": "Sphere", "radius": 0.1, "rigid_body": True}
    for prims in ({"/Ball": ball}, rods(1), robot(0.0, 1.0)):
        assert not world(prims, 60, {}).divides


@pytest.mark.parametrize(("rate", "codes"), [(17.0, []), (1600.0, ["energy-grows"])])
def test_what_the_smallest_part_cannot_hold_is_one_warning_with_the_chain_and_what_helps(rate, codes):
    """A ball joint may turn by 0.4 rad in a part of a step: 1536 rad/s in 1/64 of 1/60 s. The drive keeps rk4 away."""
    prims = rods(1, 0.2, 1.0)
    prims["/Hinge0"]["schemas"] = ["PhysicsDriveAPI:angular"]
    prims["/Hinge0"]["attributes"]["drive:angular:physics:damping"] = 1.0
    prims |= rod("/Rod1", 0.2, 1.0, translate=[0.3, 0, 0], angular_velocity=[np.degrees(rate), 0, 0])
    ends = {"physics:body0": "/Rod0", "physics:localPos0": [0.1, 0, 0]}
    ends |= {"physics:body1": "/Rod1", "physics:localPos1": [-0.1, 0, 0]}
    prims["/Ball"] = {"type": "PhysicsSphericalJoint", "attributes": ends}
    with App(None, physics_hz=60, loop_hz=60) as app:
        app.add_prims(prims)
        app.play()
        app.update()
        told = [one for one in app.warnings if one.code == "energy-grows"]
    assert [one.code for one in told] == codes
    assert all("1/64 of a step" in one.message and "raise physics_hz" in one.message for one in told)
