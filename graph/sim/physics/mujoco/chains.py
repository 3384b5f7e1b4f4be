"""Chains of bodies on hinges and ball joints that nothing drives: exact while they move freely, stable at contacts.

MuJoCo takes the Coriolis forces of a step at its start. A chain whose links turn far in a step then gains energy,
without end where neither drives nor friction take it out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.sim import transforms
from graph.sim.transforms import Floats

from .library import WIDTHS, mujoco

TURN = 0.25
"""A free chain begins with parts of a step in which no joint turns farther than this [rad]."""

MOST_PARTS = 64

DRIFT = 1e-3
"""Share of its energy that a free chain may gain or lose in a second."""

GAIN = 0.01
"""Share of its kinetic energy that a chain with contacts, loops or drives may gain in a part of a step."""

BEYOND = 0.01
"""How far a hinge may pass its limit [rad] before a step is repeated in smaller parts."""

SLOW = 0.05
"""Chains whose joints turn less in a part of a step [rad] cannot gain that much."""

BALL_TURN = 0.4
"""Most that a ball joint with contacts may turn in a part of a step [rad]: its gyroscopic torque is explicit too."""

STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)

_KINDS = mujoco.mjtJoint
_OFF = mujoco.mjtDisableBit
_SMOOTH = int(_OFF.mjDSBL_CONSTRAINT) | int(_OFF.mjDSBL_ACTUATION)


def chains_of(model: Any, driven: Sequence[int]) -> NDArray[np.intp]:
    """The trees of two coordinates or more, of which a hinge or ball joint has no drive; driven: joints by number."""
    turning = np.isin(model.jnt_type, (int(_KINDS.mjJNT_HINGE), int(_KINDS.mjJNT_BALL))) & ~_wheels(model)
    turning[list(driven)] = False
    trees = np.unique(model.dof_treeid[model.jnt_dofadr[turning]]).astype(np.intp)
    out: NDArray[np.intp] = trees[model.tree_dofnum[trees] > 1]
    return out


class Chains:
    """The passive chains of a model. What they do depends on the present state alone."""

    def __init__(self, model: Any, trees: NDArray[np.intp], driven: Sequence[int], own: Any) -> None:
        """trees: those of `chains_of`; driven: joints with drives; own: a second set of data, for trials."""
        self._model, self.trees, self._data = model, trees, own
        tree_of = model.dof_treeid[model.jnt_dofadr]
        self._qpos, self._qvel = own.qpos, own.qvel
        self._drives = np.isin(trees, tree_of[list(driven)])
        self._drives.flags.writeable = False
        self._all_driven, self._any_driven = bool(self._drives.all()), bool(self._drives.any())
        mine = np.isin(tree_of, trees)
        hinge = model.jnt_type == int(_KINDS.mjJNT_HINGE)
        self._hinges = _run(model.jnt_dofadr[mine & hinge & ~_wheels(model)])
        self._balls = model.jnt_dofadr[mine & (model.jnt_type == int(_KINDS.mjJNT_BALL))][:, None] + np.arange(3)
        limited = mine & hinge & (model.jnt_limited > 0)
        self._limited, self._range = model.jnt_qposadr[limited], model.jnt_range[limited].T
        joints = [np.flatnonzero(tree_of == tree) for tree in trees]
        self._places = [_places(model, each) for each in joints]
        self._everywhere = _places(model, np.flatnonzero(mine))
        self._sums = np.array(model.dof_treeid == trees[:, None], dtype=np.float64)
        """(T, nv) that sums over the coordinates of each chain."""
        self._halves = self._sums / 2
        of_tree = model.body_treeid == trees[:, None]
        self._weights = np.where(of_tree, model.body_mass * (1 - model.body_gravcomp), 0.0)
        self._masses = np.where(of_tree, model.body_mass, 0.0).sum(axis=1)
        self._floats = model.jnt_type[[each[0] for each in joints]] == int(_KINDS.mjJNT_FREE)
        first = np.where(self._floats, model.tree_dofadr[trees], 0)
        self._linear = first[:, None] + np.minimum(np.arange(3), model.nv - 1 - first[:, None])
        heights = np.array([_lever(model, int(tree)) for tree in trees])
        self._heights = np.where(self._floats, 0.0, heights)
        self._damps = self._sums @ model.dof_damping + model.opt.density + model.opt.viscosity > 0
        self._decay = float((model.dof_damping * model.dof_invweight0)[self._sums.any(axis=0)].max(initial=0.0))
        self._excess = np.zeros(len(trees))
        self._any_floats = bool(self._floats.any())
        self._centres = own.xipos.reshape(-1)
        self._momenta, self._gravity = np.zeros(model.nv), np.zeros(model.nv)
        self._pulled: tuple[bytes, Floats, Floats] = b"", self._excess, self._excess
        self._known: tuple[bytes, Floats, Floats] = b"", self._excess, self._excess

    # -- free chains -------------------------------------------------------------------------------------------------

    def step_free(self, data: Any, start: Floats) -> NDArray[np.bool_]:
        """After a step of the engine: moves the chains that nothing touches by the Runge-Kutta method instead.

        start: the state before the step. A step in which the energy of one changes is repeated in twice as many parts.
        Returns which chains remain as the engine left them.
        """
        if self._all_driven:
            return self._drives
        left, some = self._touched(data)
        if some and left.all():
            return left
        model, own = self._model, self._data
        option = model.opt
        dt, integrator, disabled = float(option.timestep), int(option.integrator), int(option.disableflags)
        self._set(own, start)
        before, scale = self._energies_at_start()
        speeds, parts = self._qvel.copy(), self._first_parts(dt)
        option.integrator, option.disableflags = int(mujoco.mjtIntegrator.mjINT_RK4), disabled | _SMOOTH
        try:
            while True:
                option.timestep = dt / parts
                mujoco.mj_step(model, own, parts)
                done = self._keeps(before, scale, speeds, dt)
                if done is None or (done | left).all() or parts >= MOST_PARTS:
                    break
                parts *= 2
                self._set(own, start)
        finally:
            option.timestep, option.integrator, option.disableflags = dt, integrator, disabled
        if done is None and not some:
            coordinates, dofs = self._everywhere
            data.qpos[coordinates], data.qvel[dofs] = self._qpos[coordinates], self._qvel[dofs]
            return left
        done = ~left if done is None else done & ~left
        for number in np.flatnonzero(done):
            coordinates, dofs = self._places[number]
            data.qpos[coordinates], data.qvel[dofs] = self._qpos[coordinates], self._qvel[dofs]
        return ~done

    def _set(self, own: Any, state: Floats) -> None:
        mujoco.mj_setState(self._model, own, state, STATE)

    def _touched(self, data: Any) -> tuple[NDArray[np.bool_], bool]:
        """(T,) chains with drives, contacts, limits, friction or loops in the last step; and whether any may be one."""
        if not data.nefc:
            return self._drives, self._any_driven
        if not data.nisland:
            return np.ones(len(self.trees), dtype=np.bool_), True
        return self._drives | (data.tree_island[self.trees] >= 0), True

    def _first_parts(self, dt: float) -> int:
        """The number of parts to begin with."""
        rate = max(self._rate(self._qvel), self._decay / 4)
        parts = 1
        while rate * dt > TURN * parts and parts < MOST_PARTS:
            parts *= 2
        return parts

    def _rate(self, speeds: Floats) -> float:
        """How fast joints turn at the most [rad/s]."""
        return max(max(map(abs, speeds[self._hinges].tolist()), default=0.0), self._ball_rate(speeds))

    def _ball_rate(self, speeds: Floats) -> float:
        if not len(self._balls):
            return 0.0
        return max((math.hypot(*rates) for rates in speeds[self._balls].tolist()), default=0.0)

    def _energies_at_start(self) -> tuple[Floats, Floats]:
        """`_energies` of a state in which the last step may have ended."""
        state = self._qpos.tobytes() + self._qvel.tobytes()
        if state != self._known[0]:
            self._known = state, *self._energies()
        return self._known[1:]

    def _energies(self) -> tuple[Floats, Floats]:
        """(T,) the energies of the chains in a state [J]; and what a change is compared with: that of their motion
        about their centres of mass, and of their fall for those that hang.
        """
        kinetic, inner = self._kinetic()
        pull, fall = self._pull()
        return kinetic - pull @ self._centres, inner + fall

    def _pull(self) -> tuple[Floats, Floats]:
        """(T, 3 n) what gravity adds to the chains' energies [J] by the coordinates of all masses; (T,) the most that
        those that hang can fall [J].
        """
        gravity = self._model.opt.gravity
        known = gravity.tobytes()
        if known != self._pulled[0]:
            pull = (self._weights[:, :, None] * gravity).reshape(len(self.trees), -1)
            self._pulled = known, pull, math.hypot(*gravity.tolist()) * self._heights
        return self._pulled[1:]

    def _kinetic(self) -> tuple[Floats, Floats]:
        """(T,) kinetic energies [J], of all and of the motion about the centre of mass of those that float."""
        model, own = self._model, self._data
        mujoco.mj_kinematics(model, own)
        mujoco.mj_comPos(model, own)
        mujoco.mj_makeM(model, own)
        mujoco.mj_mulM(model, own, self._momenta, self._qvel)
        kinetic: Floats = self._halves @ (self._qvel * self._momenta)
        if not self._any_floats:
            return kinetic, kinetic
        linear = self._momenta[self._linear]  # of a free joint: along the world's axes
        return kinetic, kinetic - np.where(self._floats, (linear**2).sum(axis=1) / (2 * self._masses), 0.0)

    def _keeps(self, before: Floats, scale: Floats, speeds: Floats, dt: float) -> NDArray[np.bool_] | None:
        """(T,) whether the chains' energies changed as they should, in a step dt that ends in this state; None: all."""
        own = self._data
        state = self._qpos.tobytes() + self._qvel.tobytes()
        after, scale_after = self._energies()
        self._known = state, after, scale_after
        change = after - before
        if (np.abs(change) <= DRIFT * dt * scale_after).all():
            return None
        applied = own.qfrc_smooth - own.qfrc_passive + own.qfrc_bias  # by users, also on bodies
        allowed = DRIFT * dt * np.maximum(scale, scale_after) + 1e-12 * (np.abs(before) + np.abs(after))
        keeps: NDArray[np.bool_] = np.abs(change) <= allowed
        if not keeps.all():
            fastest = np.maximum(np.abs(speeds), np.abs(self._qvel))
            pushed = allowed + 1.5 * dt * self._sums @ (np.abs(applied) * fastest)
            keeps |= (change <= pushed) & ((change >= -pushed) | (self._damps & np.isfinite(change)))
        return keeps

    # -- chains with contacts, loops or drives -----------------------------------------------------------------------

    def passes_limits(self, data: Any, start: Floats) -> bool:
        """Whether a hinge has gone too far beyond its limit, and farther than before: it would be thrown back."""
        if not len(self._limited):
            return False
        (low, high), angles = self._range, data.qpos[self._limited]
        beyond = np.maximum(low - angles, angles - high)
        deep = beyond > BEYOND
        if not deep.any():
            return False
        self._set(self._data, start)
        before = self._qpos[self._limited]
        return bool((deep & (beyond > 1.001 * np.maximum(low - before, before - high))).any())

    def grows(self, data: Any, start: Floats, which: NDArray[np.bool_]) -> bool:
        """Whether the step that the engine has made added energy to one of these chains.

        The Coriolis forces c of a step h from v0 to v1 do the work -c (v0 + v1) h / 2; exactly, it is what the change
        of the mass matrix adds to the kinetic energy, v1 (M1 - M0) v1 / 2. All other forces are left out of that
        comparison, and so may be anything.
        """
        model, own = self._model, self._data
        dt = float(model.opt.timestep)
        self._excess = np.zeros(len(self.trees))
        if self._ball_rate(data.qvel) * dt > BALL_TURN:
            return True
        if self._rate(data.qvel) * dt < SLOW:
            return False
        self._set(own, start)
        speeds = self._qvel.copy()
        self._qvel[:] = 0.0
        mujoco.mj_kinematics(model, own)
        mujoco.mj_comPos(model, own)
        mujoco.mj_comVel(model, own)
        mujoco.mj_rne(model, own, 0, self._gravity)
        work = (data.qfrc_bias - self._gravity) * (speeds + data.qvel) * (dt / 2)
        mujoco.mj_mulM(model, data, self._momenta, data.qvel)
        old = self._momenta * data.qvel / 2
        self._qpos[:], self._qvel[:] = data.qpos, data.qvel
        kinetic, inner = self._kinetic()
        gained = kinetic - self._sums @ (old + work)
        self._excess = np.where(which & ~(gained <= GAIN * inner), gained / np.maximum(kinetic, 1e-300), 0.0)
        return bool(self._excess.any())

    def slow_down(self, data: Any) -> int:
        """Takes the energy that `grows` has found out of the velocities of these chains; returns the worst one's tree.

        A ball joint that turns too far is left as it is.
        """
        data.qvel[:] *= np.sqrt(np.maximum(1 - self._excess @ self._sums, 0.0))
        return int(self.trees[np.argmax(self._excess)])


def _wheels(model: Any) -> NDArray[np.bool_]:
    """Hinges that turn a single body which is symmetric about their axis: no inertia changes."""
    out = np.zeros(model.njnt, dtype=np.bool_)
    for joint in np.flatnonzero(model.jnt_type == int(_KINDS.mjJNT_HINGE)).tolist():
        body = int(model.jnt_bodyid[joint])
        if body in model.body_parentid or model.body_jntnum[body] != 1:
            continue
        axis = model.jnt_axis[joint]
        arm = np.cross(axis, model.body_ipos[body] - model.jnt_pos[joint])
        turn = transforms.rotation_matrices(model.body_iquat[body])
        tensor = turn @ np.diag(model.body_inertia[body]) @ turn.T
        along = float(axis @ tensor @ axis)
        across = (np.trace(tensor) - along) / 2
        symmetric = along * np.outer(axis, axis) + across * (np.eye(3) - np.outer(axis, axis))
        small = 1e-3 * float(model.body_inertia[body].max())
        out[joint] = np.abs(tensor - symmetric).max() < small and model.body_mass[body] * (arm @ arm) < small
    return out


def _places(model: Any, joints: NDArray[np.intp]) -> tuple[NDArray[np.intp] | slice, NDArray[np.intp] | slice]:
    """The coordinates, and the coordinates of velocity, of some joints; slices where they follow one another."""
    widths = [WIDTHS.get(int(model.jnt_type[joint]), (1, 1)) for joint in joints]
    positions = [np.arange(n) + model.jnt_qposadr[j] for j, (n, _) in zip(joints, widths, strict=True)]
    speeds = [np.arange(n) + model.jnt_dofadr[j] for j, (_, n) in zip(joints, widths, strict=True)]
    return _run(np.concatenate(positions)), _run(np.concatenate(speeds))


def _run(numbers: NDArray[np.intp]) -> NDArray[np.intp] | slice:
    """Numbers as a slice, if they follow one another."""
    if len(numbers) and int(numbers[-1] - numbers[0]) == len(numbers) - 1:
        return slice(int(numbers[0]), int(numbers[-1]) + 1)
    return numbers


def _lever(model: Any, tree: int) -> float:
    """The sum of mass times distance from the tree's root, stretched out [kg m]: how far it can fall."""
    first, count = int(model.tree_bodyadr[tree]), int(model.tree_bodynum[tree])
    reach: dict[int, float] = {}
    total = 0.0
    for body in range(first, first + count):
        own = 0.0 if body == first else float(np.linalg.norm(model.body_pos[body]))
        reach[body] = reach.get(int(model.body_parentid[body]), 0.0) + own
        total += float(model.body_mass[body]) * (reach[body] + float(np.linalg.norm(model.body_ipos[body])))
    return total
