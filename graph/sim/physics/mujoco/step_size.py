"""Steps that are too long for what moves: drives that an explicit integrator cannot hold, and bodies that tumble."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.records import dataclass
from graph.sim import transforms
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .engine import MujocoEngine

_KINDS = mujoco.mjtIntegrator
EULER, RK4, IMPLICIT = (int(kind) for kind in (_KINDS.mjINT_EULER, _KINDS.mjINT_RK4, _KINDS.mjINT_IMPLICIT))
EXPLICIT = {EULER: "euler", RK4: "rk4"}

LOST = 0.01
"""Share of its angular momentum that a tumbling body may lose per second, or by which its wobble may grow."""

MOST_HZ = 1e9

_FOLLOWING, _LAST = [1, 2, 0], [2, 0, 1]
"""The two axes after each one."""


def holds(integrator: int, step: float, *, stiffness: float, damping: float) -> bool:
    """Whether an explicit integrator with this step [s] holds a drive (gains divided by the inertia it moves).

    euler: x' = x + h v', v' = v - h (k x + c v) is stable up to 2 h c + h2 k = 4 (Jury's criterion); rk4: where its
    polynomial of both roots of z2 + c z + k is at most 1.
    """
    if integrator == EULER:
        return 2 * step * damping + step * step * stiffness <= 4
    roots = np.roots([1.0, damping, stiffness]) * step
    return bool(np.all(np.abs(np.polyval([1 / 24, 1 / 6, 1 / 2, 1, 1], roots)) <= 1 + 1e-9))


def least_rate(steady: Callable[[float], bool], rate: float) -> float:
    """The lowest rate [Hz] above `rate` with whose step `steady` is true, to a hundredth of it."""
    high = rate
    while not steady(1 / high) and high < MOST_HZ:
        high *= 2
    low = high / 2
    while high - low > 0.01 * high:
        middle = (low + high) / 2
        low, high = (low, middle) if steady(1 / middle) else (middle, high)
    return high


def unstable_drive(engine: MujocoEngine) -> tuple[str, float] | None:
    """The drive that needs the highest rate [Hz] with an explicit integrator, and that rate; None if all are stable."""
    integrator, drives, dt = int(engine.model.opt.integrator), engine.drives, float(engine.dt)
    if integrator not in EXPLICIT:
        return None
    found = []
    for joint, stiffness, damping in zip(drives.joints, *drives.gains_per_inertia, strict=True):
        if not holds(integrator, dt, stiffness=stiffness, damping=damping):
            steady = partial(holds, integrator, stiffness=stiffness, damping=damping)
            found.append((joint.path, least_rate(steady, 1 / dt)))
    return max(found, key=lambda each: each[1], default=None)


def check_drives(engine: MujocoEngine, warn: Warn) -> None:
    """Warns (`drive-unstable`) about the drive that needs the shortest step, if the present one is too long for it."""
    if worst := unstable_drive(engine):
        path, needed = worst
        warn(
            "drive-unstable",
            path,
            f"{EXPLICIT[int(engine.model.opt.integrator)]} integrates drives explicitly, and this one is too stiff for "
            f"{1 / float(engine.dt):g} Hz: raise physics_hz to {math.ceil(needed):,} or leave physics.integrator out",
        )


@dataclass(frozen=True, slots=True)
class Wobble:
    """How the worst body fares: its number, its turn per step [rad], the share of its momentum that it loses per
    second, or by which its wobble grows.
    """

    body: int
    turn: float
    share: float
    grows: bool


class Tumbling:
    """Bodies on free and ball joints that turn too fast for the integrator. J: their inertia about their pivot.

    Where the gyroscopic torque w x J w is that of the start of the step (free joints: euler; ball joints: all but
    implicit and rk4), a wobble about a principal axis k, of rate l2 = w2 (Jk - Ji) (Jk - Jj) / (Ji Jj), grows by l2 dt
    / 2 per second. Where it is implicit the momentum turns, as seen from the body, by g = dt |w x J w| / |J w| in a
    step and loses about 0.08 g2 of its size; rk4: g6 / 1000 (both measured, see `tests/stability`). A body that spins
    about the only axis of its inertia that differs keeps all of it.
    """

    def __init__(self, model: Any, bodies: int, spared: Sequence[int] = ()) -> None:
        """bodies: how many there are; spared: trees whose steps are divided as they need."""
        kinds = mujoco.mjtJoint
        found: list[tuple[int, bool, int, Floats, Floats]] = []
        for body in range(1, 1 + bodies):
            joint = int(model.body_jntadr[body])
            kind = int(model.jnt_type[joint]) if joint >= 0 and model.body_jntnum[body] == 1 else -1
            if kind not in (kinds.mjJNT_FREE, kinds.mjJNT_BALL) or model.body_treeid[body] in spared:
                continue
            free = kind == kinds.mjJNT_FREE
            arm = np.zeros(3) if free else model.body_ipos[body] - model.jnt_pos[joint]
            turn = transforms.rotation_matrices(model.body_iquat[body])
            tensor = turn @ np.diag(model.body_inertia[body]) @ turn.T
            tensor += model.body_mass[body] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
            inertia, axes = np.linalg.eigh(tensor)
            if np.ptp(inertia) > 0.01 * inertia.max():
                found.append((body, free, int(model.jnt_dofadr[joint]) + (3 if free else 0), inertia, axes))
        self.bodies = [each[0] for each in found]
        at_free = np.array([each[1] for each in found], dtype=np.bool_)
        self._dofs = np.array([each[2] for each in found], dtype=np.intp)[:, None] + np.arange(3)
        self._inertia: Floats = np.array([each[3] for each in found]).reshape(-1, 3)
        self._to_axes: Floats = np.array([each[4].T for each in found]).reshape(-1, 3, 3)
        following, last = self._inertia[:, _FOLLOWING], self._inertia[:, _LAST]
        spread = (self._inertia - following) * (self._inertia - last)
        self._wobble = np.abs(spread) / np.maximum(following * last, 1e-300)
        self._twist = last - following
        integrator = int(model.opt.integrator)
        self._grows = (integrator == EULER) | (~at_free & (integrator not in (RK4, IMPLICIT)))
        self._most = np.where(self._grows, self._wobble.max(axis=1, initial=0.0) / 2, 0.08)

    def slow(self, model: Any, data: Any) -> bool:
        """Whether all turn so slowly that none can lose or gain more than `LOST`: a bound that costs little.

        In a step dt at a turn rate w, |w x L| <= w |L|, and so g <= w dt; with rk4, g^6 / 1000 is less still.
        """
        rates = data.qvel[self._dofs]
        return bool(((rates * rates).sum(axis=1) * self._most).max() * float(model.opt.timestep) <= LOST)

    def worst(self, model: Any, data: Any) -> Wobble:
        """The body that loses or gains most in the present state."""
        dt, integrator = float(model.opt.timestep), int(model.opt.integrator)
        rates = (self._to_axes @ data.qvel[self._dofs][..., None])[..., 0]
        momentum = rates * self._inertia
        torque = rates[:, _FOLLOWING] * rates[:, _LAST] * self._twist  # w x J w; the calls of numpy are what costs here
        g2 = dt * dt * (torque * torque).sum(axis=1) / np.maximum((momentum * momentum).sum(axis=1), 1e-300)
        lost = (g2**3 / 1000 if integrator == RK4 else 0.08 * g2) / dt
        grown = (self._wobble * rates * rates).max(axis=1) * dt / 2
        share = np.where(self._grows, grown, lost)
        row = int(np.argmax(share))
        turn = float(np.linalg.norm(rates[row])) * dt
        return Wobble(self.bodies[row], turn, float(share[row]), bool(self._grows[row]))
