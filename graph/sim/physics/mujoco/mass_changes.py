"""Other masses and inertias of free bodies while they move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from graph.base.errors import RunError
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .engine import MujocoEngine


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
