"""A second engine behind the protocol: an App runs on an engine written here in full."""

import numpy as np
import pytest

from graph.base.errors import RunError, UserError
from graph.sim import App, transforms
from graph.sim.physics.protocol import PhysicsEngine, Snapshot
from tests.support.lidar_worlds import add_lidar, stare


class Moment(Snapshot):
    def __init__(self, positions, velocities):
        self.positions, self._velocities = positions.copy(), velocities.copy()

    def velocities(self):
        return self._velocities

    def points(self, path):
        return None


class ConstantVelocity(PhysicsEngine):
    """Bodies move on at the velocities that the stage gives them; nothing turns, nothing collides."""

    name = "constant-velocity"

    def __init__(self, world, dt, *, meters_per_unit, fidelity, warn, mjcf):
        self.dt, self.meters_per_unit = dt, meters_per_unit
        self.closed = False
        self.adopt(world, None, warn)

    def adopt(self, world, kept, warn):
        before = dict(zip(self.body_paths, self._positions, strict=True)) if kept is not None else {}
        self.world, self.taken = world, 0
        self.body_paths = tuple(body.path for body in world.bodies)
        self.kinematic = frozenset(body.path for body in world.bodies if body.kinematic)
        self._positions = np.array([before.get(body.path, body.pose[:3, 3]) for body in world.bodies])
        self._turns = np.array([transforms.quaternion(body.pose[:3, :3]) for body in world.bodies])
        self._velocities = np.array([[*body.velocity, 0, 0, 0] for body in world.bodies], dtype=float)
        self._forces = np.zeros((len(world.bodies), 6))

    def step(self, count=1):
        for self.taken in range(1, count + 1):
            self._velocities += self._forces * float(self.dt)
            self._positions += self._velocities[:, :3] * float(self.dt)

    def set_dt(self, dt):
        self.dt = dt

    @property
    def gravity(self):
        return np.zeros(3)

    def set_gravity(self, gravity):
        """Ignores it: the engine has no gravity."""

    @property
    def positions(self):
        return self._positions

    @property
    def quaternions(self):
        return self._turns

    @property
    def masses(self):
        return np.ones(len(self.body_paths))

    @property
    def inertias(self):
        return np.tile(np.eye(3), (len(self.body_paths), 1, 1))

    @property
    def centers_of_mass(self):
        return self._positions.copy()

    def is_free(self, path):
        return path not in self.kinematic

    def _rows(self, paths):
        return [self.body_paths.index(path) for path in paths]

    def set_poses(self, paths, poses, velocities=None):
        self._positions[self._rows(paths)] = poses[:, :3, 3]

    def set_velocities(self, paths, velocities):
        self._velocities[self._rows(paths)] = velocities

    def set_forces(self, paths, forces):
        self._forces[self._rows(paths)] = forces

    def snapshot(self):
        return Moment(self._positions, self._velocities)

    def restore(self, snapshot):
        self._positions[:], self._velocities[:] = snapshot.positions, snapshot.velocities()

    def close(self):
        self.closed = True


BOX = {
    "/World/Box": {
        "type": "Cube",
        "size": 1.0,
        "translate": [5, 0, 0],
        "rigid_body": True,
        "velocity": [1.0, 0, 0],
        "mass": 2.0,
    }
}


@pytest.fixture
def app():
    with App(physics_hz=240, loop_hz=60, physics=ConstantVelocity) as app:
        app.add_prims(BOX)
        yield app


def test_play_updates_and_stop_run_on_another_engine(app):
    before = app.stage.GetRootLayer().ExportToString()
    app.play()
    engine = app.physics
    assert isinstance(engine, ConstantVelocity)
    assert app.simulation.get_active_physics_engine() == "constant-velocity"
    app.update(steps=60)
    # 1 m/s for 240 steps of 1/240 s
    assert app.simulation.get_num_physics_steps() == 240
    assert app.fabric.world_matrix("/World/Box")[:3, 3] == pytest.approx([6, 0, 0])
    assert app.fabric.velocities(["/World/Box"])[0].tolist() == [1, 0, 0, 0, 0, 0]
    app.stop()
    assert engine.closed
    assert app.physics is None
    assert app.stage.GetRootLayer().ExportToString() == before
    assert app.fabric.world_matrix("/World/Box")[:3, 3].tolist() == [5, 0, 0]


def test_a_frozen_lidar_sees_the_body_where_the_engine_has_it(app):
    product = add_lidar(app, config=stare([0.0]), tick_rate=10)
    app.play()
    found = []
    while len(found) < 3:
        app.update()
        if product.new_frame:
            found.append(float(product.frame.channel("distance")[0]))
    # The scan of tick k is cast at k / 10 s: the near face is then at 4.5 m + 1 m/s k / 10 s.
    assert found == pytest.approx([4.6, 4.7, 4.8], abs=1e-5)


def test_tensors_read_and_write_another_engine(app):
    app.play()
    tensors = app.simulation.tensors
    assert tensors.body_paths == ("/World/Box",)
    assert tensors.joint_paths == ()
    assert tensors.contacts.pairs == ()
    saved = tensors.snapshot()
    tensors.set_velocities(linear=[0, 2, 0])
    tensors.set_poses(positions=[0, 0, 1])
    app.simulation.step(steps=120)  # half a second
    assert tensors.positions == pytest.approx(np.array([[0, 1, 1]]))
    tensors.restore(saved)
    assert tensors.positions.tolist() == [[5, 0, 0]]
    assert tensors.linear_velocities.tolist() == [[1, 0, 0]]


def test_editing_and_resetting_while_playing_work_on_another_engine(app):
    app.play()
    app.update(steps=60)
    app.add_prims({"/World/Other": {**BOX["/World/Box"], "translate": [0, 9, 0]}}, when_playing="recompile")
    app.update(steps=60)
    positions = dict(zip(app.physics.body_paths, app.physics.positions.tolist(), strict=True))
    assert positions["/World/Box"] == pytest.approx([7, 0, 0])
    assert positions["/World/Other"] == pytest.approx([1, 9, 0])
    app.reset("state")
    assert app.fabric.world_matrix("/World/Box")[:3, 3] == pytest.approx([5, 0, 0])


def test_what_an_engine_does_not_offer_is_an_error_that_names_it(app):
    app.play()
    with pytest.raises(RunError, match="/World/Box: no revolute or prismatic joint is there"):
        app.physics.articulation("/World/Box")
    with pytest.raises(RunError, match="the physics engine constant-velocity has no surface grippers"):
        app.physics.gripper("/World/Box")
    with pytest.raises(RunError, match="the physics engine constant-velocity has no moving surfaces"):
        app.physics.set_surface_velocity("/World/Box", np.eye(4), np.ones(3), np.zeros(3))


def test_an_mjcf_model_is_refused_by_another_engine(tmp_path):
    file = tmp_path / "ball.xml"
    file.write_text("<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>")
    with pytest.raises(UserError, match="constant-velocity does not simulate MJCF models"):
        App(mjcf=file, physics=ConstantVelocity)


# -- the same calls on both engines ------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [{}, {"physics": ConstantVelocity}], ids=["mujoco", "constant-velocity"])
def test_every_engine_gives_arrays_of_the_protocols_shapes(options):
    scene = {"/World/Physics": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}}
    with App(physics_hz=240, **options) as app:
        app.add_prims({**scene, **BOX})
        app.play()
        engine = app.physics
        assert engine.gravity.tolist() == [0, 0, 0]
        assert engine.positions.shape == (1, 3)
        assert engine.quaternions.shape == (1, 4)
        assert engine.rotations.shape == engine.inertias.shape == (1, 3, 3)
        assert engine.velocities().shape == (1, 6)
        assert engine.masses.shape == (1,)
        assert engine.is_free("/World/Box")
        assert engine.can_place("/World/Box")
        before = engine.snapshot()
        engine.step(3)
        assert engine.taken == 3
        assert engine.positions[0, 0] == pytest.approx(5 + 3 / 240)
        engine.restore(before)
        assert engine.positions[0, 0] == pytest.approx(5)
        engine.step()
        assert engine.positions[0, 0] == pytest.approx(5 + 1 / 240)


def test_forces_accelerate_a_body_by_its_mass_until_they_are_set_again():
    """a = F / m = 3 m/s2; semi-implicit Euler from rest: v = a n dt exactly, x = a dt2 n (n + 1) / 2."""
    ball = {"/World/Ball": {"type": "Sphere", "radius": 0.5, "rigid_body": True, "mass": 2.0}}
    scene = {"/World/Physics": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}}
    with App(physics_hz=100) as app:
        app.add_prims({**scene, **ball})
        app.play()
        tensors = app.simulation.tensors
        assert tensors.masses.tolist() == [2.0]
        # a solid sphere: 2/5 m r2 = 0.2
        assert tensors.inertias[0] == pytest.approx(0.2 * np.eye(3))
        tensors.set_forces([6.0, 0, 0], [0, 0, 0.4])
        app.simulation.step(steps=50)
        assert tensors.linear_velocities[0] == pytest.approx([1.5, 0, 0])
        assert tensors.centers_of_mass[0] == pytest.approx([3 * 1e-4 * 50 * 51 / 2, 0, 0])
        assert tensors.angular_velocities[0] == pytest.approx([0, 0, 0.4 / 0.2 * 0.5])
        tensors.set_forces()
        app.simulation.step(steps=50)
        assert tensors.linear_velocities[0] == pytest.approx([1.5, 0, 0])


def test_a_snapshot_of_another_play_is_refused():
    with App() as app:
        app.add_prims(BOX)
        app.play()
        old = app.simulation.tensors.snapshot()
        app.stop()
        app.play()
        with pytest.raises(RunError, match="this snapshot is of another world"):
            app.simulation.tensors.restore(old)
