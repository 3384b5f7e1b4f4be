"""MuJoCo as the engine of a world: steps, poses, velocities, joints, contacts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.physics.protocol import Snapshot
from graph.sim.physics.world_model import BodyForce, WorldModel
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .body_forces import BodyForces
from .compile import Compiled
from .contacts import Contacts
from .deformables import Deformables, Flexes
from .drives import Drives
from .grippers import WeldGripper
from .joints import EngineJoints
from .library import mujoco, state_of
from .monitor import Monitor
from .motors import Motors
from .queries import EngineQueries
from .restitution import Bounces
from .speed_limits import SpeedLimits
from .state import Motion, MujocoSnapshot, set_initial_state
from .step_size import check_drives
from .substeps import Substeps
from .surfaces import Surfaces

Compile = Callable[[WorldModel, Fraction, Warn], Compiled]
"""Makes the model of a world, with this time step."""


class MujocoEngine(EngineJoints, EngineQueries):
    """The bodies of a playing world.

    `model` and `data` are MuJoCo's own; only this package and wings read them. Bodies are numbered from 1 in
    the model, in the order of `body_paths`. Methods of the protocol are documented there.
    """

    name = "mujoco"

    def __init__(self, world: WorldModel, dt: Fraction, meters_per_unit: float, compiler: Compile, warn: Warn) -> None:
        self.meters_per_unit = meters_per_unit
        self.closed = False
        self.dt = dt
        self._compile = compiler
        self.world = world
        self._load(compiler(world, dt, warn), warn)
        set_initial_state(self)

    def _load(self, compiled: Compiled, warn: Warn) -> None:
        self.compiled = compiled
        self.model = compiled.model
        self.data = state_of(compiled.model)
        self.body_paths = tuple(body.path for body in compiled.bodies)
        self.kinematic = frozenset(compiled.kinematic)
        self.joints = compiled.joints
        self._index = {path: number for number, path in enumerate(self.body_paths)}
        self._counters = memoryview(self.data.warning.number)
        self._warn = warn
        bodies = slice(1, 1 + len(self.body_paths))
        self._positions: Floats = self.data.xpos[bodies]
        self._quaternions: Floats = self.data.xquat[bodies]
        self._rotations: Floats = self.data.xmat[bodies].reshape(-1, 3, 3)
        self._motion = Motion(self.model, len(self.body_paths))
        self._surfaces: Surfaces | None = None
        for of_the_last_model in ("_places", "_elsewhere", "colliders", "_boxes", "_spheres"):
            vars(self).pop(of_the_last_model, None)
        self._stale = False
        self.taken = 0
        self.drives = Drives(self.model, self.joints)
        self._grippers = {spec.path: WeldGripper(self, spec) for spec in compiled.grippers}
        self.friction = Contacts(self.model, compiled.touches)
        self._bounces = Bounces(self.model, compiled.restitution) if compiled.restitution else None
        self.deformables: Deformables | Flexes = Deformables(self.model, compiled.softs)
        if compiled.flexes:
            self.deformables = Flexes(self, compiled.flexes, self.deformables)
        self._speeds = SpeedLimits(self.model, compiled)
        numbers = {path: number + 1 for path, number in self._index.items()}
        self.forces = BodyForces(self.model, self.data, numbers, self.world.forces)
        self._after_step = tuple(self._followers())
        substeps = Substeps(self, warn) if compiled.divides else None
        self._substeps = substeps or None
        self._monitor = Monitor(self, warn)
        self.motors = Motors(self) if self.model.nactuator > len(self.drives.joints) else None
        self.set_dt(self.dt)

    def adopt(self, world: WorldModel, kept: frozenset[str] | None, warn: Warn) -> None:
        """Continues with another world, see `PhysicsEngine`."""
        from .state import Leaving

        compiled = self._compile(world, self.dt, warn)
        leaving = Leaving(self) if kept is not None else None
        self._counters.release()
        self._monitor.close()
        self.world = world
        self._load(compiled, warn)
        set_initial_state(self)
        if leaving is not None and kept is not None:
            leaving.arrive(self, kept)

    def facts(self) -> dict[str, Any]:
        """Its options and what follows from them, see `PhysicsEngine.facts`."""
        from .advice import facts

        return facts(self)

    # -- stepping ----------------------------------------------------------------------------------------------------

    def step(self, count: int = 1) -> None:
        """Advances by `count` times dt; `taken` gives the number of steps afterwards.

        Raises RunError, with the body's name, if the simulation has diverged. There is as little Python as possible
        between steps: what it drives out of the processor's caches makes the next step twice as expensive.
        """
        monitor = self._monitor
        self._stale = True
        self.taken = 0
        try:
            while self.taken < count:
                steps = min(count - self.taken, monitor.until_look())
                self._advance(steps)
                monitor.stepped(steps)
        except mujoco.FatalError as error:
            self.taken -= 1
            raise RunError(f"physics: MuJoCo gave up: {' '.join(str(error).split()).rstrip('.')}") from error

    def _advance(self, steps: int) -> None:
        """Makes so many steps and counts them in `taken`. Raises RunError as `step` does."""
        model, data, counters, divided = self.model, self.data, self._counters, self._substeps
        advance = mujoco.mj_step if self._surfaces is None else self._surfaces.step
        check_positions, check_velocities = mujoco.mj_checkPos, mujoco.mj_checkVel
        limit, first = self.drives.limit_forces if self.drives.limited else None, self.taken + 1
        monitor, after = self._monitor, self._after_step

        def make() -> bool:
            """A step, or a part of one; returns whether the state is finite."""
            if limit is not None:
                limit(data)
            advance(model, data)
            # MuJoCo looks at a state when the next step begins, which may be another update.
            check_positions(model, data)
            check_velocities(model, data)
            return not (counters[3] or counters[4] or counters[5])

        def follow() -> None:
            """What comes after it."""
            if monitor.spent in monitor.iterations.tobytes():
                monitor.check_solver()
            for each in after:
                each(data)

        iterations = monitor.iterations
        for self.taken in range(first, first + steps):
            if divided is not None:
                finite = divided.step(make, follow)
            else:  # both written out: between steps each call costs several times as much as elsewhere
                if limit is not None:
                    limit(data)
                advance(model, data)
                check_positions(model, data)
                check_velocities(model, data)
                finite = not (counters[3] or counters[4] or counters[5])
                if finite and monitor.spent in iterations.tobytes():
                    monitor.check_solver()
                if finite and after:
                    for each in after:
                        each(data)
            if not finite:
                self.taken -= 1
                raise RunError(monitor.divergence())

    def _followers(self) -> Iterator[Callable[[Any], None]]:
        """The parts that must examine the world after each step."""
        if self._bounces is not None:
            yield self._bounces.step
        if self.friction.switching:
            yield self.friction.step
        if self._speeds.limited:
            yield self._speeds.step
        if self.forces.turning:
            yield self.forces.step
        for gripper in self._grippers.values():
            yield gripper.step

    def set_dt(self, dt: Fraction) -> None:
        """Changes the time step [s]; the drives keep their behaviour."""
        self.dt = dt
        self.model.opt.timestep = float(dt)
        self.drives.set_dt(float(dt))
        check_drives(self, self._warn)
        self.friction.set_dt(float(dt))

    @property
    def divides(self) -> bool:
        """Whether its steps are divided where chains or loops need it."""
        return self._substeps is not None

    @property
    def chains(self) -> Sequence[int]:
        """The trees of the model that are stepped as passive chains."""
        return () if self._substeps is None else [int(tree) for tree in self._substeps.chains]

    @property
    def gravity(self) -> Floats:
        """(3,) [m/s2]."""
        return np.array(self.model.opt.gravity)

    def set_gravity(self, gravity: Sequence[float] | Floats) -> None:
        """Change gravity [m/s2]."""
        self.model.opt.gravity[:] = gravity

    # -- bodies ------------------------------------------------------------------------------------------------------

    @property
    def positions(self) -> Floats:
        """(B, 3) origins of the bodies in the world [m]; a live view of the engine's memory."""
        self.place_geoms()
        return self._positions

    @property
    def quaternions(self) -> Floats:
        """(B, 4) w, x, y, z of the bodies in the world; a live view of the engine's memory."""
        self.place_geoms()
        return self._quaternions

    @property
    def rotations(self) -> Floats:
        """(B, 3, 3) of the bodies in the world; a live view of the engine's memory."""
        self.place_geoms()
        return self._rotations

    def place_geoms(self) -> None:
        """Brings bodies and geoms to the present state: mj_step leaves the poses of the state it started from."""
        if self._stale:
            mujoco.mj_kinematics(self.model, self.data)
            self._stale = False

    @property
    def masses(self) -> Floats:
        """(B,) [kg]."""
        return np.array(self.model.body_mass[1 : 1 + len(self.body_paths)])

    def set_masses(self, paths: Sequence[str], masses: Floats | None, diagonals: Floats | None) -> None:
        """Masses [kg] and moments of inertia [kg m2] of free bodies; see `PhysicsEngine`."""
        from .body_forces import set_masses

        set_masses(self, paths, masses, diagonals)
        self.forces.set_authored(self.world.forces)

    @property
    def inertias(self) -> Floats:
        """(B, 3, 3) about the centres of mass, along the bodies' axes [kg m2]."""
        bodies = slice(1, 1 + len(self.body_paths))
        axes = transforms.rotation_matrices(self.model.body_iquat[bodies])
        out: Floats = np.einsum("bij,bj,bkj->bik", axes, self.model.body_inertia[bodies], axes)
        return out

    @property
    def centers_of_mass(self) -> Floats:
        """(B, 3) in the world [m]."""
        local = self.model.body_ipos[1 : 1 + len(self.body_paths)]
        out: Floats = self.positions + np.einsum("bij,bj->bi", self.rotations, local)
        return out

    def number(self, path: str) -> int:
        """The model's number of a body."""
        return self._index[path] + 1

    def body_name(self, number: int) -> str:
        """A body of the model as messages name it: its path, or its name if it is not on the stage."""
        if number <= len(self.body_paths):
            return self.body_paths[number - 1]
        return str(self.model.body(number).name.partition("#")[0])

    def is_free(self, path: str) -> bool:
        """Whether neither a joint nor the user holds a body."""
        joint = self.model.body_jntadr[self.number(path)]
        return bool(joint >= 0 and self.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE)

    def can_place(self, path: str) -> bool:
        """Whether a body is free, or moved only by users."""
        return bool(self.model.body_mocapid[self.number(path)] >= 0) or self.is_free(path)

    def set_poses(self, paths: Sequence[str], poses: Floats, velocities: Floats | None = None) -> None:
        """Puts free or kinematic bodies at rigid poses (n, 4, 4) [m], in motion or at rest; see `PhysicsEngine`."""
        model, data = self.model, self.data
        if self._surfaces is not None or (velocities is not None and velocities.any()):
            self.surfaces.set_velocities([self.number(path) for path in paths], velocities)
        for path, pose in zip(paths, poses, strict=True):
            body = self.number(path)
            quaternion = transforms.quaternion(pose[:3, :3])
            mocap = model.body_mocapid[body]
            if mocap >= 0:
                data.mocap_pos[mocap], data.mocap_quat[mocap] = pose[:3, 3], quaternion
            elif self.is_free(path):
                address = model.jnt_qposadr[model.body_jntadr[body]]
                data.qpos[address : address + 7] = [*pose[:3, 3], *quaternion]
            else:
                raise RunError(f"{path}: a joint holds this body; set the joint's position instead of its pose")
            self._stale = True

    def set_velocities(self, paths: Sequence[str], velocities: Floats) -> None:
        """Set (n, 6) of free bodies' origins [m/s], [rad/s]."""
        for path, velocity in zip(paths, velocities, strict=True):
            if not self.is_free(path):
                held = "a joint holds it; set the joint's velocity instead"
                why = "it is kinematic" if path in self.kinematic else held
                raise RunError(f"{path}: its velocity cannot be set: {why}")
            body = self.number(path)
            address = self.model.jnt_dofadr[self.model.body_jntadr[body]]
            turn = self.rotations[body - 1]
            self.data.qvel[address : address + 3] = velocity[:3]
            self.data.qvel[address + 3 : address + 6] = turn.T @ velocity[3:]

    def set_forces(self, paths: Sequence[str], forces: Floats) -> None:
        """Applies (n, 6) forces at the centres of mass [N] and torques [N m] to bodies."""
        self.forces.set_own([self.number(path) for path in paths], forces)

    def set_authored_forces(self, forces: Sequence[BodyForce]) -> None:
        """Replaces the forces of the stage."""
        self.world = replace(self.world, forces=tuple(forces))
        self.forces.set_authored(forces)
        self._after_step = tuple(self._followers())

    # -- grippers, belts, deformables --------------------------------------------------------------------------------

    def gripper(self, path: str) -> WeldGripper:
        """The surface gripper at a path. Raises RunError if the path has no gripper."""
        if path not in self._grippers:
            raise RunError(f"{path}: no surface gripper is there; it is a prim of type IsaacSurfaceGripper")
        return self._grippers[path]

    @property
    def surfaces(self) -> Surfaces:
        """Moving surfaces, such as belts."""
        if self._surfaces is None:
            self._surfaces = Surfaces(self, self._warn)
            self.friction.surfaces = self._surfaces
            if self._bounces is not None:
                self._bounces.surfaces = self._surfaces
        return self._surfaces

    def set_surface_velocity(self, path: str, pose: Floats, velocity: Floats, turn: Floats) -> bool:
        """Moves surfaces whose body stays, see `PhysicsEngine`."""
        return self.surfaces.set_motion(path, pose, velocity, turn)

    @property
    def deformable_paths(self) -> tuple[str, ...]:
        """The prims that deform."""
        return self.deformables.paths

    def deformable_start(self, path: str) -> Floats:
        """(p, 3) initial positions of a deformable prim's points [m]."""
        return self.deformables.start_points(path)

    # -- state -------------------------------------------------------------------------------------------------------

    def snapshot(self) -> MujocoSnapshot:
        """The present positions and velocities."""
        return MujocoSnapshot(self.data, self._motion, self.deformables)

    def restore(self, snapshot: Snapshot) -> None:
        """Restores the positions and velocities of a snapshot."""
        if not isinstance(snapshot, MujocoSnapshot) or snapshot.motion is not self._motion:
            raise RunError("this snapshot is of another world; take one after the last play or recompilation")
        data = self.data
        data.qpos[:], data.qvel[:], data.mocap_pos[:], data.mocap_quat[:] = snapshot.state
        self._stale = True

    def close(self) -> None:
        """Free the engine's memory."""
        self._motion.close()
        self._counters.release()
        self._monitor.close()
        vars(self).clear()  # several parts refer to the engine: this frees its memory now, not at the next collection
        self.closed = True
