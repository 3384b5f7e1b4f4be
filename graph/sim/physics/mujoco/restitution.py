"""Restitution: Newton's law of impact, added to an engine whose contacts do not bounce.

After a step in which surfaces met with a normal speed v, the impulses at those contacts are found that make them
separate with e v, and the state continues as if the step had ended with the resulting velocities. That is the same with
any integrator, stiff drives included; contacts at rest are left to the engine. A ball dropped from h rises again to e2
h, within the (1 - e2) v dt that it may have sunk in when its velocity is reversed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .surfaces import Surfaces

SLOWEST = 0.05
"""Slower impacts [m/s], and those that gravity alone can cause in two steps, do not bounce."""

SWEEPS = 50
"""Gauss-Seidel sweeps over simultaneous impulses."""


@dataclass(frozen=True)
class Restitution:
    """Coefficients of restitution: the class of each geom by name, and (k, k) by two classes."""

    classes: Mapping[str, int] = field(default_factory=dict)
    shares: Floats = field(default_factory=lambda: np.zeros((0, 0)))

    def __bool__(self) -> bool:
        return bool(self.shares.any())


NO_RESTITUTION = Restitution()
"""No contact bounces."""


class Bounces:
    """Applies the impacts of a model."""

    def __init__(self, model: Any, restitution: Restitution) -> None:
        self._model = model
        self._before: Floats = np.zeros(model.nv)
        self.surfaces: Surfaces | None = None
        """Moving surfaces, whose velocity is part of the speeds at contacts."""
        count = len(restitution.shares)
        self._shares: Floats = np.zeros((count + 1, count + 1))  # the last class: geoms without one of our materials
        self._shares[:count, :count] = restitution.shares
        self._class: NDArray[np.intp] = np.full(model.ngeom + 1, count, dtype=np.intp)  # geom -1: a deformable
        for name, number in restitution.classes.items():
            self._class[model.geom(name).id] = number

    def step(self, data: Any) -> None:
        """After a step of the engine: reverses the surfaces that met."""
        if data.ncon:
            self._meet(data)
        self._before[:] = data.qvel

    def _meet(self, data: Any) -> None:
        contact = data.contact
        rows = contact.efc_address
        share = self._shares[self._class[contact.geom[:, 0]], self._class[contact.geom[:, 1]]]
        could = np.flatnonzero((share > 0) & (rows >= 0))
        if not len(could):
            return
        model = self._model
        if (
            model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
        ):  # the last stage of which the engine leaves its result
            speed = -np.array([self._row(data, int(index)) @ self._before for index in could])
            speed += self._own(could)
        else:
            speed = self._own(could) - self._normal_speeds(data, rows[could], contact.dim[could])
        least = max(SLOWEST, 2 * model.opt.timestep * float(np.linalg.norm(model.opt.gravity)))
        if not (speed > least).any():
            return
        # Two colliders bounce as a whole: at all their contact points, fast and slow.
        pair = contact.geom[could, 0].astype(np.int64) * (model.ngeom + 1) + contact.geom[could, 1]
        hit = np.isin(pair, pair[speed > least])
        self._turn_round(data, could[hit], share[could[hit]] * np.maximum(speed[hit], 0.0))

    def _own(self, which: NDArray[np.intp]) -> Floats:
        """(n,) speed at which moving surfaces approach each other at contacts [m/s], see `Surfaces.own`."""
        if self.surfaces is None or not len(self.surfaces.own):
            return np.zeros(len(which))
        out: Floats = self.surfaces.own[which, 0]
        return out

    def _normal_speeds(self, data: Any, rows: NDArray[np.integer[Any]], dims: NDArray[np.integer[Any]]) -> Floats:
        """Speeds of the surfaces away from each other at the start of the step [m/s]; of two edges of a pyramid the
        mean.
        """
        velocity = data.efc_vel
        if self._model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC:
            return np.array(velocity[rows])
        following = velocity[np.minimum(rows + 1, len(velocity) - 1)]
        return np.array(np.where(dims > 1, (velocity[rows] + following) / 2, velocity[rows]))

    def _turn_round(self, data: Any, which: NDArray[np.intp], wanted: Floats) -> None:
        """Gives contacts their target normal speeds [m/s], by impulses that only push."""
        model = self._model
        normal = np.stack([self._row(data, int(index)) for index in which])
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        spread = np.linalg.solve(mass, normal.T)
        inverse = normal @ spread
        missing = wanted + self._own(which) - normal @ data.qvel
        impulses = np.zeros(len(which))
        for _ in range(SWEEPS):
            for number in range(len(which)):
                if inverse[number, number] > 0:
                    rest = missing[number] - inverse[number] @ impulses
                    impulses[number] = max(impulses[number] + rest / inverse[number, number], 0.0)
        change = spread @ impulses
        data.qvel[:] += change
        mujoco.mj_integratePos(model, data.qpos, change, model.opt.timestep)

    def _row(self, data: Any, index: int) -> Floats:
        """(nv,) derivative of a contact's normal speed with respect to the velocities."""
        model, contact = self._model, data.contact[index]
        out = np.zeros(model.nv)
        place = np.asarray(contact.pos, dtype=np.float64)
        for geom, sign in ((int(contact.geom[0]), -1.0), (int(contact.geom[1]), 1.0)):
            move = np.zeros((3, model.nv))
            mujoco.mj_jac(model, data, move, None, place, int(model.geom_bodyid[geom]))
            out += sign * np.asarray(contact.frame)[:3] @ move
        return out
