import math

import numpy as np
import pytest

from graph.sim.fidelity import Fidelity
from tests.support.physics_worlds import G, physics_of


def material(**values):
    names = {"static": "physics:staticFriction", "sliding": "physics:dynamicFriction", "bounce": "physics:restitution"}
    names |= {"friction_mode": "physxMaterial:frictionCombineMode"}
    names |= {"bounce_mode": "physxMaterial:restitutionCombineMode"}
    schemas = ["PhysicsMaterialAPI"]
    attributes = {names[key]: value for key, value in values.items()}
    plain = {key: value for key, value in attributes.items() if key.startswith("physics:")}
    extra = {key: value for key, value in attributes.items() if not key.startswith("physics:")}
    return {"type": "Material", "schemas": schemas, "attributes": plain}, extra


def of(name):
    return {"attributes": {"material:binding:physics": name}}


@pytest.fixture
def touching():
    """Two materials, one on the ground and one on a body: touching(ground, other, body, **scene) -> physics."""
    from graph.sim.scene.prims import author_prims
    from graph.sim.scene.stage import open_stage
    from graph.sim.usd import Sdf

    def build(ground, other, body, hz=240, down=None, fidelity=None, floor=None):
        stage = open_stage()
        prims = {"/One": material(**ground)[0], "/Two": material(**other)[0]}
        if down is not None:
            prims["/Scene"] = {"type": "PhysicsScene", "attributes": {"physics:gravityDirection": down}}
        prims["/Ground"] = {**(floor or {"type": "Plane"}), **of("/One")}
        prims["/A"] = {**body, "rigid_body": True, **of("/Two")}
        author_prims(stage, prims)
        for path, values in (("/One", ground), ("/Two", other)):
            for name, value in material(**values)[1].items():
                stage.GetPrimAtPath(path).CreateAttribute(name, Sdf.ValueTypeNames.Token).Set(value)
        return physics_of(stage, hz, fidelity)

    return build


BALL = {"type": "Sphere", "radius": 0.1}
BLOCK = {"type": "Cube", "size": 0.2, "scale": [1, 1, 0.25], "translate": [0, 0, 0.025]}


def rebound(physics, hz, bottom=0.1):
    """Height of the first top after the first bounce."""
    heights = []
    for _ in range(3 * hz):
        physics.step()
        heights.append(physics.positions[0, 2] - bottom)
    rises = np.flatnonzero(np.diff(heights) > 0)
    if not len(rises):
        return 0.0
    falls = np.flatnonzero(np.diff(heights)[rises[0] :] < 0)
    return max(heights[rises[0] + (falls[0] if len(falls) else 0)], 0.0)


@pytest.mark.parametrize("hz", [120, 240, 1000])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_a_ball_dropped_from_h_comes_up_again_to_e2_h(touching, e, hz):
    h = 1.0
    physics, warnings = touching({"bounce": e}, {"bounce": e}, {**BALL, "translate": [0, 0, h + 0.1]}, hz)
    # It is turned round at the end of the step in which it met the ground: up to s = v / hz below it, with the speed of
    # that place, so that it rises to e2 (h + s) - s; half a step of gravity is g h / (v hz) more, twice; and the ground
    # pushes back by half of RECOVERY (0.005) of its speed at most, 0.5 % of e2 h.
    s = math.sqrt(2 * G * h) / hz
    assert rebound(physics, hz) == pytest.approx(e * e * h, abs=s + 0.005 * e * e * h + 1e-3)
    assert warnings == []


def test_bounces_die_away_and_the_ball_rests(touching):
    physics, _ = touching({"bounce": 0.5}, {"bounce": 0.5}, {**BALL, "translate": [0, 0, 1.1]})
    for _ in range(240 * 6):
        physics.step()
    assert physics.positions[0, 2] == pytest.approx(0.1, abs=1e-3)
    assert np.abs(physics.velocities()).max() < 1e-3


@pytest.mark.parametrize(
    ("mode", "other", "e"),
    [("average", "average", 0.6), ("min", "average", 0.4), ("multiply", "min", 0.32), ("max", "multiply", 0.8)],
)
def test_restitution_is_combined_as_the_stronger_mode_says(touching, mode, other, e):
    ground, ball = {"bounce": 0.8, "bounce_mode": mode}, {"bounce": 0.4, "bounce_mode": other}
    physics, _ = touching(ground, ball, {**BALL, "translate": [0, 0, 1.1]}, 500)
    s = math.sqrt(2 * G) / 500
    assert rebound(physics, 500) == pytest.approx(e * e, abs=s + 0.005 * e * e + 1e-3)


def test_a_changed_time_step_keeps_the_bounce(touching):
    from fractions import Fraction

    physics, _ = touching({"bounce": 0.8}, {"bounce": 0.8}, {**BALL, "translate": [0, 0, 1.1]}, 240)
    physics.set_dt(Fraction(1, 1000))
    assert rebound(physics, 1000) == pytest.approx(0.64, abs=math.sqrt(2 * G) / 1000 + 0.004)


def test_a_bouncing_box_stays_flat(touching):
    physics, _ = touching(
        {"bounce": 0.6}, {"bounce": 0.6}, {"type": "Cube", "size": 0.4, "translate": [0, 0, 1.2]}, 240
    )
    assert rebound(physics, 240, bottom=0.2) == pytest.approx(0.36, abs=math.sqrt(2 * G) / 240 + 0.003)
    assert abs(physics.quaternions[0, 0]) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("integrator", ["euler", "implicit", "discrete", "rk4"])
@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_a_ball_bounces_alike_with_every_integrator_and_cone(touching, integrator, cone):
    knobs = Fidelity(physics_integrator=integrator, physics_cone=cone)
    physics, warnings = touching(
        {"bounce": 0.7}, {"bounce": 0.7}, {**BALL, "translate": [0, 0, 1.1]}, 240, fidelity=knobs
    )
    assert rebound(physics, 240) == pytest.approx(0.49, abs=math.sqrt(2 * G) / 240)
    assert warnings == []


@pytest.mark.parametrize("hz", [60, 240])
def test_stiff_drives_and_ground_that_bounces_go_together(world, hz):
    """A cart on four driven wheels that set down at less than gravity gives in two steps: they do not bounce."""
    bouncy = {"physics:staticFriction": 0.5, "physics:dynamicFriction": 0.5, "physics:restitution": 0.8}
    prims = {
        "/M": {"type": "Material", "schemas": ["PhysicsMaterialAPI"], "attributes": bouncy},
        "/Ground": {"type": "Plane", **of("/M")},
        "/Base": {"type": "Cube", "size": 0.4, "rigid_body": True, "mass": 20.0, "translate": [0, 0, 0.4]},
    }
    for number, (x, y) in enumerate(((0.3, 0.3), (0.3, -0.3), (-0.3, 0.3), (-0.3, -0.3))):
        wheel = {"type": "Cylinder", "axis": "Y", "radius": 0.15, "height": 0.08, "rigid_body": True, "mass": 1.0}
        prims[f"/W{number}"] = {**wheel, "translate": [x, y, 0.15]}
        axle = {"physics:body0": "/Base", "physics:body1": f"/W{number}", "physics:axis": "Y"}
        # the base is scaled by none: places in it are metres
        axle |= {"physics:localPos0": [x, y, -0.25], "drive:angular:physics:damping": 1e6}
        axle |= {"drive:angular:physics:targetVelocity": 180.0}
        prims[f"/J{number}"] = {"type": "PhysicsRevoluteJoint", "attributes": axle}
    physics, _, warnings = world(prims, hz)
    for _ in range(5 * hz):
        physics.step()
    # pi rad/s on 0.15 m for 5 s, less v2 / (2 mu g) = 0.02 m while it speeds up on sliding wheels
    assert physics.positions[0, 0] == pytest.approx(0.15 * math.pi * 5 - 0.02, abs=0.05)
    assert physics.positions[0, 2] == pytest.approx(0.4, abs=5e-3)
    assert warnings == []


def slope(angle):
    return [math.sin(angle), 0, -math.cos(angle)]


def slid(physics, seconds=1.0, hz=240):
    for _ in range(int(seconds * hz)):
        physics.step()
    return physics.positions[0, 0]


MODES = [("average", 0.5), ("min", 0.2), ("multiply", 0.16), ("max", 0.8)]


@pytest.mark.parametrize(("mode", "mu"), MODES)
def test_a_block_sticks_below_the_angle_of_combined_friction_and_slides_above(touching, mode, mu):
    ground = {"static": 0.8, "sliding": 0.8, "friction_mode": mode}
    block = {"static": 0.2, "sliding": 0.2}
    stuck, _ = touching(ground, block, BLOCK, down=slope(math.atan(0.9 * mu)))
    assert slid(stuck) < 5e-3
    angle = math.atan(1.5 * mu)
    free, _ = touching(ground, block, BLOCK, down=slope(angle))
    # a = g (sin - mu cos), semi-implicit Euler: a t2 / 2 (1 + 1 / n)
    away = G * (math.sin(angle) - mu * math.cos(angle)) / 2
    assert slid(free) == pytest.approx(away, rel=0.02)


def test_without_any_material_friction_is_half(world):
    scene = {"/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityDirection": slope(math.atan(0.7))}}}
    physics, _, _ = world({**scene, "/Ground": {"type": "Plane"}, "/A": {**BLOCK, "rigid_body": True}})
    angle = math.atan(0.7)
    assert slid(physics) == pytest.approx(G * (math.sin(angle) - 0.5 * math.cos(angle)) / 2, rel=0.05)


@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_friction_at_rest_holds_what_sliding_friction_would_not(touching, cone):
    knobs = Fidelity(physics_cone=cone)
    surface = {"static": 0.8, "sliding": 0.3}
    held, _ = touching(surface, surface, BLOCK, down=slope(math.atan(0.6)), fidelity=knobs)
    assert slid(held) < 5e-3
    moving, _ = touching(
        surface, surface, {**BLOCK, "velocity": [0.5, 0, 0]}, down=slope(math.atan(0.6)), fidelity=knobs
    )
    angle = math.atan(0.6)
    # once it slides, with the lesser friction: 0.5 t + g (sin - 0.3 cos) t2 / 2; the step in which it is seen to slide
    # has the greater one, which takes at most 105 / s (MuJoCo's contact damping) of 0.5 m/s: 0.22 m/s; and where the
    # block hops on its way, another 0.5 g cos / 20 = 0.21 m/s until it is looked at again
    away = 0.5 + G * (math.sin(angle) - 0.3 * math.cos(angle)) / 2
    assert away - 0.43 < slid(moving) < away + 0.01
    loose, _ = touching(surface, surface, BLOCK, down=slope(math.atan(0.9)), fidelity=knobs)
    assert slid(loose) > 0.5


def test_three_materials_each_meet_with_their_own_average(world):
    """Two blocks of friction 0.2 and 0.6 on ground of 1.0: averages 0.6 and 0.8."""

    def rough(mu):
        values = {"physics:staticFriction": mu, "physics:dynamicFriction": mu}
        return {"type": "Material", "schemas": ["PhysicsMaterialAPI"], "attributes": values}

    angle = math.atan(1.0)
    scene = {"/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityDirection": slope(angle)}}}
    prims = {"/M0": rough(1.0), "/M1": rough(0.2), "/M2": rough(0.6), "/Ground": {"type": "Plane", **of("/M0")}}
    for number, name in enumerate(("/A", "/B"), start=1):
        prims[name] = {**BLOCK, "translate": [0, number, 0.025], "rigid_body": True, **of(f"/M{number}")}
    physics, _, warnings = world({**scene, **prims})
    slid(physics)
    for number, mu in ((0, 0.6), (1, 0.8)):
        away = G * (math.sin(angle) - mu * math.cos(angle)) / 2
        assert physics.positions[number, 0] == pytest.approx(away, rel=0.02)
    assert physics.model.npair == 2  # the ground's own friction suits one of them; and the two blocks
    assert warnings == []


def test_a_scene_of_one_material_needs_no_pairs(world):
    prims = {f"/B{i}": {**BLOCK, "translate": [i, 0, 0.025], "rigid_body": True} for i in range(3)}
    physics, _, _ = world({"/Ground": {"type": "Plane"}, **prims})
    assert physics.model.npair == 0
    assert not physics.friction.switching


def test_a_mad_material_is_reported(world):
    bad = {"physics:dynamicFriction": -1.0, "physics:restitution": 2.0}
    prims = {"/M": {"type": "Material", "schemas": ["PhysicsMaterialAPI"], "attributes": bad}}
    _, _, warnings = world({**prims, "/A": {**BLOCK, "rigid_body": True, **of("/M")}})
    assert {(code, where) for code, where, _ in warnings} == {("bad-material", "/M")}
    assert len(warnings) == 3
