"""Forces on bodies, by users and by the stage, which may rotate with their bodies; and new masses while they move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.physics.world_model import BodyForce
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .engine import MujocoEngine


class BodyForces:
    """The external forces of a model; the user's are added to the stage's."""

    def __init__(self, model: Any, data: Any, numbers: dict[str, int], forces: Sequence[BodyForce]) -> None:
        """numbers: of the model's bodies by path."""
        self._model, self._data, self._numbers = model, data, numbers
        self.own: Floats = np.zeros((model.nbody, 6))
        """(n, 6) forces that users have set, by the model's bodies: force [N], torque [N m]."""
        self.set_authored(forces)

    def set_authored(self, forces: Sequence[BodyForce]) -> None:
        """Replaces the forces of the stage."""
        model = self._model
        known = [force for force in forces if force.path in self._numbers]
        self._bodies = np.array([self._numbers[force.path] for force in known], dtype=np.intp)
        self._local = np.array([force.local for force in known], dtype=np.bool_)
        accelerates = np.array([force.acceleration for force in known], dtype=np.bool_)
        self._forces = np.array([force.force for force in known]).reshape(-1, 3)
        self._forces = np.where(accelerates[:, None], self._forces * model.body_mass[self._bodies, None], self._forces)
        self._torques = np.array([force.torque for force in known]).reshape(-1, 3)
        axes = transforms.rotation_matrices(model.body_iquat[self._bodies]).reshape(-1, 3, 3)
        inertias = np.einsum("bij,bj,bkj->bik", axes, model.body_inertia[self._bodies], axes)
        self._inertias = np.where(accelerates[:, None, None], inertias, np.eye(3))
        self.turning = bool(self._local.any() or (accelerates & self._torques.any(axis=1)).any())
        """Whether forces depend on the rotation of their bodies, so that `step` has work to do."""
        self.step(self._data)

    def set_own(self, bodies: Sequence[int], forces: Floats) -> None:
        """Applies users' forces (n, 6) to bodies of the model."""
        self.own[list(bodies)] = forces
        self._write(self._data)

    def step(self, data: Any) -> None:
        """After a step: rotates the forces that rotate with their body."""
        mujoco.mj_kinematics(self._model, data)
        self._write(data)

    def _write(self, data: Any) -> None:
        data.xfrc_applied[:] = self.own
        if not len(self._bodies):
            return
        turns = data.xmat[self._bodies].reshape(-1, 3, 3)
        forces, torques = (
            np.where(self._local[:, None], vectors, np.einsum("bji,bj->bi", turns, vectors))
            for vectors in (self._forces, self._torques)
        )
        torques = np.einsum("bij,bj->bi", self._inertias, torques)  # along the body's axes
        data.xfrc_applied[self._bodies, :3] += np.einsum("bij,bj->bi", turns, forces)
        data.xfrc_applied[self._bodies, 3:] += np.einsum("bij,bj->bi", turns, torques)


def set_masses(engine: MujocoEngine, paths: Sequence[str], masses: Floats | None, diagonals: Floats | None) -> None:
    """Gives free bodies masses (n,) [kg] and moments of inertia (n, 3) about their own axes [kg m2]; None keeps them.

    Centres of mass stay. Damping keeps taking the same fraction of momentum per second. Raises RunError, with nothing
    changed, for a body that a joint or the user holds, for values that are not positive, and for moments of a body
    whose principal axes are not its own.
    """
    model = engine.model
    numbers = [engine.number(path) for path in paths]
    for row, (path, number) in enumerate(zip(paths, numbers, strict=True)):
        if not engine.is_free(path) or (model.body_parentid == number).any():
            raise RunError(f"{path}: its mass cannot change while it is simulated: only that of a free body can")
        for what, values in (("mass", masses), ("inertia", diagonals)):
            if values is not None and not (np.isfinite(values[row]).all() and (values[row] > 0).all()):
                raise RunError(f"{path}: {what} {values[row]} is not positive")
        if diagonals is not None and abs(model.body_iquat[number][0]) < 1 - 1e-9:
            raise RunError(f"{path}: its principal axes are not its own; author physics:diagonalInertia while stopped")
    dofs = np.array([model.jnt_dofadr[model.body_jntadr[number]] for number in numbers], np.intp)
    linear = model.dof_damping[dofs] / model.body_mass[numbers]
    turning = dofs[:, None] + np.arange(3, 6)
    angular = model.dof_damping[turning] / model.dof_M0[turning]
    if masses is not None:
        model.body_mass[numbers] = masses
    if diagonals is not None:
        model.body_inertia[numbers] = diagonals
    mujoco.mj_setConst(model, mujoco.MjData(model))
    model.dof_damping[dofs[:, None] + np.arange(3)] = (linear * model.body_mass[numbers])[:, None]
    model.dof_damping[turning] = angular * model.dof_M0[turning]
