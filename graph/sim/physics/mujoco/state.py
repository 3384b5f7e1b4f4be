"""The state of a model: its initial one, copies of it at one moment, and its transfer, by path, to the next model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.physics.protocol import Snapshot
from graph.sim.physics.world_model import Joint
from graph.sim.transforms import Floats

from .deformables import Deformables
from .library import WIDTHS, forward, mujoco, state_of

if TYPE_CHECKING:
    from .engine import MujocoEngine

MOMENT_S = 1e-6
"""Over so long points move along straight lines: what a difference of positions rounds to is below 1e-8 m/s."""

State = tuple[Floats, Floats, Floats, Floats]
"""Coordinates, their velocities, and positions and quaternions of kinematic bodies."""


def body_velocities(model: Any, data: Any, count: int) -> Floats:
    """(B, 6) of the origins of the first `count` bodies: linear [m/s], then angular [rad/s], both along world axes."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_comVel(model, data)
    bodies = slice(1, 1 + count)
    angular, linear = data.cvel[bodies, :3], data.cvel[bodies, 3:]
    arm = data.xpos[bodies] - data.subtree_com[model.body_rootid[bodies]]
    return np.concatenate([linear + np.cross(angular, arm), angular], axis=1)


class Motion:
    """Computes velocities in copied states of one model, with a second set of the engine's data."""

    def __init__(self, model: Any, count: int) -> None:
        self._model: Any = model
        self._count = count
        self._data: Any = None

    def velocities(self, state: State) -> Floats:
        """(B, 6) in a copied state (see `body_velocities`); zeros once the model is freed."""
        if self._model is None:
            return np.zeros((self._count, 6))
        if self._data is None:
            self._data = state_of(self._model)
        data = self._data
        data.qpos[:], data.qvel[:], data.mocap_pos[:], data.mocap_quat[:] = state
        return body_velocities(self._model, data, self._count)

    def later(self, state: State, duration: float) -> Floats | None:
        """(nq,) the coordinates after a duration [s] at a state's velocities; None once the model is freed."""
        if self._model is None:
            return None
        coordinates = state[0].copy()
        mujoco.mj_integratePos(self._model, coordinates, state[1], duration)
        return coordinates

    def close(self) -> None:
        """Free the model."""
        self._model = self._data = None


class MujocoSnapshot(Snapshot):
    """A copied state, with the data from which its velocities and points are computed."""

    __slots__ = ("_deformables", "motion", "state")

    def __init__(self, data: Any, motion: Motion, deformables: Any) -> None:
        self.state: State = data.qpos.copy(), data.qvel.copy(), data.mocap_pos.copy(), data.mocap_quat.copy()
        self.motion = motion
        self._deformables = deformables

    def velocities(self) -> Floats:
        """(B, 6) of the bodies' origins, see `Snapshot`."""
        return self.motion.velocities(self.state)

    def points(self, path: str) -> Floats | None:
        """(p, 3) of a deformable prim, see `Snapshot`."""
        if path not in self._deformables.paths:
            return None
        out: Floats = self._deformables.points(path, self.state[0])
        return out

    def point_velocities(self, path: str) -> Floats | None:
        """(p, 3) of a deformable prim, see `Snapshot`; None once the model is freed."""
        points = self.points(path)
        later = self.motion.later(self.state, MOMENT_S)
        if points is None or later is None:
            return None
        out: Floats = (self._deformables.points(path, later) - points) / MOMENT_S
        return out


Velocities = dict[str, tuple[Floats, Floats]]
"""For each body: velocity of its centre of mass [m/s], and its angular velocity [rad/s]; world axes."""


def set_initial_state(engine: MujocoEngine) -> None:
    """Sets the velocities and targets of the world in the engine's data, and everything that depends on them."""
    model, data, compiled = engine.model, engine.data, engine.compiled
    if compiled.start is not None:
        compiled.start(model, data)
    for joint in engine.joints:
        if joint.initial_position is not None:
            data.qpos[model.joint(joint.model_name).qposadr[0]] = joint.initial_position
    engine.forces.step(data)  # with the kinematics
    velocities: Velocities = {}
    for number, body in enumerate(compiled.bodies, start=1):
        if not (body.velocity.any() or body.angular_velocity.any()) or body.kinematic:
            continue
        velocities[body.path] = body.velocity, body.angular_velocity
        if engine.is_free(body.path):
            turn = data.xmat[number].reshape(3, 3)
            arm = data.xipos[number] - data.xpos[number]
            address = model.jnt_dofadr[model.body_jntadr[number]]
            data.qvel[address : address + 3] = body.velocity - np.cross(body.angular_velocity, arm)
            data.qvel[address + 3 : address + 6] = turn.T @ body.angular_velocity
    for joint in engine.joints:
        _start_joint(engine, joint, velocities)
        if joint.initial_velocity is not None:
            data.qvel[model.joint(joint.model_name).dofadr[0]] = joint.initial_velocity
    engine.deformables.start(data)
    engine.drives.apply(data)
    forward(model, data)


def _start_joint(engine: MujocoEngine, joint: Joint, velocities: Velocities) -> None:
    """By the relative motion of the bodies; motion of a centre of mass beyond that also rotates them."""
    model, data = engine.model, engine.data
    first, second = joint.bodies
    if joint.kind == "fixed" or second not in velocities:
        return
    rest = np.zeros(3), np.zeros(3)
    v1, w1 = velocities[second]
    v0, w0 = velocities.get(first or "", rest)
    joint_number, body = model.joint(joint.model_name).id, engine.number(second)
    address = model.jnt_dofadr[joint_number]
    turn = data.xmat[body].reshape(3, 3)
    axis = turn @ joint.frames[1][:3, joint.axis]
    if joint.kind == "prismatic":
        data.qvel[address] = axis @ (v1 - v0)
        return
    arm = data.xipos[body] - data.xanchor[joint_number]
    spin = w1 - w0
    alone = model.body_jntnum[body] == 1
    if alone and first not in velocities and v1.any():  # of a flying pair, the common motion is not the joint's
        missing = v1 - np.cross(w1, arm)
        across = arm if joint.kind == "spherical" else arm - axis * (axis @ arm)
        if across @ across > 1e-12:
            spin = spin + np.cross(across, missing) / (across @ across)
    if joint.kind == "spherical":
        data.qvel[address : address + 3] = turn.T @ spin
    else:
        data.qvel[address] = axis @ spin


_BALL, _FREE = int(mujoco.mjtJoint.mjJNT_BALL), int(mujoco.mjtJoint.mjJNT_FREE)


class Leaving:
    """The state of an engine before it adopts another model."""

    def __init__(self, physics: MujocoEngine) -> None:
        self._model, self._data = physics.model, physics.data
        self._numbers = {path: number for number, path in enumerate(physics.body_paths, start=1)}
        warm = physics.data.qacc_warmstart.copy()
        self._velocities = body_velocities(physics.model, physics.data, len(physics.body_paths))
        self._data.qacc_warmstart[:] = warm
        drives = physics.drives
        self._targets = {joint.path: target.copy() for joint, target in zip(drives.joints, drives.targets, strict=True)}
        self._grippers = {path: (gripper, gripper.weld_data) for path, gripper in physics._grippers.items()}
        self._surfaces, self._motors = physics._surfaces, physics.motors
        self._deformables, self._forces = physics.deformables, physics.forces.own
        self._others = _others(physics)

    def arrive(self, physics: MujocoEngine, kept: frozenset[str]) -> None:
        """Sets the state of everything that still exists; `kept`: bodies with unchanged rest poses."""
        model, data = physics.model, physics.data
        numbers = {0: 0}
        for path, number in physics._index.items():
            if path in self._numbers:
                numbers[self._numbers[path]] = number + 1
                physics.forces.own[number + 1] = self._forces[self._numbers[path]]
                self._body(model, data, self._numbers[path], number + 1, path in kept)
        for name, hidden in _others(physics).items():
            if name in self._others:
                self._body(model, data, self._others[name], hidden, True)
        data.time = self._data.time
        if isinstance(physics.deformables, Deformables) and isinstance(self._deformables, Deformables):
            physics.deformables.take_over(self._deformables, self._data, data)
        self._controls(physics)
        if self._surfaces is not None:
            physics.surfaces.take_over(self._surfaces, numbers)
        for path, (gripper, welds) in self._grippers.items():
            if path in physics._grippers and physics._grippers[path].spec.points == gripper.spec.points:
                physics._grippers[path].take_over(gripper, welds)
        physics.forces.step(data)
        warm = data.qacc_warmstart.copy()
        forward(model, data)
        data.qacc_warmstart[:] = warm

    def _body(self, model: Any, data: Any, old: int, new: int, kept: bool) -> None:
        from_mocap, to_mocap = self._model.body_mocapid[old], model.body_mocapid[new]
        if from_mocap >= 0 and to_mocap >= 0:
            data.mocap_pos[to_mocap] = self._data.mocap_pos[from_mocap]
            data.mocap_quat[to_mocap] = self._data.mocap_quat[from_mocap]
        before, after = _joints(self._model, old), _joints(model, new)
        if [kind for kind, *_ in before] != [kind for kind, *_ in after]:
            if after and after[0][0] == _FREE:
                self._set_free(data, after[0][2], old, new)
            return
        for (kind, q0, v0), (_, q1, v1) in zip(before, after, strict=True):
            positions, speeds = WIDTHS.get(kind, (1, 1))
            if kind != _BALL or kept:  # a ball's position is measured from its rest pose
                data.qpos[q1 : q1 + positions] = self._data.qpos[q0 : q0 + positions]
            for name in ("qvel", "qacc_warmstart", "qfrc_applied"):
                getattr(data, name)[v1 : v1 + speeds] = getattr(self._data, name)[v0 : v0 + speeds]

    def _set_free(self, data: Any, address: int, old: int, new: int) -> None:
        """A body that a joint held continues with its velocity."""
        motion: Floats = self._velocities[old - 1]
        turn = np.asarray(self._data.xmat[old]).reshape(3, 3)
        data.qvel[address : address + 3] = motion[:3]
        data.qvel[address + 3 : address + 6] = turn.T @ motion[3:]

    def _controls(self, physics: MujocoEngine) -> None:
        """Drives by their joints; actuators and ties with other names by their names."""
        model, data, drives = physics.model, physics.data, physics.drives
        own = {joint.path for joint in drives.joints}
        for number, joint in enumerate(drives.joints):
            if joint.path in self._targets:
                drives.targets[number] = self._targets[joint.path]
        drives.apply(data)
        there = {self._model.actuator(number).name: number for number in range(self._model.nactuator)}
        for number in range(model.nactuator):
            name = model.actuator(number).name
            if name and name not in own and name in there:
                self._range(data, "ctrl", "actuator_ctrl", model, there[name], number)
                self._range(data, "act", "actuator_act", model, there[name], number)
                if physics.motors is not None and self._motors is not None:
                    physics.motors.take_over(self._motors, there[name], number)
        ties = {self._model.equality(number).name: number for number in range(self._model.neq)}
        for number in range(model.neq):
            name = model.equality(number).name
            if name and name in ties and not name.endswith("#grip"):
                data.eq_active[number] = self._data.eq_active[ties[name]]

    def _range(self, data: Any, name: str, prefix: str, model: Any, old: int, new: int) -> None:
        """The indices of an actuator in one of the engine's arrays."""
        first, count = (int(getattr(self._model, prefix + end)[old]) for end in ("adr", "num"))
        to, room = (int(getattr(model, prefix + end)[new]) for end in ("adr", "num"))
        if count and count == room:
            getattr(data, name)[to : to + count] = getattr(self._data, name)[first : first + count]


def _others(physics: MujocoEngine) -> dict[str, int]:
    """The model's bodies that are not rigid bodies of the scene, such as the vertices of cloth, by their names."""
    model = physics.model
    found = ((model.body(number).name, number) for number in range(1 + len(physics.body_paths), model.nbody))
    return {name: number for name, number in found if name}


def _joints(model: Any, body: int) -> list[tuple[int, int, int]]:
    """(kind, address of its position, of its velocity) of each joint of a body."""
    first = int(model.body_jntadr[body])
    numbers = range(first, first + int(model.body_jntnum[body])) if first >= 0 else ()
    return [(int(model.jnt_type[n]), int(model.jnt_qposadr[n]), int(model.jnt_dofadr[n])) for n in numbers]
