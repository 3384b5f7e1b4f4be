"""Steps that are too long for what moves: drives that an explicit integrator cannot hold, and bodies that tumble."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim import transforms
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .engine import MujocoEngine

_KINDS = mujoco.mjtIntegrator
EULER, RK4 = int(_KINDS.mjINT_EULER), int(_KINDS.mjINT_RK4)
EXPLICIT = {EULER: "euler", RK4: "rk4"}

LOST = 0.01
"""Share of its angular momentum that a tumbling body may lose or gain per second."""

MOST_HZ = 1e9


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


def check_drives(engine: MujocoEngine, warn: Warn) -> None:
    """Warns (`drive-unstable`) about the drive that needs the shortest step, if the present one is too long for it."""
    integrator, drives, dt = int(engine.model.opt.integrator), engine.drives, float(engine.dt)
    if integrator not in EXPLICIT:
        return
    worst, needed = "", 0.0
    for joint, stiffness, damping in zip(drives.joints, *drives.gains_per_inertia, strict=True):
        if not holds(integrator, dt, stiffness=stiffness, damping=damping):
            rate = least_rate(partial(holds, integrator, stiffness=stiffness, damping=damping), 1 / dt)
            worst, needed = max((worst, needed), (joint.path, rate), key=lambda found: found[1])
    if worst:
        warn(
            "drive-unstable",
            worst,
            f"{EXPLICIT[integrator]} integrates drives explicitly, and this one is too stiff for {1 / dt:g} Hz: raise "
            f"physics_hz to {math.ceil(needed):,} or leave physics.integrator out",
        )


class Tumbling:
    """Bodies that turn too fast for the integrator.

    The engine adds the gyroscopic torque w x L of the step's start. Within the step the momentum L turns, as seen from
    the body, by g = dt |w x L| / |L|; so a tumbling body loses (euler: gains) about 0.08 g2 of it in each step, with
    rk4 g6 / 1000 (measured, see `tests/stability`). A body that spins about an axis of its inertia keeps g = 0 and L.
    """

    def __init__(self, model: Any, bodies: int) -> None:
        free = [
            body
            for body in range(1, 1 + bodies)
            if (joint := int(model.body_jntadr[body])) >= 0
            and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE
            and np.ptp(model.body_inertia[body]) > 0.01 * model.body_inertia[body].max()
        ]
        self.bodies = np.array(free, dtype=np.intp)
        self._inertia: Floats = model.body_inertia[self.bodies]
        self._axes = transforms.rotation_matrices(model.body_iquat[self.bodies])
        first = model.jnt_dofadr[model.body_jntadr[self.bodies]] + 3
        self._dofs = first[:, None] + np.arange(3)

    def worst(self, model: Any, data: Any) -> tuple[int, float, float]:
        """The body that loses most: its number, the share of its momentum per second, its turn per step [rad]."""
        rates = np.einsum("bji,bj->bi", self._axes, data.qvel[self._dofs])
        momentum = rates * self._inertia
        dt = float(model.opt.timestep)
        turn = dt * np.linalg.norm(np.cross(rates, momentum), axis=1)
        turn /= np.maximum(np.linalg.norm(momentum, axis=1), 1e-300)
        number = int(np.argmax(turn))
        g = float(turn[number])
        lost = g**6 / 1000 if model.opt.integrator == RK4 else 0.08 * g * g
        return int(self.bodies[number]), lost / dt, float(np.linalg.norm(rates[number])) * dt
