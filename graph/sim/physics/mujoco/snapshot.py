"""Velocities of bodies, now or in a copied state of a model."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.transforms import Floats

from .library import mujoco

State = tuple[Floats, Floats, Floats, Floats]
"""Coordinates, their velocities, and the places and turns of kinematic bodies."""


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
    """Velocities in copied states: a second set of the engine's data does the work, which the motion never sees.

    It belongs to one model, and outlives the physics' change to another.
    """

    def __init__(self, model: Any, count: int) -> None:
        self._model: Any = model
        self._count = count
        self._data: Any = None

    @property
    def closed(self) -> bool:
        """Whether the model has been freed."""
        return self._model is None

    def velocities(self, state: State) -> Floats:
        """(B, 6) in a copied state; see `body_velocities`."""
        if self._data is None:
            self._data = mujoco.MjData(self._model)
        data = self._data
        data.qpos[:], data.qvel[:], data.mocap_pos[:], data.mocap_quat[:] = state
        return body_velocities(self._model, data, self._count)

    def close(self) -> None:
        """Free the model."""
        self._model = self._data = None
