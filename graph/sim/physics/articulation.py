"""Jointed mechanisms: read their joints and set what their drives aim at, by whole arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats

if TYPE_CHECKING:
    from graph.sim.physics.model import Joint
    from graph.sim.physics.mujoco.engine import MujocoEngine


class Articulation:
    """The joints with one degree of freedom of the mechanism at a path, in stage order.

    Positions and velocities are radians and stage units, efforts N m and N: what the node library uses.
    """

    def __init__(self, physics: MujocoEngine, root: str, meters_per_unit: float) -> None:
        self.path = root
        self._physics = physics
        self._meters_per_unit = meters_per_unit
        self.bind()

    def bind(self) -> None:
        """Find the joints in the engine's model, anew after it was compiled anew."""
        physics, root, meters_per_unit = self._physics, self.path, self._meters_per_unit
        joints = [joint for joint in _connected(physics.joints, root) if joint.kind in ("revolute", "prismatic")]
        self.joint_paths = tuple(joint.path for joint in joints)
        self.joint_names = tuple(path.rpartition("/")[2] for path in self.joint_paths)
        self.model_names = {joint.name: number for number, joint in enumerate(joints) if joint.name}
        """Numbers of joints by what the model that they come from calls them."""
        self._joints = joints
        self._scale = np.array([1.0 if joint.kind == "revolute" else 1 / meters_per_unit for joint in joints])
        self._position = np.array([physics.qpos_address(joint) for joint in joints], dtype=np.intp)
        self._velocity = np.array([physics.dof(joint) for joint in joints], dtype=np.intp)
        actuators = [physics.actuator(joint) for joint in joints]
        self._actuator = np.array([-1 if number is None else number for number in actuators], dtype=np.intp)

    def belongs_to(self, physics: MujocoEngine) -> bool:
        """Whether these are joints of that physics."""
        return self._physics is physics

    @property
    def driven(self) -> NDArray[np.bool_]:
        """(J,) which joints have a drive; position and velocity targets of the others have no effect."""
        driven = self._actuator >= 0
        motors = self._physics.motors
        return driven if motors is None else driven | motors.driven(self._joints)

    @property
    def positions(self) -> Floats:
        """(J,) joint positions [rad or stage units]."""
        out: Floats = self._physics.data.qpos[self._position] * self._scale
        return out

    @property
    def velocities(self) -> Floats:
        """(J,) joint velocities [rad/s or stage units/s]."""
        out: Floats = self._physics.data.qvel[self._velocity] * self._scale
        return out

    @property
    def efforts(self) -> Floats:
        """(J,) efforts along the joints [N m or N] in the last physics step: drives, applied efforts and limits."""
        from graph.sim.physics.mujoco.forces import joint_efforts

        out: Floats = joint_efforts(self._physics)[self._velocity]
        return out

    @property
    def reactions(self) -> Floats:
        """(J, 6) force [N] and torque [N m] that joints pass on to their second bodies, in the joint's frame there."""
        from graph.sim.physics.mujoco.forces import joint_reactions

        return joint_reactions(self._physics, self._joints)

    @property
    def limits(self) -> Floats:
        """(J, 2) lowest and highest positions [rad or stage units]; infinite where there is no limit."""
        ends = np.array([(joint.lower, joint.upper) for joint in self._joints]).reshape(-1, 2)
        out: Floats = ends * self._scale[:, None]
        return out

    @property
    def linear(self) -> NDArray[np.bool_]:
        """(J,) which joints slide; the others turn."""
        return np.array([joint.kind == "prismatic" for joint in self._joints], dtype=np.bool_)

    def set_targets(
        self,
        positions: Sequence[float] | Floats | None = None,
        velocities: Sequence[float] | Floats | None = None,
        efforts: Sequence[float] | Floats | None = None,
        joints: Sequence[int] | None = None,
    ) -> None:
        """Set what the drives aim at, and efforts that act besides them until set anew.

        Each array has one number per joint (or per entry of `joints`, joint numbers); NaN leaves that joint alone, an
        empty array or None all of them. Raises ValueError, having changed nothing, if an array has another length.
        """
        chosen = np.arange(len(self.joint_paths)) if joints is None else np.asarray(joints, dtype=np.intp)
        commands = [
            self._command(name, values, len(chosen))
            for name, values in (("positions", positions), ("velocities", velocities), ("efforts", efforts))
        ]
        for column, values in enumerate(commands[:2]):
            if values is not None:
                wanted = ~np.isnan(values) & (self._actuator[chosen] >= 0)
                rows = chosen[wanted]
                self._physics.drives.targets[self._actuator[rows], column] = values[wanted] / self._scale[rows]
        if self._physics.motors is not None:
            commands[2] = self._command_motors(chosen, commands)
        if commands[2] is not None:
            wanted = ~np.isnan(commands[2])
            self._physics.data.qfrc_applied[self._velocity[chosen[wanted]]] = commands[2][wanted]
        self._physics.drives.apply(self._physics.data)

    def _command_motors(self, chosen: NDArray[np.intp], commands: Sequence[Floats | None]) -> Floats | None:
        """Hand commands to the actuators that a model brings; returns the efforts that none of them gives."""
        motors, data = self._physics.motors, self._physics.data
        assert motors is not None
        nothing = np.full(len(chosen), np.nan)
        scale = self._scale[chosen]
        positions, velocities = (nothing if values is None else values / scale for values in (commands[0], commands[1]))
        left = None if commands[2] is None else commands[2].copy()
        for place, number in enumerate(chosen):
            path = self.joint_paths[number]
            if not (np.isnan(positions[place]) and np.isnan(velocities[place])):
                motors.command(data, path, float(positions[place]), float(velocities[place]))
            if left is not None and not np.isnan(left[place]) and motors.push(data, path, float(left[place])):
                left[place] = np.nan
        return left

    def set_positions(self, positions: Sequence[float] | Floats, joints: Sequence[int] | None = None) -> None:
        """Put joints at positions [rad or stage units] at once; NaN leaves one alone. What aims at them stays."""
        self._put(self._physics.data.qpos, self._position, "positions", positions, joints)
        self._physics.moved()

    def set_velocities(self, velocities: Sequence[float] | Floats, joints: Sequence[int] | None = None) -> None:
        """Give joints velocities [rad/s or stage units/s] at once; NaN leaves one alone."""
        self._put(self._physics.data.qvel, self._velocity, "velocities", velocities, joints)

    def _put(
        self,
        into: Floats,
        addresses: NDArray[np.intp],
        name: str,
        given: Sequence[float] | Floats,
        joints: Sequence[int] | None,
    ) -> None:
        chosen = np.arange(len(self.joint_paths)) if joints is None else np.asarray(joints, dtype=np.intp)
        values = self._command(name, given, len(chosen))
        if values is not None:
            rows = chosen[~np.isnan(values)]
            into[addresses[rows]] = values[~np.isnan(values)] / self._scale[rows]

    def _command(self, name: str, values: Sequence[float] | Floats | None, width: int) -> Floats | None:
        if values is None or not len(values):
            return None
        out = np.asarray(values, dtype=np.float64)
        if out.shape != (width,):
            raise ValueError(f"{self.path}: {name} have shape {out.shape}; there are {width} joints to command.")
        if np.isinf(out).any():
            raise ValueError(f"{self.path}: {name} hold an infinite value.")
        return out


def _connected(joints: Sequence[Joint], root: str) -> list[Joint]:
    """The joints at, below or on bodies below a path, and all that bodies connect with them."""

    def inside(path: str | None) -> bool:
        if path is None:
            return False
        prim = path.partition(":")[0]  # an axis of a joint with several is "/Joint:rotX"
        return prim == root or prim.startswith(root.rstrip("/") + "/")

    found = {joint.path for joint in joints if inside(joint.path) or any(map(inside, joint.bodies))}
    bodies: set[str | None] = {body for joint in joints if joint.path in found for body in joint.bodies if body}
    bodies |= {body for joint in joints for body in joint.bodies if inside(body)}
    while True:
        more = {joint.path for joint in joints if not bodies.isdisjoint(joint.bodies)} - found
        if not more:
            return [joint for joint in joints if joint.path in found]
        found |= more
        bodies |= {body for joint in joints if joint.path in more for body in joint.bodies if body}
