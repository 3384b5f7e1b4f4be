"""MuJoCo as the engine of a world: steps, poses, velocities, drives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.physics.articulation import Articulation
from graph.sim.physics.model import Joint, World
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .compile import Compiled
from .contacts import Contacts
from .deformables import Deformables
from .drives import Drives
from .grippers import SurfaceGripper
from .library import mujoco
from .motors import Motors
from .restitution import Bounces
from .snapshot import Motion, State, body_velocities
from .surfaces import Surfaces

if TYPE_CHECKING:
    from graph.sim.mjcf.flexes import Flexes

_BAD = tuple(
    int(kind)
    for kind in (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
)


class MujocoEngine:
    """The bodies of a playing world, metres and seconds. `body_paths` orders every array over bodies."""

    def __init__(self, compiled: Compiled, dt: Fraction, meters_per_unit: float = 1.0) -> None:
        self.meters_per_unit = meters_per_unit
        self.closed = False
        self.dt = dt
        self._articulations: dict[str, Articulation] = {}
        self._kept: list[Articulation] = []
        self.world: World | None = None
        """What the model was compiled from, and by what (`compile`); for compiling it anew (see `rebuild`)."""
        self.compile: Callable[[World, Fraction, Warn], Compiled] | None = None
        self._load(compiled)
        self._start(compiled)

    def _load(self, compiled: Compiled) -> None:
        self.compiled = compiled
        self.model = compiled.model
        self.data = mujoco.MjData(compiled.model)
        self.body_paths = tuple(body.path for body in compiled.bodies)
        self.kinematic = frozenset(compiled.kinematic)
        self.joints = compiled.joints
        self._index = {path: number for number, path in enumerate(self.body_paths)}
        self._counters = memoryview(self.data.warning.number)
        bodies = slice(1, 1 + len(self.body_paths))
        self._positions: Floats = self.data.xpos[bodies]
        self._quaternions: Floats = self.data.xquat[bodies]
        self._rotations: Floats = self.data.xmat[bodies].reshape(-1, 3, 3)
        self.motion = Motion(self.model, len(self.body_paths))
        self._surfaces: Surfaces | None = None
        self._stale = False
        self.taken = 0
        """How many steps the last call of `step` has done."""
        self.drives = Drives(self.model, self.joints)
        self._grippers = {spec.path: SurfaceGripper(self, spec) for spec in compiled.grippers}
        self._actuators = {joint.path: number for number, joint in enumerate(self.drives.joints)}
        self.contacts = Contacts(self.model, compiled.touches)
        self._bounces = Bounces(self.model, compiled.restitution) if compiled.restitution else None
        self.deformables: Deformables | Flexes = Deformables(self.model, compiled.softs)
        if compiled.flexes:
            from graph.sim.mjcf.flexes import Flexes

            self.deformables = Flexes(self, compiled.flexes, self.deformables)
        self._after_step = tuple(self._followers())
        self.motors = Motors(self) if self.model.nactuator > len(self.drives.joints) else None
        self.set_dt(self.dt)

    def adopt(self, compiled: Compiled, kept: frozenset[str] | None) -> None:
        """Go on with another model of the world: all that both have keeps its state, what is new starts as compiled.

        kept: bodies whose rest poses the new model did not change; None: nothing keeps its state. Articulations at hand
        stay valid.
        """
        from .state_transfer import Leaving

        leaving = Leaving(self) if kept is not None else None
        self._counters.release()
        self._load(compiled)
        self._start(compiled)
        if leaving is not None and kept is not None:
            leaving.arrive(self, kept)
        for articulation in (*self._articulations.values(), *self._kept):
            articulation.bind()

    def step(self, count: int = 1) -> None:
        """Advance by `count` times dt; `taken` says by how many afterwards.

        Raises RunError if the simulation has diverged, naming the body. Between steps there is as little Python as can
        be: what it drives out of the processor's caches costs the next step as much again.
        """
        model, data, counters, advance = self.model, self.data, self._counters, mujoco.mj_step
        limit = self.drives.limit_forces if self.drives.limited else None
        self._stale = True
        self.taken = 0
        for self.taken in range(1, count + 1):
            if limit is not None:
                limit(data)
            if self._surfaces is None:
                advance(model, data)
            else:
                self._surfaces.step(data)
            if counters[3] or counters[4] or counters[5]:
                self.taken -= 1
                raise RunError(self._divergence())
            for follow in self._after_step:
                follow(data)

    def _followers(self) -> Iterator[Callable[[Any], None]]:
        """What has to look at the world after each step."""
        if self._bounces is not None:
            yield self._bounces.step
        if self.contacts.switching:
            yield self.contacts.step
        for gripper in self._grippers.values():
            yield gripper.step

    @property
    def surfaces(self) -> Surfaces:
        """Surfaces that move by themselves, such as belts."""
        if self._surfaces is None:
            self._surfaces = Surfaces(self)
        return self._surfaces

    @property
    def positions(self) -> Floats:
        """(B, 3) origins of the bodies in the world [m]; a live view of the engine's memory."""
        if self._stale:
            self._refresh()
        return self._positions

    @property
    def quaternions(self) -> Floats:
        """(B, 4) w, x, y, z of the bodies in the world; a live view of the engine's memory."""
        if self._stale:
            self._refresh()
        return self._quaternions

    @property
    def rotations(self) -> Floats:
        """(B, 3, 3) of the bodies in the world; a live view of the engine's memory."""
        if self._stale:
            self._refresh()
        return self._rotations

    def velocities(self) -> Floats:
        """(B, 6) of each body's origin, now: linear [m/s], then angular [rad/s], both along world axes."""
        return body_velocities(self.model, self.data, len(self.body_paths))

    def state(self) -> State:
        """A copy of what the poses and velocities of all bodies follow from."""
        data = self.data
        return data.qpos.copy(), data.qvel.copy(), data.mocap_pos.copy(), data.mocap_quat.copy()

    def set_dt(self, dt: Fraction) -> None:
        """Change the time step [s]; the drives keep their meaning."""
        self.dt = dt
        self.model.opt.timestep = float(dt)
        self.drives.set_dt(float(dt))
        self.contacts.set_dt(float(dt))

    def can_place(self, path: str) -> bool:
        """Whether a body can be put somewhere: it is free or kinematic."""
        body = self._index[path] + 1
        return bool(self.model.body_mocapid[body] >= 0 or self.is_free(body))

    def set_pose(self, path: str, pose: Floats) -> None:
        """Put a free or kinematic body at a rigid (4, 4) world pose [m]. Raises RunError for one held by a joint."""
        body = self._index[path] + 1
        quaternion = transforms.quaternion(pose[:3, :3])
        mocap = self.model.body_mocapid[body]
        if mocap >= 0:
            self.data.mocap_pos[mocap], self.data.mocap_quat[mocap] = pose[:3, 3], quaternion
        elif self.is_free(body):
            address = self.model.jnt_qposadr[self.model.body_jntadr[body]]
            self.data.qpos[address : address + 7] = [*pose[:3, 3], *quaternion]
        else:
            raise RunError(f"{path}: a joint holds this body; set the joint's position instead of its pose.")
        self._stale = True

    def center_of_mass(self, path: str) -> Floats:
        """(3,) where a body's centre of mass is in the world [m]."""
        body = self._index[path]
        out: Floats = self.positions[body] + self.rotations[body] @ self.model.body_ipos[body + 1]
        return out

    def set_velocity(self, path: str, velocity: Floats) -> None:
        """Set the velocity of a free body's origin: (6,) [m/s], [rad/s], world axes. Raises RunError for another."""
        body = self._index[path] + 1
        if not self.is_free(body):
            held = "it is kinematic" if path in self.kinematic else "a joint holds it; set the joint's velocity instead"
            raise RunError(f"{path}: its velocity cannot be set: {held}.")
        address = self.model.jnt_dofadr[self.model.body_jntadr[body]]
        turn = self.rotations[body - 1]
        self.data.qvel[address : address + 3] = velocity[:3]
        self.data.qvel[address + 3 : address + 6] = turn.T @ velocity[3:]

    def keep(self, articulation: Articulation) -> None:
        """Have an articulation of somebody's own find its joints anew when the model is compiled anew."""
        self._kept.append(articulation)

    def moved(self) -> None:
        """Coordinates were written: where the bodies are follows from them anew."""
        self._stale = True

    def articulation(self, root: str) -> Articulation:
        """The mechanism at a path: a robot's root prim, or any body or joint of it. RunError if there is none."""
        if root not in self._articulations:
            found = Articulation(self, root, self.meters_per_unit)
            if not found.joint_paths:
                raise RunError(f"{root}: no revolute or prismatic joint is there.")
            self._articulations[root] = found
        return self._articulations[root]

    def gripper(self, path: str) -> SurfaceGripper:
        """The surface gripper at a path. RunError if there is none."""
        if path not in self._grippers:
            raise RunError(f"{path}: no surface gripper is there; it is a prim of type IsaacSurfaceGripper.")
        return self._grippers[path]

    def close(self) -> None:
        """Free the engine's memory; nothing may be asked of it afterwards."""
        self._positions, self._quaternions = self._positions.copy(), self._quaternions.copy()
        self._rotations, self._surfaces = self._rotations.copy(), None
        self.motion.close()
        self._counters.release()
        self.closed = True
        del self.data, self.model

    def _refresh(self) -> None:
        # mj_step leaves the poses of the state it started from; those of the new state are the kinematics of qpos.
        mujoco.mj_kinematics(self.model, self.data)
        self._stale = False

    def is_free(self, body: int) -> bool:
        """Whether nothing holds the model's body of that number."""
        joint = self.model.body_jntadr[body]
        return bool(joint >= 0 and self.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE)

    def _start(self, compiled: Compiled) -> None:
        """Initial velocities and drive targets, and everything that follows from them."""
        if compiled.start is not None:
            compiled.start(self.model, self.data)
        mujoco.mj_kinematics(self.model, self.data)
        velocities: dict[str, tuple[Floats, Floats]] = {}
        for number, body in enumerate(compiled.bodies, start=1):
            if not (body.velocity.any() or body.angular_velocity.any()) or body.kinematic:
                continue
            velocities[body.path] = body.velocity, body.angular_velocity
            if self.is_free(number):
                turn = self.data.xmat[number].reshape(3, 3)
                arm = self.data.xipos[number] - self.data.xpos[number]
                address = self.model.jnt_dofadr[self.model.body_jntadr[number]]
                self.data.qvel[address : address + 3] = body.velocity - np.cross(body.angular_velocity, arm)
                self.data.qvel[address + 3 : address + 6] = turn.T @ body.angular_velocity
        for joint in self.joints:
            self._start_joint(joint, velocities)
        self.deformables.start(self.data)
        self.drives.apply(self.data)
        mujoco.mj_forward(self.model, self.data)

    def _start_joint(self, joint: Joint, velocities: dict[str, tuple[Floats, Floats]]) -> None:
        """As the bodies move relative to each other; a centre of mass that moves otherwise turns them besides."""
        first, second = joint.bodies
        if joint.kind == "fixed" or second not in velocities:
            return
        rest = np.zeros(3), np.zeros(3)
        v1, w1 = velocities[second]
        v0, w0 = velocities.get(first or "", rest)
        joint_number, body = self.model.joint(joint.model_name).id, self._index[second] + 1
        address = self.model.jnt_dofadr[joint_number]
        turn = self.data.xmat[body].reshape(3, 3)
        axis = turn @ joint.frames[1][:3, joint.axis]
        if joint.kind == "prismatic":
            self.data.qvel[address] = axis @ (v1 - v0)
            return
        arm = self.data.xipos[body] - self.data.xanchor[joint_number]
        spin = w1 - w0
        if first not in velocities and v1.any():  # of a pair that flies, the common motion is not the joint's
            missing = v1 - np.cross(w1, arm)
            across = arm if joint.kind == "spherical" else arm - axis * (axis @ arm)
            if across @ across > 1e-12:
                spin = spin + np.cross(across, missing) / (across @ across)
        if joint.kind == "spherical":
            self.data.qvel[address : address + 3] = turn.T @ spin
        else:
            self.data.qvel[address] = axis @ spin

    def dof(self, joint: Joint) -> int:
        """Which coordinate of velocity a joint has."""
        return int(self.model.joint(joint.model_name).dofadr[0])

    def qpos_address(self, joint: Joint) -> int:
        """Which coordinate of position a joint has."""
        return int(self.model.joint(joint.model_name).qposadr[0])

    def actuator(self, joint: Joint) -> int | None:
        """Which actuator drives a joint, if one does."""
        return self._actuators.get(joint.path)

    def _divergence(self) -> str:
        kind = next(kind for kind in _BAD if self._counters[kind])
        place = int(self.data.warning[kind].lastinfo)
        if kind == _BAD[0]:
            joint = int(np.searchsorted(self.model.jnt_qposadr, place, side="right")) - 1
            body = int(self.model.jnt_bodyid[joint])
        else:
            body = int(self.model.dof_bodyid[place])
        name = (
            self.body_paths[body - 1] if body <= len(self.body_paths) else self.model.body(body).name.partition("#")[0]
        )
        return (
            f"{name}: the simulation diverged here, at {float(self.data.time):.6g} s of physics. "
            "Raise physics_hz, lower the stiffness, speeds or mass ratios around it, or move apart what overlaps."
        )
