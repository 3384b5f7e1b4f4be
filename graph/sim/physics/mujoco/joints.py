"""The joints of a model as rows: positions, velocities, efforts, and commands to drives and actuators."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graph.sim.physics.protocol import Rows
from graph.sim.transforms import Floats

from .forces import joint_efforts, joint_reactions

if TYPE_CHECKING:
    from .engine import MujocoEngine


class Joints:
    """The joints with one degree of freedom among an engine's `joints`; see `PhysicsEngine.joint_positions` and
    following.
    """

    def __init__(self, engine: MujocoEngine) -> None:
        self._engine = engine
        self._coordinate, self._dof, self._actuator = np.full((3, len(engine.joints)), -1, dtype=np.intp)
        self._strongest = np.full(len(engine.joints), np.inf)
        actuators = {joint.path: number for number, joint in enumerate(engine.drives.joints)}
        for row, joint in enumerate(engine.joints):
            if joint.kind in ("revolute", "prismatic"):
                handle = engine.model.joint(joint.model_name)
                self._coordinate[row], self._dof[row] = int(handle.qposadr[0]), int(handle.dofadr[0])
                self._actuator[row] = actuators.get(joint.path, -1)
                if engine.model.jnt_actfrclimited[handle.id]:
                    self._strongest[row] = np.abs(engine.model.jnt_actfrcrange[handle.id]).max()

    def dofs(self, rows: Rows) -> Rows:
        """(n,) the model's degrees of freedom."""
        return self._dof[rows]

    def positions(self, rows: Rows) -> Floats:
        """(n,) [rad or m]."""
        out: Floats = self._engine.data.qpos[self._coordinate[rows]]
        return out

    def velocities(self, rows: Rows) -> Floats:
        """(n,) [rad/s or m/s]."""
        out: Floats = self._engine.data.qvel[self._dof[rows]]
        return out

    def efforts(self, rows: Rows) -> Floats:
        """(n,) in the last step [N m or N]."""
        out: Floats = joint_efforts(self._engine)[self._dof[rows]]
        return out

    def reactions(self, rows: Rows) -> Floats:
        """(n, 6) [N], [N m]."""
        return joint_reactions(self._engine, [self._engine.joints[row] for row in rows])

    def driven(self, rows: Rows) -> NDArray[np.bool_]:
        """(n,) which joints have one of our drives or a servo of the model."""
        driven: NDArray[np.bool_] = self._actuator[rows] >= 0
        motors = self._engine.motors
        return driven if motors is None else driven | motors.driven([self._engine.joints[row] for row in rows])

    def set_positions(self, rows: Rows, positions: Floats) -> None:
        """[rad or m]."""
        self._engine.data.qpos[self._coordinate[rows]] = positions

    def set_velocities(self, rows: Rows, velocities: Floats) -> None:
        """[rad/s or m/s]."""
        self._engine.data.qvel[self._dof[rows]] = velocities

    def set_targets(
        self, rows: Rows, positions: Floats | None, velocities: Floats | None, efforts: Floats | None
    ) -> None:
        """Gives targets to drives and servos, efforts to motors; the rest of the efforts acts directly.

        No effort exceeds what the model allows the joint.
        """
        drives, data = self._engine.drives, self._engine.data
        for column, values in enumerate((positions, velocities)):
            if values is not None:
                wanted = ~np.isnan(values) & (self._actuator[rows] >= 0)
                drives.targets[self._actuator[rows[wanted]], column] = values[wanted]
        if self._engine.motors is not None:
            efforts = self._command_motors(rows, positions, velocities, efforts)
        if efforts is not None:
            wanted = ~np.isnan(efforts)
            most = self._strongest[rows[wanted]]
            data.qfrc_applied[self._dof[rows[wanted]]] = np.clip(efforts[wanted], -most, most)
        drives.apply(data)

    def _command_motors(
        self, rows: Rows, positions: Floats | None, velocities: Floats | None, efforts: Floats | None
    ) -> Floats | None:
        """Gives commands to the actuators of a model; returns the efforts that no actuator can give."""
        motors, data = self._engine.motors, self._engine.data
        assert motors is not None
        nothing = np.full(len(rows), np.nan)
        position, velocity = (nothing if values is None else values for values in (positions, velocities))
        left = None if efforts is None else efforts.copy()
        for place, row in enumerate(rows):
            path = self._engine.joints[row].path
            if not (np.isnan(position[place]) and np.isnan(velocity[place])):
                motors.command(data, path, float(position[place]), float(velocity[place]))
            if left is not None and not np.isnan(left[place]) and motors.push(data, path, float(left[place])):
                left[place] = np.nan
        return left
