"""Turns MuJoCo's warning counters into our warnings: wrong forces, dropped contacts, bodies that are far away."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.scene.stage import Warn

from .library import mujoco
from .step_size import LOST, RK4, Tumbling

if TYPE_CHECKING:
    from .engine import MujocoEngine

RESIDUAL = 1.0
"""Residual of the solver's last iteration, scaled like `physics.tolerance`, above which forces are wrong.

Measured on towers of 20 boxes (5.7 mm of compression when solved) with decreasing iteration limits: residuals up to 0.4
changed nothing, 6 gave 10 mm more, 200 to 400 gave 160 mm and more.
"""

FAR = 1e6
"""A body farther than this [m] from the origin has left the scene."""

LOOKS = 64
"""Calls between two searches for such bodies: about one second at 60 updates per second."""

TUMBLES = 8
"""Calls between two searches for bodies that tumble too fast."""

_KINDS = mujoco.mjtWarning
_COUNTED = {
    int(_KINDS.mjWARN_INERTIA): (
        "singular-inertia",
        "the inertia that its joints move is close to singular, and forces are wrong; give it more mass or armature",
    ),
    int(_KINDS.mjWARN_CONTACTFULL): (
        "contacts-dropped",
        "MuJoCo's memory is too small for all contacts, and some are left out; raise <size memory> of the model",
    ),
    int(_KINDS.mjWARN_CNSTRFULL): (
        "contacts-dropped",
        "MuJoCo's memory is too small for all constraints, and some are left out; raise <size memory> of the model",
    ),
    int(_KINDS.mjWARN_BADCTRL): (
        "bad-control",
        "an actuator was given a control that is not a number; it counts as 0",
    ),
}
"""By MuJoCo's kind of warning: our code and text. The other kinds are divergence, see `MujocoEngine.step`."""


_STATE = {
    int(_KINDS.mjWARN_BADQPOS): ("a position", "qpos"),
    int(_KINDS.mjWARN_BADQVEL): ("a velocity", "qvel"),
    int(_KINDS.mjWARN_BADQACC): ("an acceleration", "qacc"),
}
"""The kinds of warnings that mean divergence: what is too large, and where it is."""

_BAD = tuple(_STATE)


class Monitor:
    """Examines an engine after each call of `step`. Each of its warnings is given once."""

    def __init__(self, engine: MujocoEngine, warn: Warn) -> None:
        self._engine, self._warn = engine, warn
        self._counters = memoryview(engine.data.warning.number)
        self._iterations = memoryview(engine.data.solver_niter)
        self._calls = 0
        self._solver_told = False
        self._told = set[int]()
        self._tumbling: Tumbling | None = Tumbling(engine.model, len(engine.body_paths))

    def look(self) -> None:
        """Gives warnings about the last steps."""
        counters = self._counters
        if counters[0] or counters[1] or counters[2] or counters[6]:
            self._tell_counted()
        if not self._solver_told and max(self._iterations) >= self._engine.model.opt.iterations:
            self._check_solver()
        if self._tumbling is not None and self._calls % TUMBLES == 0:
            self._check_tumbling(self._tumbling)
        self._calls += 1
        if self._calls % LOOKS == 0:
            self._find_lost()

    def close(self) -> None:
        """Releases the engine's memory."""
        self._counters.release()
        self._iterations.release()

    def divergence(self) -> str:
        """The message about a failed step: the body, the time, what to do."""
        engine = self._engine
        kind = next(kind for kind in _BAD if self._counters[kind])
        place = int(engine.data.warning[kind].lastinfo)
        if kind == _BAD[0]:
            joint = int(np.searchsorted(engine.model.jnt_qposadr, place, side="right")) - 1
            body = int(engine.model.jnt_bodyid[joint])
        else:
            body = int(engine.model.dof_bodyid[place])
        name, values = _STATE[kind]
        return (
            f"{engine.body_name(body)}: the simulation diverged here, at {float(engine.data.time):.6g} s of physics: "
            f"{name} became {float(getattr(engine.data, values)[place]):.3g}. Raise physics_hz, lower the stiffness, "
            "speeds or mass ratios around it, or move apart what overlaps"
        )

    def _tell_counted(self) -> None:
        for kind, (code, text) in _COUNTED.items():
            if self._counters[kind] and kind not in self._told:
                self._told.add(kind)
                self._warn(code, self._place(kind), text)

    def _place(self, kind: int) -> str:
        if kind != int(_KINDS.mjWARN_INERTIA):
            return "physics"
        place = int(self._engine.data.warning[kind].lastinfo)
        return self._engine.body_name(int(self._engine.model.dof_bodyid[place]))

    def _check_solver(self) -> None:
        """Newton and CG report the distance from the minimum, PGS the improvement of its last iteration."""
        data, cap = self._engine.data, int(self._engine.model.opt.iterations)
        count = len(data.solver.gradient) // len(self._iterations)
        stats = data.solver
        newton = self._engine.model.opt.solver != mujoco.mjtSolver.mjSOL_PGS
        residuals: Any = stats.gradient if newton else stats.improvement
        worst = max(
            float(residuals[island * count + done - 1])
            for island, done in enumerate(self._iterations)
            if cap <= done <= count
        )
        if worst > RESIDUAL:
            self._solver_told = True
            self._warn(
                "solver-not-converged",
                "physics",
                f"its solver stopped after {cap} iterations with a residual of {worst:.3g}, so forces are wrong; raise "
                "physics.iterations or physics_hz",
            )

    def _check_tumbling(self, tumbling: Tumbling) -> None:
        if not tumbling.bodies:
            self._tumbling = None
            return
        model, data = self._engine.model, self._engine.data
        if tumbling.slow(model, data):
            return
        worst = tumbling.worst(model, data)
        if worst.share > LOST:
            self._tumbling = None
            much = f"{min(worst.share, 10.0 if worst.grows else 1.0):.0%} a second"
            effect = f"its wobble grows by {much}" if worst.grows else f"it loses {much} of its angular momentum"
            better = "" if model.opt.integrator == RK4 else ", or set physics.integrator to rk4"
            self._warn(
                "spin-too-fast",
                self._engine.body_name(worst.body),
                f"it turns by {worst.turn:.2g} rad in a step, and so {effect}; raise physics_hz{better}",
            )

    def _find_lost(self) -> None:
        engine = self._engine
        places = engine.data.xpos[1 : 1 + len(engine.body_paths)]
        if np.abs(places).max(initial=0.0) <= FAR:
            return
        for row in np.flatnonzero((np.abs(places) > FAR).any(axis=1)).tolist():
            path = engine.body_paths[row]
            self._warn(
                "body-far-away",
                path,
                f"it is more than {FAR / 1000:g} km from the origin at {float(engine.data.time):.6g} s of physics; "
                "give it something to rest on, or shorten the run",
            )
