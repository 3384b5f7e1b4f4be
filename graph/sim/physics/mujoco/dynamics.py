"""The equations of motion of a mechanism, at its present state: Jacobians, inertia, gravity, velocity terms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from graph.sim.physics.protocol import MotionTerms, Rows
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .engine import MujocoEngine


def motion_terms(engine: MujocoEngine, bodies: Sequence[str], dofs: Rows, base: str | None) -> MotionTerms:
    """See `PhysicsEngine.motion_terms`. dofs: the model's degrees of freedom of the joints."""
    model = engine.model
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = engine.data.qpos, engine.data.qvel
    data.mocap_pos[:], data.mocap_quat[:] = engine.data.mocap_pos, engine.data.mocap_quat
    mujoco.mj_forward(model, data)
    columns, turn = dofs, np.eye(len(dofs))
    if base is not None:
        number = engine.number(base)
        first = int(model.jnt_dofadr[model.body_jntadr[number]])
        columns = np.concatenate([np.arange(first, first + 6), dofs])
        turn = np.eye(len(columns))
        # MuJoCo turns a free body about its own axes; here the base turns about those of the world.
        turn[3:6, 3:6] = data.xmat[number].reshape(3, 3)
    jacobians = np.zeros((len(bodies), 6, len(columns)))
    for row, path in enumerate(bodies):
        if path in engine.body_paths:
            full: Floats = np.zeros((6, model.nv))
            mujoco.mj_jac(model, data, full[:3], full[3:], data.xpos[engine.number(path)], engine.number(path))
            jacobians[row] = full[:, columns] @ turn.T
    masses = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, masses)
    both = data.qfrc_bias[columns].copy()
    data.qvel[:] = 0
    mujoco.mj_forward(model, data)
    weight = data.qfrc_bias[columns]
    inertia = turn @ masses[np.ix_(columns, columns)] @ turn.T
    return MotionTerms(jacobians, inertia, turn @ weight, turn @ (both - weight))
