"""Kinematic bodies that move carry what touches them."""

import numpy as np
import pytest

from graph.sim import App
from graph.sim.usd import Gf, UsdGeom, UsdShade

G, TOP = 9.81, 0.5
BOX = {"/Load": {"type": "Cube", "size": 0.2, "translate": [0, 0, TOP + 0.1], "rigid_body": True}}
BOUNCY = {
    "/Rubber": {
        "type": "Material",
        "schemas": ["PhysicsMaterialAPI"],
        "attributes": {"physics:restitution": 0.5, "physics:staticFriction": 0.5, "physics:dynamicFriction": 0.5},
    }
}


def app_with_lift(velocity, load, hz=240, integrator=None):
    """A slab with its top at z = 0.5 that is animated to move at a velocity [m/s] from second 0 to second 10."""
    app = App(physics_hz=hz, loop_hz=60, fidelity={"physics.integrator": integrator} if integrator else {})
    kinematic = {"physics:kinematicEnabled": True}
    app.add_prims({"/Lift": {"type": "Cube", "size": 1.0, "rigid_body": True, "attributes": kinematic}, **load})
    xform = UsdGeom.Xformable(app.stage.GetPrimAtPath("/Lift"))
    move = xform.AddTranslateOp()
    xform.AddScaleOp().Set(Gf.Vec3d(40, 40, 1))
    end = 10 * app.stage.GetTimeCodesPerSecond()
    move.Set(Gf.Vec3d(0, 0, 0), 0)
    move.Set(Gf.Vec3d(*(10.0 * part for part in velocity)), end)
    app.timeline.set_end_time(10)
    return app


def load_over_lift(app):
    """(3,) position of the load relative to the lift [m], and its velocity [m/s]."""
    tensors = app.simulation.tensors
    lift, load = (tensors.body_paths.index(path) for path in ("/Lift", "/Load"))
    return tensors.positions[load] - tensors.positions[lift], tensors.linear_velocities[load]


@pytest.mark.parametrize("integrator", ["implicitfast", "euler", "discrete"])
@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_a_box_rises_and_sinks_with_its_lift(integrator, speed):
    """Relative to a lift of constant speed nothing differs from rest, so the box sinks in as at rest.

    That is 0.02 mm here; 0.2 mm are allowed. The first step, before which the lift stood, puts the box off by v dt =
    4.2 mm, which contacts of a time constant of 0.02 s have forgotten after 2 s. Without the velocity it was 40 mm.
    """
    with app_with_lift((0, 0, speed), BOX, integrator=integrator) as app:
        app.play()
        app.update(steps=120)
        place, velocity = load_over_lift(app)
    assert place == pytest.approx([0, 0, TOP + 0.1], abs=2e-4)
    assert velocity == pytest.approx([0, 0, speed], abs=1e-3)


@pytest.mark.parametrize("integrator", ["implicitfast", "euler"])
def test_a_slab_that_moves_sideways_carries_a_box_by_friction(integrator):
    """It slips until friction (0.5, where no material says otherwise) has given it the slab's speed: v2 / (2 mu g).

    Each step may add v dt to that: one in which the slab has no velocity yet, one in which friction takes hold.
    """
    speed, dt = 0.5, 1 / 240
    with app_with_lift((speed, 0, 0), BOX, integrator=integrator) as app:
        app.play()
        app.update(steps=120)
        place, velocity = load_over_lift(app)
    slip = speed**2 / (2 * 0.5 * G)
    assert slip <= -place[0] <= slip + 2 * speed * dt
    assert velocity == pytest.approx([speed, 0, 0], abs=1e-3)


def test_a_ball_bounces_off_a_rising_lift_by_their_relative_speed():
    """Dropped h above a lift of speed u it meets it at w2 = u2 + 2 g h, and rises (e w)2 / (2 g) above it again.

    Both within (1 - e2) w dt, as on ground at rest.
    """
    u, h, e, hz = 1.0, 0.2, 0.5, 960
    ball = {"type": "Sphere", "radius": 0.1, "translate": [0, 0, TOP + 0.1 + h], "rigid_body": True}
    with app_with_lift((0, 0, u), BOUNCY | {"/Load": ball}, hz=hz, integrator="implicitfast") as app:
        rubber = UsdShade.Material(app.stage.GetPrimAtPath("/Rubber"))
        for path in ("/Lift", "/Load"):
            binding = UsdShade.MaterialBindingAPI.Apply(app.stage.GetPrimAtPath(path))
            binding.Bind(rubber, materialPurpose="physics")
        heights = []
        app.on("physics_post_step", lambda: heights.append(load_over_lift(app)[0][2] - TOP - 0.1), 1)
        app.play()
        app.update(steps=24)
    w = np.sqrt(u**2 + 2 * G * h)
    hit = int(np.argmin(heights[: hz // 5]))
    assert max(heights[hit:]) == pytest.approx((e * w) ** 2 / (2 * G), abs=(1 - e**2) * w / hz + w / hz)


def test_a_lift_carries_nothing_in_steps_in_which_the_timeline_stands():
    with app_with_lift((0, 0, 1), BOX) as app:
        app.play()
        app.update(steps=60)
        app.simulation.step(steps=1)  # from here on the lift stands
        before = load_over_lift(app)[0]
        app.simulation.step(steps=240)
        place, velocity = load_over_lift(app)
    # The box had 1 m/s when the lift stopped: it flies, and lies there again after 2 v / g = 0.2 s.
    assert before[2] == pytest.approx(TOP + 0.1, abs=5e-3)
    assert place[2] == pytest.approx(TOP + 0.1, abs=2e-4)
    assert velocity == pytest.approx([0, 0, 0], abs=1e-3)


def test_a_slab_under_the_integrator_discrete_says_once_that_it_carries_nothing_sideways():
    with app_with_lift((0.5, 0, 0), BOX, integrator="discrete") as app:
        app.play()
        app.update(steps=60)
        assert [w.where for w in app.warnings if w.code == "kinematic-not-carrying"] == ["/Lift"]
