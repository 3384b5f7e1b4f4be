"""Restitution: Newton's law of impact, added to an engine whose contacts do not bounce.

After a step in which surfaces met with a normal speed v, the impulses at those contacts are found that make them
separate with e v, and the state continues as if the step had ended with the resulting velocities. That is the same with
any integrator, stiff drives included; contacts at rest are left to the engine. A ball dropped from h rises again to e2
h, within the (1 - e2) v dt that it may have sunk in when its velocity is reversed.

Friction is part of these impulses: at each contact, with what the engine has given in the step, the tangential impulse
is at most mu times the normal one (Coulomb), and no more than ends the sliding. Newton's law with friction can add
energy where bodies turn at the impact; then the impulses are moved towards those of e = 0 until none is added.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass, field
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .surfaces import Surfaces

SLOWEST = 0.05
"""Slower impacts [m/s], and those that gravity alone can cause in two steps, do not bounce."""

SWEEPS, SETTLED = 200, 1e-6
"""At most so many Gauss-Seidel sweeps over simultaneous impulses, until none changes by more than this share."""


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
        """Gives contacts their target normal speeds [m/s], by impulses that push, and that friction limits."""
        model, count = self._model, len(which)
        rows = np.concatenate([self._rows(data, int(index)) for index in which])
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        spread = np.linalg.solve(mass, rows.T)
        given = np.zeros((count, 3))
        for number, index in enumerate(which.tolist()):
            wrench = np.zeros(6)
            mujoco.mj_contactForce(model, data, index, wrench)
            given[number] = wrench[:3] * model.opt.timestep
        contact = data.contact
        friction = np.where(contact.dim[which] > 1, contact.friction[which, 0], 0.0)
        target = np.zeros((count, 3))
        moving = self.surfaces is not None and len(self.surfaces.own)
        if self.surfaces is not None and moving:
            target += self.surfaces.own[which, :3]
        speeds = (rows @ data.qvel).reshape(-1, 3)
        missing = target - speeds
        inverse = rows @ spread
        change = spread @ _impulses(inverse, missing + [1, 0, 0] * wanted[:, None], friction, given)
        if not moving:
            untouched = data.qvel - spread @ given.ravel()
            most = untouched @ mass @ untouched
            after = data.qvel + change
            if after @ mass @ after > most * (1 + 1e-9):
                plastic = spread @ _impulses(inverse, missing, friction, given)
                change = plastic + _share_within(data.qvel + plastic, change - plastic, mass, most) * (change - plastic)
        data.qvel[:] += change
        mujoco.mj_integratePos(model, data.qpos, change, model.opt.timestep)

    def _row(self, data: Any, index: int) -> Floats:
        """(nv,) derivative of a contact's normal speed with respect to the velocities."""
        out: Floats = self._rows(data, index)[0]
        return out

    def _rows(self, data: Any, index: int) -> Floats:
        """(3, nv) the same along the normal and two tangents, at what was each surface's own point when they met."""
        model, contact = self._model, data.contact[index]
        out = np.zeros((3, model.nv))
        frame = np.asarray(contact.frame).reshape(3, 3)
        place, inside = np.asarray(contact.pos, dtype=np.float64), frame[0] * float(contact.dist) / 2
        for geom, sign in ((int(contact.geom[0]), -1.0), (int(contact.geom[1]), 1.0)):
            move = np.zeros((3, model.nv))
            mujoco.mj_jac(model, data, move, None, place + sign * inside, int(model.geom_bodyid[geom]))
            out += sign * frame @ move
        return out


def _impulses(inverse: Floats, missing: Floats, friction: Floats, given: Floats) -> Floats:
    """(3 n,) impulses along normals and tangents that add the missing speeds (n, 3), as far as friction lets them.

    inverse: (3 n, 3 n), of the mass that contacts feel; friction: (n,); given: (n, 3) impulses of the engine.
    """
    out = np.zeros(missing.size)
    blocks = [slice(3 * n, 3 * n + 3) for n in range(len(missing))]
    for _ in range(SWEEPS):
        largest = 0.0
        for number, block in enumerate(blocks):
            before = out[block].copy()
            own = inverse[block, block]
            if own[0, 0] <= 0:
                continue
            rest = missing[number] - inverse[block] @ out
            out[block.start] = max(before[0] + rest[0] / own[0, 0], 0.0)
            limit = friction[number] * (given[number, 0] + out[block.start])
            if friction[number] > 0:
                rest = missing[number] - inverse[block] @ out
                tangents = slice(block.start + 1, block.stop)
                total = out[tangents] + given[number, 1:] + np.linalg.lstsq(own[1:, 1:], rest[1:], rcond=1e-9)[0]
                size = float(np.hypot(*total))
                out[tangents] = total * min(1.0, limit / max(size, 1e-300)) - given[number, 1:]
            largest = max(largest, float(np.abs(out[block] - before).max()))
        if largest <= SETTLED * float(np.abs(out).max()):
            break
    return out


def _share_within(start: Floats, way: Floats, mass: Floats, most: float) -> float:
    """How far along a way of velocities v M v stays at most this."""
    a, b, c = float(way @ mass @ way), float(start @ mass @ way), float(start @ mass @ start) - most
    if c >= 0 or a <= 0:
        return 0.0
    return min(1.0, (math.sqrt(b * b - a * c) - b) / a)
