"""Impacts with friction: Coulomb's and Newton's laws at any rate."""

import math

import numpy as np
import pytest

from .case import G, material, world
from .chains import energy

RADIUS, DROP = 0.1, 0.5
FALL = math.sqrt(2 * G * DROP)


def thrown(restitution, friction, hz, velocity, spin=(0.0, 0.0, 0.0)):
    """The physics of a solid ball above ground of one material with it, its lowest point at `DROP`."""
    binds = {"attributes": {"material:binding:physics": "/Hard"}}
    ball = {"type": "Sphere", "radius": RADIUS, "translate": [0, 0, DROP + RADIUS], "rigid_body": True, **binds}
    ball |= {"velocity": velocity, "angular_velocity": np.degrees(spin).tolist()}
    return world(
        {**material("/Hard", friction, restitution), "/Ground": {"type": "Plane", **binds}, "/Ball": ball}, hz, {}
    )


def after_bounce(physics, hz):
    """Linear and angular velocity of the ball when it has left the ground."""
    for _ in range(hz):
        physics.step()
        motion = physics.velocities()[0]
        if motion[2] > 0.05:
            return motion[:3], motion[3:]
    raise AssertionError("it did not bounce")


def law(restitution, friction, velocity, spin):
    """Slip s = v + w x (-r z). J = min(mu (1 + e) v_n, 2/7 m s) against it: rolling begins where that is enough.

    A solid ball has I = 2/5 m r2, so the point of contact takes J (1 / m + r2 / I) = 7/2 J / m.
    """
    slip = np.array(velocity) + np.cross(spin, [0, 0, -RADIUS])
    slip[2] = 0.0
    size = float(np.linalg.norm(slip))
    impulse = min(friction * (1 + restitution) * FALL, 2 / 7 * size) * -slip / max(size, 1e-12)
    return np.array(velocity) + impulse, np.array(spin) + np.cross([0, 0, -RADIUS], impulse) / (0.4 * RADIUS**2)


@pytest.mark.parametrize("hz", [60, 240, 960])
@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("friction", [0.0, 0.05, 0.2, 0.8])
@pytest.mark.parametrize(
    ("velocity", "spin"),
    [([5.0, 0.0, 0.0], [0.0, 0.0, 0.0]), ([-2.0, 3.0, 0.0], [0.0, 0.0, 0.0]), ([1.0, 0.0, 0.0], [0.0, -30.0, 0.0])],
)
def test_a_ball_leaves_the_ground_as_coulomb_and_newton_say(velocity, spin, friction, restitution, hz):
    """Within what the engine's own part of the impulse errs, which acts at half the depth: half at twice the rate."""
    linear, angular = after_bounce(thrown(restitution, friction, hz, velocity, spin), hz)
    wanted_linear, wanted_angular = law(restitution, friction, velocity, spin)
    bound = 0.15 * 60 / hz + 0.003
    assert linear[:2] == pytest.approx(wanted_linear[:2], abs=bound)
    assert angular == pytest.approx(wanted_angular, abs=bound / RADIUS)
    assert linear[2] == pytest.approx(restitution * FALL, rel=0.01)


@pytest.mark.parametrize("hz", [60, 240, 960])
def test_without_restitution_friction_takes_the_same_and_goes_on_sliding(hz):
    """mu (v_n + g t): the impulse of the impact, then that of its weight while it slides."""
    physics = thrown(0.0, 0.2, hz, [5.0, 0.0, 0.0])
    fall = FALL / G
    physics.step(round(hz * (fall + 0.1)))
    after = round(hz * (fall + 0.1)) / hz - fall
    assert physics.velocities()[0, 0] == pytest.approx(5.0 - 0.2 * (FALL + G * after), abs=0.03)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("hz", [60, 240])
def test_a_thrown_box_never_has_more_energy_than_at_its_start(seed, hz):
    random = np.random.default_rng(seed)
    binds = {"attributes": {"material:binding:physics": "/Hard"}}
    box = {"type": "Cube", "size": 0.2, "translate": [0, 0, 1], "rigid_body": True, **binds}
    box |= {"velocity": random.uniform(-4, 4, 3).tolist(), "angular_velocity": random.uniform(-600, 600, 3).tolist()}
    box |= {"rotate": random.uniform(0, 360, 3).tolist()}
    hard = material("/Hard", float(random.uniform(0, 1)), float(random.uniform(0.3, 0.95)))
    physics = world({**hard, "/Ground": {"type": "Plane", **binds}, "/Box": box}, hz, {})
    start = energy(physics)
    for _ in range(2 * hz):
        physics.step()
        assert energy(physics) < 1.01 * start


def test_two_balls_that_meet_aslant_exchange_equal_impulses():
    """No gravity: momentum stays, the speeds along the line of centres reverse with e, friction acts across it."""
    binds = {"attributes": {"material:binding:physics": "/Hard"}, "rigid_body": True, "mass": 1.0}
    ball = {"type": "Sphere", "radius": RADIUS, **binds}
    prims = {"/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}}
    prims |= {**material("/Hard", 0.1, 0.7), "/A": {**ball, "translate": [-0.5, 0, 0], "velocity": [2.0, 1.0, 0]}}
    prims["/B"] = {**ball, "translate": [0.0, 0.2, 0], "velocity": [0.0, 0.0, 0]}
    physics = world(prims, 960, {})
    physics.step(960)
    motion = physics.velocities()
    assert motion[:, :3].sum(axis=0) == pytest.approx([2, 1, 0], abs=1e-6)
    assert motion[0, 5] == pytest.approx(motion[1, 5], rel=0.02)  # both turn the same way
    assert abs(motion[0, 5]) > 0.5
    assert energy(physics) < 2.5
