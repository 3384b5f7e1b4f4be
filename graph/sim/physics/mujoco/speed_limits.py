"""Speed limits of bodies and joints, as in PhysX: what is too fast after a step is slowed down.

The step itself moves as without the limit, so under an acceleration a it moves up to a dt2 too far in each step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim import transforms

from .compile import Compiled
from .library import mujoco


class SpeedLimits:
    """The limits of a model: those of joints by coordinate, those of free bodies by their centres of mass."""

    def __init__(self, model: Any, compiled: Compiled) -> None:
        axes = [joint for joint in compiled.joints if np.isfinite(joint.max_speed)]
        self._dofs = np.array([model.joint(joint.model_name).dofadr[0] for joint in axes], dtype=np.intp)
        self._most = np.array([joint.max_speed for joint in axes])
        bodies = [body for body in compiled.bodies if np.isfinite(body.max_speed).any() and not body.kinematic]
        numbers = [model.body(body.model_name).id for body in bodies]
        free = [
            row
            for row, number in enumerate(numbers)
            if (joint := model.body_jntadr[number]) >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE
        ]
        self._bodies = np.array([numbers[row] for row in free], dtype=np.intp)
        self._limits = np.array([bodies[row].max_speed for row in free]).reshape(-1, 2)
        joints = model.body_jntadr[self._bodies]
        self._velocity, self._pose = model.jnt_dofadr[joints], model.jnt_qposadr[joints]
        self._centers = model.body_ipos[self._bodies].copy()
        self.limited = bool(len(self._dofs) or len(free))
        """Whether `step` has work to do."""

    def step(self, data: Any) -> None:
        """After a step: slows down what is too fast."""
        if len(self._dofs):
            speeds = data.qvel[self._dofs]
            if (np.abs(speeds) > self._most).any():
                data.qvel[self._dofs] = np.clip(speeds, -self._most, self._most)
        if len(self._bodies):
            self._slow_bodies(data)

    def _slow_bodies(self, data: Any) -> None:
        """Slows free bodies.

        A free joint has its origin's velocity along world axes and its angular velocity along the body's.
        """
        linear = data.qvel[self._velocity[:, None] + np.arange(3)]
        angular = data.qvel[self._velocity[:, None] + np.arange(3, 6)]
        turns = transforms.rotation_matrices(data.qpos[self._pose[:, None] + np.arange(3, 7)])

        def lever(rates: Any) -> Any:
            return np.einsum("bij,bj->bi", turns, np.cross(rates, self._centers))

        centers = linear + lever(angular)
        slower = angular * _share(angular, self._limits[:, 1])
        centers *= _share(centers, self._limits[:, 0])
        data.qvel[self._velocity[:, None] + np.arange(3, 6)] = slower
        data.qvel[self._velocity[:, None] + np.arange(3)] = centers - lever(slower)


def _share(vectors: Any, most: Any) -> Any:
    """(n, 1) the factor that reduces vectors to their limit."""
    lengths = np.linalg.norm(vectors, axis=1)
    return np.minimum(1.0, most / np.maximum(lengths, 1e-300))[:, None]
