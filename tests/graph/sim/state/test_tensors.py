"""The state of the whole world as arrays, and writing it."""

from __future__ import annotations

import numpy as np
import pytest

from graph.base.errors import RunError
from graph.sim import App
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom, UsdPhysics

PRIMS = {
    "/World/Ground": {"type": "Plane"},
    "/World/Box": {"type": "Cube", "size": 1, "translate": [0, 0, 0.5], "rigid_body": True, "mass": 2},
    "/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [5, 0, 9], "rotate": [0, 0, 90], "rigid_body": True,
                    "velocity": [1, 2, 3], "angular_velocity": [0, 0, 90]},
    "/World/Lift": {"type": "Cube", "translate": [-5, 0, 0.5], "rigid_body": True,
                    "attributes": {"physics:kinematicEnabled": True}},
}  # fmt: skip


@pytest.fixture
def app():
    with App(physics_hz=240, loop_hz=60) as app:
        app.add_prims(PRIMS)
        yield app


@pytest.fixture
def pendulum():
    """A bar that turns about the world's Y axis at its upper end, driven towards 0."""
    stage = open_stage()
    bar = UsdGeom.Cube.Define(stage, "/Bar")
    UsdPhysics.RigidBodyAPI.Apply(bar.GetPrim())
    joint = UsdPhysics.RevoluteJoint.Define(stage, "/Hinge")
    joint.CreateBody1Rel().SetTargets(["/Bar"])
    joint.CreateAxisAttr("Y")
    joint.CreateLocalPos1Attr((0, 0, 1))
    joint.CreateLocalPos0Attr((0, 0, 1))
    drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
    drive.CreateStiffnessAttr(1e4)
    drive.CreateDampingAttr(1e3)
    with App(stage, physics_hz=240, loop_hz=60) as app:
        yield app


def test_all_bodies_come_in_one_call(app):
    app.play()
    state = app.simulation.tensors
    assert state.body_paths == ("/World/Box", "/World/Ball", "/World/Lift")
    assert state.positions == pytest.approx(np.array([[0, 0, 0.5], [5, 0, 9], [-5, 0, 0.5]]))
    half = np.sqrt(0.5)
    assert state.orientations == pytest.approx(np.array([[1, 0, 0, 0], [half, 0, 0, half], [1, 0, 0, 0]]))
    assert state.linear_velocities == pytest.approx(np.array([[0, 0, 0], [1, 2, 3], [0, 0, 0]]))
    assert state.angular_velocities[1] == pytest.approx([0, 0, np.pi / 2])
    app.update(6)
    # 24 steps of dt: v = v0 - g n dt, z = z0 + v0 n dt - g dt^2 n (n + 1) / 2.
    assert state.linear_velocities[1] == pytest.approx([1, 2, 3 - 9.81 * 0.1])
    assert state.positions[1] == pytest.approx([5.1, 0.2, 9 + 0.3 - 9.81 / 240**2 * 24 * 25 / 2])


def test_arrays_are_copies_and_reading_changes_no_motion(app):
    app.play()
    app.update(10)
    state = app.simulation.tensors
    state.positions[:] = 0
    state.linear_velocities[:] = 0
    read = [state.positions, state.linear_velocities, state.contacts.impulses]
    app.update(20)
    there = app.physics.data.qpos.copy()
    app.reset()
    app.update(30)
    assert len(read) == 3
    assert np.array_equal(app.physics.data.qpos, there)


def test_while_stopped_everything_says_to_play_first(app):
    state = app.simulation.tensors
    assert app.simulation.get_physics_simulation_view() is None
    names = ("body_paths", "positions", "orientations", "linear_velocities", "angular_velocities", "joint_paths")
    names += ("joint_positions", "joint_velocities", "joint_efforts", "contacts")
    for name in names:
        with pytest.raises(RunError, match=r"call app.play\(\) first"):
            getattr(state, name)
    with pytest.raises(RunError, match=r"call app.play\(\) first"):
        state.set_poses([0, 0, 0])
    app.play()
    assert app.simulation.get_physics_simulation_view() is state
    assert len(state.positions) == 3
    app.stop()
    with pytest.raises(RunError, match=r"call app.play\(\) first"):
        _ = state.positions


def test_a_world_where_nothing_moves_has_empty_arrays():
    with App() as app:
        app.play()
        state = app.simulation.tensors
        assert (state.positions.shape, state.orientations.shape) == ((0, 3), (0, 4))
        assert (state.joint_positions.shape, state.contacts.pairs) == ((0,), ())
        with pytest.raises(RunError, match="nothing can move"):
            state.set_velocities([1, 0, 0])


def test_contacts_carry_the_weight(app):
    app.play()
    app.update(120)
    contacts = app.simulation.tensors.contacts
    below = [row for row, pair in enumerate(contacts.pairs) if set(pair) == {"/World/Ground", "/World/Box"}]
    assert len(below) == 4
    assert all("/World/Box" in contacts.bodies[row] and "" in contacts.bodies[row] for row in below)
    assert contacts.positions[below][:, 2] == pytest.approx(0, abs=1e-3)
    assert np.abs(contacts.positions[below][:, :2]) == pytest.approx(0.5, abs=1e-3)
    # Each is from the first to the second; turned so that the box is the second they hold its weight for a step.
    signs = np.array([1 if contacts.bodies[row][1] == "/World/Box" else -1 for row in below])[:, None]
    assert contacts.normals[below] * signs == pytest.approx(np.tile([0.0, 0, 1], (4, 1)), abs=1e-6)
    assert (contacts.impulses[below] * signs).sum(axis=0) == pytest.approx([0, 0, 2 * 9.81 / 240], abs=1e-4)


@pytest.mark.parametrize("fabric", ["on", "off"])
def test_bodies_are_placed_and_pushed(fabric):
    with App(physics_hz=240, loop_hz=60, fidelity={"fabric": fabric}) as app:
        app.add_prims(PRIMS)
        app.play()
        app.update(3)
        state = app.simulation.tensors
        state.set_poses([[1, 1, 5], [4, 4, 5]], [0, 0, 0, 2], bodies=["/World/Ball", "/World/Lift"])
        assert state.positions[1:].tolist() == [[1, 1, 5], [4, 4, 5]]
        assert state.orientations[1].tolist() == [0, 0, 0, 1]
        assert app.fabric.world_matrix("/World/Ball")[:3, 3].tolist() == [1, 1, 5]
        state.set_velocities(linear=[0, 0, 9.81], angular=[1, 2, 3], bodies="/World/Ball")
        assert state.linear_velocities[1] == pytest.approx([0, 0, 9.81])
        assert state.angular_velocities[1] == pytest.approx([1, 2, 3])
        app.update(60)
        assert state.positions[1, 2] == pytest.approx(5 + 9.81 - 9.81 / 240**2 * 240 * 241 / 2)
        assert state.positions[2].tolist() == [4, 4, 5]


def test_joints_are_read_placed_and_driven(pendulum):
    pendulum.play()
    state = pendulum.simulation.tensors
    assert state.joint_paths == ("/Hinge",)
    state.set_joint_positions([0.5])
    assert state.joint_positions.tolist() == [0.5]
    # The bar's origin is 1 m below the hinge: at an angle a about Y it stands at (-sin a, 0, 1 - cos a).
    assert state.positions[0] == pytest.approx([-np.sin(0.5), 0, 1 - np.cos(0.5)])
    state.set_joint_velocities([2.0], joints="/Hinge")
    assert state.joint_velocities.tolist() == [2.0]
    assert state.angular_velocities[0] == pytest.approx([0, 2, 0])
    state.set_joint_targets(positions=[0.25])
    pendulum.update(300)
    assert state.joint_positions[0] == pytest.approx(0.25, abs=0.01)
    # It holds 1 kg, 1 m from the hinge.
    assert abs(state.joint_efforts[0]) == pytest.approx(9.81 * np.sin(state.joint_positions[0]), rel=1e-3)


def test_what_cannot_be_set_is_reported_and_nothing_changes(app, pendulum):
    app.play()
    pendulum.play()
    with pytest.raises(RunError, match="/Bar: a joint holds this body"):
        pendulum.simulation.tensors.set_poses([0, 0, 3])
    with pytest.raises(RunError, match="/Bar: its velocity cannot be set: a joint holds it"):
        pendulum.simulation.tensors.set_velocities([0, 0, 3])
    state = app.simulation.tensors
    before = state.positions
    with pytest.raises(RunError, match="/World/Lift: its velocity cannot be set: it is kinematic"):
        state.set_velocities([0, 0, 3])
    with pytest.raises(RunError, match="/World/Nobody: there is no body that can move"):
        state.set_poses([0, 0, 3], bodies=["/World/Nobody"])
    with pytest.raises(RunError, match=r"/World/X\*: there is no body"):
        state.set_poses([0, 0, 3], bodies="/World/X*")
    with pytest.raises(ValueError, match=r"positions have shape \(2,\)"):
        state.set_poses([0, 3])
    with pytest.raises(ValueError, match="not finite"):
        state.set_poses([0, 3, np.nan])
    with pytest.raises(ValueError, match="quaternion of length 0"):
        state.set_poses(orientations=[0, 0, 0, 0])
    assert np.array_equal(state.positions, before)


def test_metres_and_kilograms_whatever_the_stage_is_in():
    stage = open_stage()
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    with App(stage, physics_hz=240) as app:
        app.add_prims({"/Box": {"type": "Cube", "size": 20, "translate": [0, 0, 300], "rigid_body": True}})
        app.play()
        state = app.simulation.tensors
        assert state.positions.tolist() == [[0, 0, 3]]
        state.set_poses([1, 2, 3])
        assert app.fabric.world_matrix("/Box")[:3, 3].tolist() == [100, 200, 300]


def floating(damping):
    damps = {"physxRigidBody:linearDamping": damping, "physxRigidBody:angularDamping": damping}
    cube = {"type": "Cube", "size": 1, "rigid_body": True, "mass": 2, "attributes": damps}
    return {
        "/World/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}},
        "/World/Box": cube,
        "/World/Other": {**cube, "translate": [5, 0, 0]},
    }


def test_another_mass_and_inertia_act_at_once_and_end_with_the_stop():
    with App(physics_hz=240, loop_hz=240) as app:
        app.add_prims(floating(0.0))
        app.play()
        app.update()
        state = app.simulation.tensors
        state.set_masses(masses=[8.0], inertias=[1.0, 2.0, 4.0], bodies="/World/Box")
        assert state.masses == pytest.approx([8.0, 2.0])
        assert state.inertias[0] == pytest.approx(np.diag([1.0, 2.0, 4.0]))
        state.set_forces([16.0, 0, 0], [1.0, 0, 0], bodies="/World/Box")
        state.set_forces([16.0, 0, 0], [1.0, 0, 0], bodies="/World/Other")
        app.update()
        # One step of 1/240 s: v = F t / m, w = M t / I; the other cube of 2 kg and 1 m has I = m / 6.
        assert state.linear_velocities[:, 0] == pytest.approx([2 / 240, 8 / 240])
        assert state.angular_velocities[:, 0] == pytest.approx([1 / 240, 3 / 240])
        app.stop()
        app.play()
        app.update()
        assert state.masses == pytest.approx([2.0, 2.0])


def test_damping_takes_the_same_share_of_the_momentum_of_another_mass():
    with App(physics_hz=240, loop_hz=240) as app:
        app.add_prims(floating(3.0))
        app.play()
        app.update()
        state = app.simulation.tensors
        state.set_masses(masses=[8.0], inertias=[1.0, 2.0, 4.0], bodies="/World/Box")
        state.set_velocities([1.0, 0, 0], [0, 0, 1.0])
        app.update(10)
        slowed, turning = state.linear_velocities[:, 0], state.angular_velocities[:, 2]
        assert slowed[0] == pytest.approx(slowed[1])
        assert turning[0] == pytest.approx(turning[1])
        assert slowed[0] < 0.95


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"masses": [0.0]}, "/World/Box: mass 0.0 is not positive"),
        ({"inertias": [1.0, -1.0, 1.0]}, "is not positive"),
    ],
)
def test_a_mass_that_is_not_positive_is_refused(given, message):
    with App() as app:
        app.add_prims(floating(0.0))
        app.play()
        app.update()
        with pytest.raises(RunError, match=message):
            app.simulation.tensors.set_masses(bodies="/World/Box", **given)
        assert app.simulation.tensors.masses == pytest.approx([2.0, 2.0])


def test_the_mass_of_a_jointed_body_stays_until_the_next_play(pendulum):
    pendulum.play()
    pendulum.update()
    with pytest.raises(RunError, match="only that of a free body can"):
        pendulum.simulation.tensors.set_masses(masses=[1.0])
