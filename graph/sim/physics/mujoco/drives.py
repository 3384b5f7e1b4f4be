"""The drives of a model's joints: stiff, limited, and stable at any time step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.physics.world_model import Joint
from graph.sim.transforms import Floats

from .library import mujoco

_IMPLICIT = (int(mujoco.mjtIntegrator.mjINT_IMPLICIT), int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST))


class Drives:
    """Sets MuJoCo's actuators so that each joint gets stiffness (q* - q) + damping (dq* - dq), within its limit.

    Both terms are evaluated at the end of the step. The integrator `discrete` does that itself; the implicit
    integrators do it only for the damping, so for them the spring's share of it, dt times the stiffness, is added (Tan,
    Liu and Turk, Stable proportional-derivative controllers, 2011). `euler` and `rk4`, which only a user chooses, take
    both as they are: rk4 keeps its order, and neither holds drives that are stiff for the step (see `step_size`).

    A force at its limit does not depend on the joint's position, so MuJoCo integrates it explicitly; a stiff drive
    would then jump from one limit to the other around its target endlessly. Such a drive gets, for that step, only as
    much of its stiffness and damping as keeps it from overshooting, given the least inertia of the joint. That a drive
    is at its limit is known from the force of the step before, which MuJoCo has clamped; in the step after new targets,
    which may be far away, it is checked at once.
    """

    def __init__(self, model: Any, joints: Sequence[Joint]) -> None:
        self._model = model
        self.joints = tuple(joint for joint in joints if joint.drive is not None)
        handles = [model.joint(joint.path) for joint in self.joints]
        self._dof = np.array([int(handle.dofadr[0]) for handle in handles], dtype=np.intp)
        self._coordinate = np.array([int(handle.qposadr[0]) for handle in handles], dtype=np.intp)
        drives = [joint.drive for joint in self.joints if joint.drive is not None]
        scale = [model.dof_M0[dof] if drive.acceleration else 1.0 for dof, drive in zip(self._dof, drives, strict=True)]
        self.stiffness = np.array([drive.stiffness for drive in drives]) * scale
        self.damping = np.array([drive.damping for drive in drives]) * scale
        self.limit = np.array([drive.max_force for drive in drives]) * scale
        self.targets = np.array([[drive.position, drive.velocity] for drive in drives]).reshape(-1, 2)
        """(A, 2) target positions and velocities [rad or m, per s]; call `apply` after writing."""
        self._inertia = 1 / np.maximum(model.dof_invweight0[self._dof], 1e-12)
        self.limited = bool(np.isfinite(self.limit).any())
        self._at_limit = False
        self._new_targets = True
        self._rows, self._controls, places = _places(model, [joint.path for joint in self.joints])
        forces = np.arange(model.nactuator)[places] if isinstance(places, slice) else places
        limited = np.flatnonzero(np.isfinite(self.limit))
        self._limits = [(int(forces[number]), float(self.limit[number])) for number in limited]
        self._dt = self._ahead = 0.0
        self._aim = self._resistance = np.zeros(len(self.joints))
        # MuJoCo drops controls above 1e10, which stiff drives exceed, so they are scaled down. Powers of 2 are exact.
        self._gain = np.exp2(np.ceil(np.log2(np.maximum(self.stiffness + self.damping, 1.0))))
        model.actuator_gainprm[self._rows, 0] = self._gain
        model.actuator_forcelimited[self._rows] = np.isfinite(self.limit)
        # Slightly above the limit: forces that are limited here are not clamped, and so are integrated implicitly.
        highest = np.where(np.isfinite(self.limit), self.limit * (1 + 1e-6), 0.0)
        model.actuator_forcerange[self._rows] = np.multiply.outer(highest, [-1.0, 1.0])

    def set_dt(self, dt: float) -> None:
        """Sets a new time step [s]."""
        self._dt = dt
        self._ahead = dt if self._model.opt.integrator in _IMPLICIT else 0.0
        self._resistance = self.damping + self._ahead * self.stiffness
        self._set_gains(self.stiffness, self.damping)

    @property
    def driven(self) -> list[int]:
        """The numbers in the model of the joints whose drives do something."""
        works = (self.stiffness > 0) | (self.damping > 0)
        return [int(joint) for joint in self._model.dof_jntid[self._dof[works]]]

    @property
    def gains_per_inertia(self) -> tuple[list[float], list[float]]:
        """Stiffness [1/s2] and damping [1/s] by the least inertia of each joint."""
        return (self.stiffness / self._inertia).tolist(), (self.damping / self._inertia).tolist()

    @property
    def controls(self) -> tuple[NDArray[np.intp], Floats]:
        """(A,) the control of each drive in MuJoCo's data, and the gain by which its actuator multiplies it."""
        return np.arange(self._model.nu)[self._controls], self._gain

    @property
    def nominal_controls(self) -> Floats:
        """(A,) the controls of the targets, whatever the forces' limits."""
        found: Floats = self._aim / self._gain
        return found

    def apply(self, data: Any) -> None:
        """Writes the targets to the engine."""
        self._aim = self.stiffness * self.targets[:, 0] + self.damping * self.targets[:, 1]
        self._new_targets = True
        data.ctrl[self._controls] = self.nominal_controls

    def limit_forces(self, data: Any) -> None:
        """Before a step: limits the forces."""
        if not self._at_limit and not self._new_targets:
            forces = data.actuator_force.tolist()  # plain Python: faster than array functions for so few numbers
            for place, limit in self._limits:
                if not -limit <= forces[place] <= limit:
                    break
            else:
                return
        self._new_targets = False
        position, velocity = data.qpos[self._coordinate], data.qvel[self._dof]
        force = self._aim - self.stiffness * position - self._resistance * velocity
        size = np.abs(force)
        if (size <= self.limit).all():
            if self._at_limit:
                self._set_gains(self.stiffness, self.damping)
                self.apply(data)
                self._at_limit = self._new_targets = False
            return
        self._at_limit = True
        over = size / self.limit
        share = 1 / np.maximum(over, 1)
        added = self._dt * share * (self.damping + self._dt * self.stiffness)
        kept = np.where(over > 1, share * np.maximum(0, 1 - self._inertia / np.maximum(added, 1e-300)), 1)
        stiffness, damping = self.stiffness * kept, self.damping * kept
        self._set_gains(stiffness, damping)
        data.ctrl[self._controls] = (
            force * share + stiffness * position + (damping + self._ahead * stiffness) * velocity
        ) / self._gain

    def _set_gains(self, stiffness: Floats, damping: Floats) -> None:
        self._model.actuator_biasprm[self._rows, 1] = -stiffness
        self._model.actuator_biasprm[self._rows, 2] = -(damping + self._ahead * stiffness)


Places = slice | NDArray[np.intp]


def _places(model: Any, names: Sequence[str]) -> tuple[Places, Places, Places]:
    """The indices of actuators with these names among all actuators, controls and forces."""
    if model.nactuator == len(names):
        return slice(None), slice(None), slice(None)
    rows = np.array([model.actuator(name).id for name in names], dtype=np.intp)
    return rows, model.actuator_ctrladr[rows], model.actuator_outadr[rows]
