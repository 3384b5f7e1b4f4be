"""Positions and velocities of a model at one moment, and the velocities of its bodies at that moment."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.physics.protocol import Snapshot
from graph.sim.transforms import Floats

from .library import mujoco
from .memory import state_of

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
