"""Steps that are too long for a drive or a spin are one warning that names the rate to take."""

import math

import pytest

from graph.base.errors import RunError
from graph.sim import App
from graph.sim.physics.mujoco.step_size import EULER, RK4, holds, least_rate

NO_GRAVITY = {"/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}}


def body(inertia, spin=(0, 0, 0)):
    attributes = {"physics:mass": 1.0, "physics:diagonalInertia": list(inertia)}
    spin = [math.degrees(rate) for rate in spin]
    return {"type": "Cube", "size": 0.1, "rigid_body": True, "angular_velocity": spin, "attributes": attributes}


def driven(stiffness, damping):
    """A mass of 1 kg on a rail, driven to 1 m."""
    gains = {"stiffness": stiffness, "damping": damping, "targetPosition": 1.0}
    drive = {f"drive:linear:physics:{name}": value for name, value in gains.items()}
    rail = {"type": "PhysicsPrismaticJoint", "schemas": "PhysicsDriveAPI:linear"}
    rail["attributes"] = {"physics:body1": "/Mass", "physics:axis": "X", **drive}
    return {**NO_GRAVITY, "/Mass": body((1, 1, 1)), "/Rail": rail}


def told(app, code):
    return [(warning.where, warning.message) for warning in app.warnings if warning.code == code]


@pytest.mark.parametrize(("integrator", "limit"), [(EULER, 2.0), (RK4, 2.7853)])
def test_an_explicit_integrator_holds_damping_up_to_its_limit(integrator, limit):
    """Of x'' = -c x': |1 - h c| = 1 at 2; rk4's polynomial is 1 again at -2.7853 (Hairer and Wanner, IV.2)."""
    assert holds(integrator, 0.999 * limit / 100, stiffness=0, damping=100)
    assert not holds(integrator, 1.001 * limit / 100, stiffness=0, damping=100)


@pytest.mark.parametrize(("integrator", "limit"), [(EULER, 2.0), (RK4, 2.8284)])
def test_an_explicit_integrator_holds_springs_up_to_its_limit(integrator, limit):
    """Of x'' = -w2 x: h w = 2, and 2 sqrt(2) with rk4."""
    assert holds(integrator, 0.999 * limit / 100, stiffness=1e4, damping=0)
    assert not holds(integrator, 1.001 * limit / 100, stiffness=1e4, damping=0)


def test_the_least_rate_is_found_to_a_hundredth():
    assert 777 <= least_rate(lambda step: step * 777 <= 1, 60) <= 785


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_a_drive_too_stiff_for_an_explicit_integrator_is_named_with_the_rate_that_holds_it(integrator):
    """Damping of 1000 / s at 240 Hz: 4.2 is beyond 2 and 2.8; at 505 and 363 Hz (one hundredth above) it holds."""
    with App(physics_hz=240, fidelity={"physics.integrator": integrator}) as app:
        app.add_prims(driven(1.0, 1000.0))
        app.play()
        app.update()
        ((where, message),) = told(app, "drive-unstable")
        assert where == "/Rail"
        rate = int(message.partition("physics_hz to ")[2].split()[0])
        assert rate == pytest.approx({"euler": 500, "rk4": 1000 / 2.7853}[integrator], rel=0.011)
        with pytest.raises(
            RunError, match=r"^/Mass: the simulation diverged here, at \S+ s of physics: an? \w+ became"
        ):
            app.update(steps=600)
    with App(physics_hz=rate, fidelity={"physics.integrator": integrator}) as app:
        app.add_prims(driven(1.0, 1000.0))
        app.play()
        app.update(steps=600)
        assert told(app, "drive-unstable") == []


@pytest.mark.parametrize("integrator", [None, "implicit", "implicitfast", "discrete"])
def test_implicit_integrators_hold_any_drive(integrator):
    with App(physics_hz=60, fidelity={} if integrator is None else {"physics.integrator": integrator}) as app:
        app.add_prims(driven(1e6, 1e6))
        app.play()
        app.update(steps=600)
        assert told(app, "drive-unstable") == []


@pytest.mark.parametrize(
    ("integrator", "what"), [("implicitfast", "it loses"), ("euler", "its wobble grows by"), ("rk4", None)]
)
def test_a_body_that_tumbles_too_fast_for_its_integrator_is_named(integrator, what):
    """10 rad/s about the middle axis at 60 Hz: g up to 0.1, so up to 0.08 g2 60 = 4 % a second; rk4: 1e-6 / 1000 60."""
    with App(physics_hz=60, fidelity={"physics.integrator": integrator}) as app:
        app.add_prims({**NO_GRAVITY, "/Top": body((0.01, 0.02, 0.03), (0.1, 10, 0.1))})
        app.play()
        app.update(steps=120)
        found = told(app, "spin-too-fast")
    assert [where for where, _ in found] == (["/Top"] if what else [])
    if what:
        assert what in found[0][1]
        assert "set physics.integrator to rk4" in found[0][1]


@pytest.mark.parametrize(
    ("integrator", "hz", "warned"),
    [("implicitfast", 240, True), ("discrete", 240, True), ("rk4", 240, False), ("implicitfast", 30000, False)],
)
def test_a_top_on_a_ball_joint_is_named_before_its_wobble_has_grown(integrator, hz, warned):
    """J = (5/64, 5/64, 3/128) about the pivot, 30 rad/s: l2 = 900 (0.7)2 = 441, by dt / 2: 0.9, at 30 kHz 0.007 / s."""
    spin = [0, -30 * math.sin(math.radians(20)), 30 * math.cos(math.radians(20))]
    where = [0, -0.25 * math.sin(math.radians(20)), 0.25 * math.cos(math.radians(20))]
    top = {**body((1 / 64, 1 / 64, 3 / 128), spin), "rotate": [20, 0, 0], "translate": where, "collision": False}
    ends = {"physics:body1": "/Top", "physics:localPos1": [0, 0, -0.25]}
    with App(physics_hz=hz, fidelity={"physics.integrator": integrator}) as app:
        app.add_prims({"/Top": top, "/Pivot": {"type": "PhysicsSphericalJoint", "attributes": ends}})
        app.play()
        app.update(steps=6)
        found = told(app, "spin-too-fast")
    assert [where for where, _ in found] == (["/Top"] if warned else [])
    if warned:
        assert "its wobble grows by 9" in found[0][1]


@pytest.mark.parametrize(("inertia", "spin"), [((0.01, 0.01, 0.01), (50, 50, 0)), ((0.01, 0.01, 0.02), (0, 0, 100))])
def test_balls_and_wheels_may_spin(inertia, spin):
    """No gyroscopic torque: equal inertias, or a spin about an axis of the inertia."""
    with App(physics_hz=60) as app:
        app.add_prims({**NO_GRAVITY, "/Top": body(inertia, spin)})
        app.play()
        app.update(steps=60)
        assert told(app, "spin-too-fast") == []


@pytest.mark.parametrize(("hz", "loop"), [(240, 60), (240, 30), (240, 240)])
def test_subscribers_and_the_length_of_updates_change_no_number_of_a_warning(hz, loop):
    """10 rad/s about the middle axis turns over within a second; only then are g and the loss large enough."""
    messages = []
    for watched in (False, True):
        with App(physics_hz=hz, loop_hz=loop) as app:
            app.add_prims({**NO_GRAVITY, "/Top": body((0.01, 0.02, 0.03), (0.01, 10, 0.01))})
            if watched:
                app.on("physics_post_step", lambda: None)
            app.play()
            app.update(steps=2 * loop)
            messages += told(app, "spin-too-fast")
    alone, seen = messages
    assert alone == seen
    assert "it turns by 0.048 rad in a step" in alone[1]
