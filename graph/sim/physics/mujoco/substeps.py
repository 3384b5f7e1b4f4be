"""Physics steps of worlds with passive chains or closed loops, in as many parts as these need."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .chains import STATE, Chains, chains_of
from .constraints import HARDEST
from .library import mujoco, state_of

if TYPE_CHECKING:
    from .engine import MujocoEngine

HALVINGS = 6
"""A step is made in 64 parts at the most."""

WIDEST = 5e-4
"""How far a closed loop may open at its joint [m] before a step is repeated in smaller parts."""

_WELD, _CONNECT = int(mujoco.mjtEq.mjEQ_WELD), int(mujoco.mjtEq.mjEQ_CONNECT)


_KINDS = mujoco.mjtWarning
_FATAL = [int(kind) for kind in (_KINDS.mjWARN_BADQPOS, _KINDS.mjWARN_BADQVEL, _KINDS.mjWARN_BADQACC)]


class Loops:
    """The constraints that close loops of joints."""

    def __init__(self, model: Any) -> None:
        kinds = model.eq_type
        self.ties = np.flatnonzero(((kinds == _CONNECT) | (kinds == _WELD)) & (model.eq_active0 > 0))  # no grippers
        welds = (kinds[self.ties] == _WELD)[:, None]
        here, there = model.eq_data[self.ties, :3], model.eq_data[self.ties, 3:6]
        self._bodies = model.eq_obj1id[self.ties], model.eq_obj2id[self.ties]
        self._anchors = np.where(welds, there, here), np.where(welds, here, there)

    def gap(self, own: Any, active: NDArray[Any]) -> float:
        """How far those that are active are open at most [m]; own: data with the poses of all bodies."""
        ends = [
            own.xpos[bodies] + np.einsum("tij,tj->ti", own.xmat[bodies].reshape(-1, 3, 3), anchors)
            for bodies, anchors in zip(self._bodies, self._anchors, strict=True)
        ]
        return float((np.linalg.norm(ends[0] - ends[1], axis=1) * active[self.ties]).max())


class Substeps:
    """Divides the steps of a world: a part in which a chain gains energy or a loop opens is repeated in halves.

    A part is taken back before anything but the engine has seen it. The division depends on the state alone, so that a
    state that is restored continues as before.
    """

    def __init__(self, engine: MujocoEngine, warn: Warn) -> None:
        self._warn, self._told = warn, False
        model, drives = engine.model, engine.drives
        driven = drives.driven
        self._engine = engine
        self._loops = Loops(model)
        self.chains = chains_of(model, driven)
        if self:
            self._own: Any = state_of(model)
            self._stops = model.jnt_solref[:, 0] == HARDEST[0], model.tendon_solref_lim[:, 0] == HARDEST[0]
            self._start: Floats = np.zeros(mujoco.mj_stateSize(model, STATE))
            self._chains = Chains(model, self.chains, driven, self._own) if len(self.chains) else None

    def __bool__(self) -> bool:
        return bool(len(self.chains) or len(self._loops.ties))

    def step(self, make: Callable[[], bool], follow: Callable[[], None]) -> bool:
        """One step. make: a part of it by the engine, and whether that is still finite; follow: what comes after it.

        Returns false where even the smallest part is not finite.
        """
        model, data = self._engine.model, self._engine.data
        whole = float(model.opt.timestep)
        end, level, done = float(data.time) + whole, 0, 0
        try:
            while done < 1 << HALVINGS:
                mujoco.mj_getState(model, data, self._start, STATE)
                finite = make()
                if finite and self._right(level == HALVINGS):
                    follow()
                    done += 1 << (HALVINGS - level)
                elif level == HALVINGS:
                    return False
                else:
                    mujoco.mj_setState(model, data, self._start, STATE)
                    data.warning.number[_FATAL] = 0
                    level += 1
                    self._set_part(whole / (1 << level), stop=2 * whole)
        finally:
            if level:
                self._set_part(whole, stop=HARDEST[0])
        data.time = end
        return True

    def _set_part(self, length: float, stop: float) -> None:
        """Makes parts this long [s]. stop: the time constant of limits, which stays that of the whole step: what has
        passed a limit in a long part would be thrown back in a short one.
        """
        model = self._engine.model
        model.opt.timestep = length
        model.jnt_solref[:, 0] = np.where(self._stops[0], stop, model.jnt_solref[:, 0])
        model.tendon_solref_lim[:, 0] = np.where(self._stops[1], stop, model.tendon_solref_lim[:, 0])
        self._engine.drives.set_dt(length)

    def _right(self, last: bool) -> bool:
        """Whether the part that was made can stay; the last and smallest does."""
        chains, data = self._chains, self._engine.data
        if chains is not None:
            left = chains.step_free(data, self._start)
            if not last and chains.passes_limits(data, self._start):
                return False
            if left.any() and chains.grows(data, self._start, left):
                if not last:
                    return False
                self._slow_down(chains.slow_down(data))
        return last or not len(self._loops.ties) or not self._opens()

    def _slow_down(self, tree: int) -> None:
        if not self._told:
            self._told = True
            engine = self._engine
            self._warn(
                "energy-grows",
                engine.body_name(int(engine.model.tree_bodyadr[tree])),
                f"the chain that begins here gains energy even in 1/{1 << HALVINGS} of a step, and what it gains is "
                "taken out of its velocities; raise physics_hz, or give its joints damping",
            )

    def _opens(self) -> bool:
        """Whether a loop has opened at its joint too far, and farther than before."""
        model, data, own = self._engine.model, self._engine.data, self._own
        mujoco.mj_setState(model, own, self._start, STATE)
        own.qpos[:] = data.qpos
        mujoco.mj_kinematics(model, own)
        gap = self._loops.gap(own, data.eq_active)
        if gap <= WIDEST:
            return False
        mujoco.mj_setState(model, own, self._start, STATE)
        mujoco.mj_kinematics(model, own)
        return gap > 1.001 * self._loops.gap(own, data.eq_active)
