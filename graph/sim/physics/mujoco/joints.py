"""The joints of an engine as rows: positions, velocities, forces, commands, and the equations of motion."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graph.sim.physics.protocol import MotionTerms, PhysicsEngine, Rows
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .drives import Drives
    from .motors import Motors

_LIMIT = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT)


class _Places(NamedTuple):
    """By joint: its coordinate, its degree of freedom and its drive in the model (-1: none), and its largest effort."""

    coordinate: Rows
    dof: Rows
    actuator: Rows
    strongest: Floats


class EngineJoints(PhysicsEngine):
    """What an engine does with its joints of one degree of freedom; `PhysicsEngine` documents the methods."""

    model: Any
    data: Any
    drives: Drives
    motors: Motors | None
    _stale: bool

    @cached_property
    def _elsewhere(self) -> Any:
        """State of the present model for `pose_at`."""
        return mujoco.MjData(self.model)

    @cached_property
    def _places(self) -> _Places:
        """Of the present model."""
        coordinate, dof, actuator = np.full((3, len(self.joints)), -1, dtype=np.intp)
        strongest = np.full(len(self.joints), np.inf)
        drives = {joint.path: number for number, joint in enumerate(self.drives.joints)}
        for row, joint in enumerate(self.joints):
            if joint.kind in ("revolute", "prismatic"):
                handle = self.model.joint(joint.model_name)
                coordinate[row], dof[row] = int(handle.qposadr[0]), int(handle.dofadr[0])
                actuator[row] = drives.get(joint.path, -1)
                if self.model.jnt_actfrclimited[handle.id]:
                    strongest[row] = np.abs(self.model.jnt_actfrcrange[handle.id]).max()
        return _Places(coordinate, dof, actuator, strongest)

    def joint_positions(self, rows: Rows) -> Floats:
        """(n,) [rad or m]."""
        out: Floats = self.data.qpos[self._places.coordinate[rows]]
        return out

    def joint_velocities(self, rows: Rows) -> Floats:
        """(n,) [rad/s or m/s]."""
        out: Floats = self.data.qvel[self._places.dof[rows]]
        return out

    def joint_efforts(self, rows: Rows) -> Floats:
        """(n,) in the last step [N m or N]: drives, applied efforts and joint limits."""
        data = self.data
        efforts: Floats = data.qfrc_actuator + data.qfrc_applied
        for row in np.flatnonzero(data.efc_type[: data.nefc] == _LIMIT):
            coordinate = self.model.jnt_dofadr[data.efc_id[row]]
            efforts[coordinate] += data.efc_force[row] * self._slope(int(row), int(coordinate))
        return efforts[self._places.dof[rows]]

    def _slope(self, row: int, coordinate: int) -> float:
        """How a constraint row changes with one coordinate of velocity."""
        data = self.data
        if not mujoco.mj_isSparse(self.model):
            return float(data.efc_J.reshape(-1, self.model.nv)[row, coordinate])
        start, count = data.efc_J_rowadr[row], data.efc_J_rownnz[row]
        columns = data.efc_J_colind[start : start + count]
        return float(data.efc_J[start : start + count][columns == coordinate].sum())

    def joint_reactions(self, rows: Rows) -> Floats:
        """(n, 6) force [N], then torque [N m], that each joint passes on to its second body in the last step.

        Torques are about the origin of the joint's frame on that body; both are along its axes.
        """
        model, data = self.model, self.data
        mujoco.mj_rnePostConstraint(model, data)
        out = np.zeros((len(rows), 6))
        for number, joint in enumerate(self.joints[row] for row in rows):
            child = int(model.jnt_bodyid[model.joint(joint.model_name).id])
            frame = joint.frames[1]
            place, turn = frame[:3, 3], frame[:3, :3]
            if joint.bodies[1] is not None:
                body = self.body_paths.index(joint.bodies[1])
                place = self.positions[body] + self.rotations[body] @ place
                turn = self.rotations[body] @ turn
            torque, force = data.cfrc_int[child, :3], data.cfrc_int[child, 3:]
            moved = torque + np.cross(data.subtree_com[model.body_rootid[child]] - place, force)
            sign = 1.0 if self.body_paths[child - 1] == joint.bodies[1] else -1.0
            out[number, :3], out[number, 3:] = sign * force @ turn, sign * moved @ turn
        return out

    def driven(self, rows: Rows) -> NDArray[np.bool_]:
        """(n,) which joints have one of our drives or a servo of the model."""
        driven: NDArray[np.bool_] = self._places.actuator[rows] >= 0
        return driven if self.motors is None else driven | self.motors.driven([self.joints[row] for row in rows])

    def set_joint_positions(self, rows: Rows, positions: Floats) -> None:
        """Puts joints at positions [rad or m]."""
        self.data.qpos[self._places.coordinate[rows]] = positions
        self._stale = True

    def set_joint_velocities(self, rows: Rows, velocities: Floats) -> None:
        """Gives joints velocities [rad/s or m/s]."""
        self.data.qvel[self._places.dof[rows]] = velocities

    def set_joint_targets(
        self, rows: Rows, positions: Floats | None, velocities: Floats | None, efforts: Floats | None
    ) -> None:
        """Gives targets to drives and servos, efforts to motors; the rest of the efforts acts directly.

        No effort exceeds what the model allows the joint.
        """
        drives, data, places = self.drives, self.data, self._places
        actuators = places.actuator[rows]
        for column, values in enumerate((positions, velocities)):
            if values is not None:
                wanted = ~np.isnan(values) & (actuators >= 0)
                drives.targets[actuators[wanted], column] = values[wanted]
        if self.motors is not None:
            efforts = self._command_motors(self.motors, rows, positions, velocities, efforts)
        if efforts is not None:
            wanted = ~np.isnan(efforts)
            most = places.strongest[rows[wanted]]
            data.qfrc_applied[places.dof[rows[wanted]]] = np.clip(efforts[wanted], -most, most)
        drives.apply(data)

    def _command_motors(
        self,
        motors: Motors,
        rows: Rows,
        positions: Floats | None,
        velocities: Floats | None,
        efforts: Floats | None,
    ) -> Floats | None:
        """Gives commands to the actuators of a model; returns the efforts that no actuator can give."""
        nothing = np.full(len(rows), np.nan)
        position, velocity = (nothing if values is None else values for values in (positions, velocities))
        left = None if efforts is None else efforts.copy()
        for place, row in enumerate(rows):
            path = self.joints[row].path
            if not (np.isnan(position[place]) and np.isnan(velocity[place])):
                motors.command(self.data, path, float(position[place]), float(velocity[place]))
            if left is not None and not np.isnan(left[place]) and motors.push(self.data, path, float(left[place])):
                left[place] = np.nan
        return left

    def pose_at(self, body: str, rows: Rows, positions: Floats) -> tuple[Floats, Floats]:
        """A body's pose with joints at positions, and the Jacobian of its origin there; nothing moves."""
        model, now, number = self.model, self.data, self.body_paths.index(body) + 1
        data = self._elsewhere
        data.qpos[:], data.mocap_pos[:], data.mocap_quat[:] = now.qpos, now.mocap_pos, now.mocap_quat
        data.qpos[self._places.coordinate[rows]] = positions
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        full: Floats = np.zeros((6, model.nv))
        mujoco.mj_jac(model, data, full[:3], full[3:], data.xpos[number], number)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = data.xmat[number].reshape(3, 3), data.xpos[number]
        return pose, full[:, self._places.dof[rows]]

    def motion_terms(self, bodies: Sequence[str], rows: Rows, base: str | None) -> MotionTerms:
        """Jacobians, inertia, gravity and velocity terms at the present state."""
        model, now = self.model, self.data
        numbers = {path: number for number, path in enumerate(self.body_paths, start=1)}
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = now.qpos, now.qvel
        data.mocap_pos[:], data.mocap_quat[:] = now.mocap_pos, now.mocap_quat
        mujoco.mj_forward(model, data)
        columns = dofs = self._places.dof[rows]
        turn = np.eye(len(dofs))
        if base is not None:
            first = int(model.jnt_dofadr[model.body_jntadr[numbers[base]]])
            columns = np.concatenate([np.arange(first, first + 6), dofs])
            turn = np.eye(len(columns))
            # MuJoCo turns a free body about its own axes; here the base turns about those of the world.
            turn[3:6, 3:6] = data.xmat[numbers[base]].reshape(3, 3)
        jacobians = np.zeros((len(bodies), 6, len(columns)))
        for row, path in enumerate(bodies):
            if path in numbers:
                full: Floats = np.zeros((6, model.nv))
                mujoco.mj_jac(model, data, full[:3], full[3:], data.xpos[numbers[path]], numbers[path])
                jacobians[row] = full[:, columns] @ turn.T
        masses = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, masses)
        both = data.qfrc_bias[columns].copy()
        data.qvel[:] = 0
        mujoco.mj_forward(model, data)
        weight = data.qfrc_bias[columns]
        inertia = turn @ masses[np.ix_(columns, columns)] @ turn.T
        return MotionTerms(jacobians, inertia, turn @ weight, turn @ (both - weight))
