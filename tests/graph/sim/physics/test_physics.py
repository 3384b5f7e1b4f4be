import math
from fractions import Fraction

import mujoco
import numpy as np
import pytest

from graph.base.errors import RunError
from graph.sim.fidelity import Fidelity
from tests.support.physics_worlds import GROUND, fallen, steps


def ball(**keys):
    return {"type": "Sphere", "radius": 0.2, "rigid_body": True, **keys}


def test_nothing_dynamic_means_no_physics(world):
    held = {"/A": ball(), "/A/J": {"type": "PhysicsFixedJoint", "attributes": {"physics:body1": "/A"}}}
    assert world(GROUND)[0] is None
    assert world({**GROUND, **held})[0] is None
    assert world({"/A": ball(attributes={"physics:kinematicEnabled": True})})[0] is None


@pytest.mark.parametrize("integrator", [None, "euler", "implicit", "implicitfast", "discrete"])
@pytest.mark.parametrize("hz", [60, 240, 1000])
def test_a_body_falls_as_its_integrator_says(world, hz, integrator):
    physics, _, _ = world({"/A": ball(translate=[1, 2, 100])}, hz, fidelity=Fidelity(physics_integrator=integrator))
    steps(physics, hz)
    assert physics.positions[0] == pytest.approx([1, 2, 100 - fallen(hz, 1 / hz)], abs=1e-9)
    assert physics.velocities()[0] == pytest.approx([0, 0, -9.81, 0, 0, 0], abs=1e-9)


def test_runge_kutta_falls_exactly(world):
    physics, _, _ = world({"/A": ball(translate=[0, 0, 100])}, 50, fidelity=Fidelity(physics_integrator="rk4"))
    steps(physics, 100)
    assert physics.positions[0, 2] == pytest.approx(100 - 9.81 * 4 / 2, abs=1e-9)


def test_a_metre_is_a_metre_in_a_stage_of_centimetres(world):
    metres, _, _ = world({**GROUND, "/A": ball(translate=[0, 0, 3], velocity=[1, 0, 0])})
    size = {"radius": 20.0, "translate": [0, 0, 300], "velocity": [100, 0, 0]}
    centimetres, _, _ = world({**GROUND, "/A": ball(**size)}, meters_per_unit=0.01)
    assert centimetres.model.body_mass[1] == pytest.approx(1000 * 4 / 3 * math.pi * 0.2**3)
    for _ in range(10):
        steps(metres, 24)
        steps(centimetres, 24)
        assert centimetres.positions == pytest.approx(metres.positions, abs=1e-6)


def test_gravity_points_down_the_up_axis_unless_the_scene_says_otherwise(world):
    physics, _, _ = world({"/A": ball()}, up="Y")
    steps(physics, 60)
    assert physics.positions[0] == pytest.approx([0, -fallen(60, 1 / 240), 0])
    moon = {
        "type": "PhysicsScene",
        "attributes": {"physics:gravityDirection": [2, 0, 0], "physics:gravityMagnitude": 162},
    }
    physics, _, _ = world({"/Scene": moon, "/A": ball(radius=20.0)}, meters_per_unit=0.01)
    steps(physics, 60)
    assert physics.positions[0] == pytest.approx([fallen(60, 1 / 240, g=1.62), 0, 0])


def test_a_ball_comes_to_rest_on_the_ground(world):
    physics, _, _ = world({**GROUND, "/A": ball(translate=[0, 0, 0.5])})
    steps(physics, 240 * 3)
    assert physics.positions[0] == pytest.approx([0, 0, 0.2], abs=1e-3)
    assert np.abs(physics.velocities()).max() < 1e-6


@pytest.mark.parametrize(
    ("shape", "rest"),
    [
        ({"type": "Cube", "size": 1.0}, 0.5),
        ({"type": "Cube", "size": 1.0, "scale": [1, 2, 0.5]}, 0.25),
        ({"type": "Sphere", "radius": 0.5, "scale": [2, 2, 0.5]}, 0.25),
        ({"type": "Cylinder", "radius": 0.5, "height": 0.6}, 0.3),
        ({"type": "Cylinder", "radius": 0.5, "height": 0.6, "axis": "X"}, 0.5),
        ({"type": "Capsule", "radius": 0.25, "height": 1.0, "axis": "Y"}, 0.25),
        ({"type": "Capsule", "radius": 0.25, "height": 1.0, "axis": "Y", "scale": [1, 2, 1]}, 0.25),
        ({"type": "Cone", "radius": 0.5, "height": 1.0}, 0.5),
        (
            {
                "type": "Mesh",
                "points": [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.3, 0.3)],
                "faces": [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
            },
            0.3,
        ),
    ],
)
def test_every_shape_rests_on_its_own_surface(world, shape, rest):
    physics, _, warnings = world({**GROUND, "/A": {**shape, "rigid_body": True, "translate": [0, 0, rest + 0.01]}})
    steps(physics, 480)
    assert physics.positions[0, 2] == pytest.approx(rest, abs=2e-3)
    assert warnings == []


@pytest.mark.parametrize(
    "floor",
    [
        {"type": "Cube", "size": 1.0, "scale": [10, 10, 1], "translate": [0, 0, 0.5]},
        {"type": "Plane", "width": 10.0, "length": 10.0, "translate": [0, 0, 1]},
        {
            "type": "Mesh",
            "points": [[-5, -5, 1], [5, -5, 1], [5, 5, 1], [-5, 5, 1]],
            "faces": [[0, 1, 2, 3]],
        },
    ],
    ids=["cube", "plane with sides", "flat mesh"],
)
def test_static_floors_carry(world, floor):
    physics, _, _ = world({"/Floor": floor, "/A": ball(translate=[1, 1, 1.5])})
    steps(physics, 480)
    assert physics.positions[0, 2] == pytest.approx(1.2, abs=2e-3)


def test_a_mesh_of_separate_boxes_collides_as_those_boxes(world):
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    points = corners + [[x + 2, y, z] for x, y, z in corners]
    both = {"type": "Mesh", "points": points, "faces": faces + [[i + 8 for i in face] for face in faces]}
    physics, _, warnings = world({**GROUND, "/Boxes": both, "/A": ball(translate=[1.5, 0.5, 2])})
    steps(physics, 480)
    assert physics.positions[0, 2] == pytest.approx(0.2, abs=2e-3)  # it fell between them
    assert warnings == []


def test_colliders_below_nested_transforms_make_one_compound_body(world):
    physics, _, _ = world(
        {
            "/Body": {"rigid_body": True, "translate": [0, 0, 2], "scale": 2},
            "/Body/Arm": {"translate": [0.5, 0, 0]},
            "/Body/Arm/Right": {"type": "Cube", "size": 0.5, "translate": [0.5, 0, 0]},
            "/Body/Left": {"type": "Cube", "size": 0.5, "translate": [-1, 0, 0], "density": 3000},
        }
    )
    # Two 1 m cubes at x = +-2 m: 1000 kg and 3000 kg; centre at (1000 * 2 - 3000 * 2) / 4000 = -1 m.
    assert physics.body_paths == ("/Body",)
    assert physics.model.body_mass[1] == pytest.approx(4000)
    assert physics.model.body_ipos[1] == pytest.approx([-1, 0, 0])
    # About x: both cubes m / 6. About y, z: m / 6 + m d2 with d = 3 and 1.
    about = sorted([4000 / 6, 4000 / 6 + 1000 * 9 + 3000, 4000 / 6 + 1000 * 9 + 3000])
    assert sorted(physics.model.body_inertia[1]) == pytest.approx(about)


def test_friction_holds_on_a_slope_below_its_angle_and_lets_go_above(world):
    def slid(angle):
        down = {"physics:gravityDirection": [math.sin(angle), 0, -math.cos(angle)]}
        rough = {"attributes": {"material:binding:physics": "/Rough"}}
        physics, _, _ = world(
            {
                "/Scene": {"type": "PhysicsScene", "attributes": down},
                "/Rough": {"type": "Material", "attributes": {"physics:dynamicFriction": 0.3}},
                "/Ground": {"type": "Plane", **rough},
                "/A": {"type": "Cube", "size": 0.2, "translate": [0, 0, 0.1], "rigid_body": True, **rough},
            }
        )
        steps(physics, 240)
        return physics.positions[0, 0]

    assert slid(math.atan(0.25)) < 0.02
    # a = g (sin - mu cos) at tan = 0.5: 9.81 sin (1 - 0.6) = 1.755 m/s2, so 0.877 m in 1 s
    assert slid(math.atan(0.5)) == pytest.approx(0.877, rel=0.05)


def test_initial_velocities_are_those_of_the_centre_of_mass(world):
    physics, _, _ = world(
        {
            "/Turn": {"rotate": [0, 0, 90]},
            "/Turn/A": ball(
                velocity=[1, 0, 0], angular_velocity=[0, 0, 180], attributes={"physics:centerOfMass": [0.1, 0, 0]}
            ),
        }
    )
    # In the parent's space, turned by 90 degrees: the centre moves along world Y at 1 m/s and lies 0.1 m along world
    # Y of the origin, so the origin moves at v - w x r = (0, 1, 0) - pi z x 0.1 y = (0.1 pi, 1, 0).
    assert physics.velocities()[0] == pytest.approx(
        [0.1 * math.pi, 1, 0, 0, 0, math.pi], abs=1e-7
    )  # 0.1 is stored as float32


def test_a_diverging_simulation_names_the_body_and_what_to_do(world):
    physics, _, _ = world({"/Calm": ball(translate=[5, 0, 0]), "/Wild": ball(velocity=[1e11, 0, 0])})
    with pytest.raises(RunError, match=r"^/Wild: the simulation diverged.*Raise physics_hz"):
        steps(physics, 2)


def test_a_diverging_simulation_leaves_no_log_file(world, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    physics, _, _ = world({"/Wild": ball(velocity=[1e11, 0, 0])})
    with pytest.raises(RunError):
        steps(physics, 2)
    assert list(tmp_path.iterdir()) == []


def test_reading_poses_does_not_change_the_motion(world):
    prims = {
        **GROUND,
        "/A": ball(translate=[0, 0, 1], angular_velocity=[100, 50, 0]),
        "/B": ball(translate=[0.1, 0, 2]),
    }
    seen, unseen = world(prims)[0], world(prims)[0]
    for _ in range(480):
        seen.step()
        seen.positions, seen.quaternions, seen.velocities()
        unseen.step()
    assert (seen.data.qpos == unseen.data.qpos).all()
    assert (seen.positions == unseen.positions).all()


def test_poses_are_those_of_the_state_after_the_step(world):
    physics, _, _ = world({"/A": ball(velocity=[240, 0, 0])})
    view = physics.positions
    for k in range(1, 5):
        physics.step()
        assert physics.positions[0, 0] == pytest.approx(k)
    assert np.shares_memory(view, physics.positions)


def test_the_time_step_can_change_while_playing(world):
    physics, _, _ = world({"/A": ball()}, hz=100)
    physics.step()
    physics.set_dt(Fraction(1, 10))
    physics.step()
    # v1 = g/100, v2 = v1 + g/10
    assert physics.positions[0, 2] == pytest.approx(-9.81 * (0.01 * 0.01 + (0.01 + 0.1) * 0.1))


def test_filtered_pairs_pass_through_each_other(world):
    prims = {"/A": ball(translate=[0, 0, 0.2]), "/B": ball(translate=[0, 0, 1])}
    prims["/A"]["attributes"] = {"physics:filteredPairs": "/B"}
    physics, _, _ = world({**GROUND, **prims})
    steps(physics, 480)
    assert physics.positions[:, 2] == pytest.approx([0.2, 0.2], abs=2e-3)


def test_a_kinematic_body_carries_others_and_stays(world):
    lift = {"type": "Cube", "size": 1.0, "translate": [0, 0, 2], "rigid_body": True}
    lift["attributes"] = {"physics:kinematicEnabled": True}
    physics, _, _ = world({"/Lift": lift, "/A": ball(translate=[0, 0, 3])})
    steps(physics, 480)
    assert physics.positions[:, 2] == pytest.approx([2, 2.7], abs=2e-3)
    pose = np.eye(4)
    pose[:3, 3] = [0, 0, 2.1]
    physics.set_poses(["/Lift"], pose[None])
    steps(physics, 240)
    assert physics.positions[:, 2] == pytest.approx([2.1, 2.8], abs=5e-3)


def test_a_body_that_starts_asleep_hangs_until_it_is_hit(world):
    sleeper = ball(translate=[0, 0, 5], attributes={"physics:startsAsleep": True})
    physics, _, _ = world(
        {**GROUND, "/Sleeper": sleeper, "/Falling": ball(translate=[0, 0, 6]), "/Other": ball(translate=[3, 0, 1])}
    )
    steps(physics, 60)  # 0.31 m of the 0.6 m between the two
    assert physics.positions[0] == pytest.approx([0, 0, 5])
    assert physics.positions[1, 2] == pytest.approx(6 - fallen(60, 1 / 240), abs=1e-6)
    steps(physics, 420)
    assert physics.positions[[0, 2], 2] == pytest.approx([0.2, 0.2], abs=2e-2)


def test_a_disabled_collider_is_passed_through(world):
    floor = {"type": "Cube", "size": 1.0, "collision": False}
    physics, _, _ = world({"/Floor": floor, "/A": ball(translate=[0, 0, 2])})
    steps(physics, 240)
    assert physics.positions[0, 2] == pytest.approx(2 - fallen(240, 1 / 240), abs=1e-9)


def test_a_body_without_colliders_falls_and_says_what_inertia_it_has(world):
    physics, _, warnings = world({"/A": {"rigid_body": True, "mass": 2.0}})
    steps(physics, 10)
    assert physics.positions[0, 2] == pytest.approx(-fallen(10, 1 / 240))
    assert physics.model.body_inertia[1] == pytest.approx([0.4 * 2 * 0.01] * 3)
    assert [code for code, _, _ in warnings] == ["body-without-volume"]


def test_a_flat_mesh_that_moves_collides_with_a_little_depth(world):
    sheet = {"type": "Mesh", "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "faces": [[0, 1, 2, 3]]}
    physics, _, warnings = world({**GROUND, "/A": {**sheet, "rigid_body": True, "translate": [0, 0, 0.5]}})
    steps(physics, 480)
    assert physics.positions[0, 2] == pytest.approx(0.05, abs=2e-3)
    assert warnings == []


def test_a_step_is_one_mujoco_step(world):
    prims = {**GROUND, "/A": ball(translate=[0, 0, 1]), "/B": ball(translate=[0, 0, 2])}
    ours, raw = world(prims)[0], world(prims)[0]
    for _ in range(200):
        ours.step()
        mujoco.mj_step(raw.model, raw.data)
    assert (ours.data.qpos == raw.data.qpos).all()


def test_crowds_take_memory_by_their_number_not_by_its_square():
    """MuJoCo's own estimate for 1100 free bodies is above 2 GiB, for 6000 above any machine's."""
    from graph.sim.physics.mujoco.compile import compile_world
    from graph.sim.physics.mujoco.library import CROWD_MEMORY
    from graph.sim.physics.solver import UNCHOSEN
    from graph.sim.physics.world_model import Body, Collider, WorldModel

    place = np.eye(4)
    bodies, colliders = [], []
    for number in range(1100):
        place = place.copy()
        place[0, 3] = number
        bodies.append(Body(f"/B{number}", place))
        colliders.append(Collider(f"/B{number}", f"/B{number}", "sphere", np.eye(4), (0.25,)))
    world = WorldModel(np.array([0, 0, -9.81]), tuple(bodies), tuple(colliders), ())
    model = compile_world(world, Fraction(1, 60), UNCHOSEN, lambda *warning: None).model
    assert model.narena == CROWD_MEMORY
