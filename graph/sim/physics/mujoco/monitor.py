"""Warnings while physics runs: wrong forces, dropped contacts, bodies that sink, tumble too fast or are far away; and
the message about a simulation that diverged.
"""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.records import dataclass
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .body_watch import BodyWatch
from .compile import lightest_share
from .library import mujoco
from .step_size import EXPLICIT, LOST, RK4, Tumbling, unstable_drive

if TYPE_CHECKING:
    from .engine import MujocoEngine

RESIDUAL = 1.0
"""Residual of the solver's last iteration, scaled as if all bodies had the mass of the lightest, above which forces are
wrong.

Measured on towers of 20 boxes (5.7 mm of compression when solved) with decreasing iteration limits: residuals up to 0.4
changed nothing, 6 gave 10 mm more, 200 to 400 gave 160 mm and more.
"""

FAR = 1e6
"""A body farther than this [m] from the origin has left the scene."""

NEVER, ALWAYS = b"\xff" * 4, b""
"""Bytes that no counts of iterations contain, and that all do."""

WATCHED = 64
"""Most steps between two looks at how bodies move: one costs as much as a step of a small world."""

EVERY = 16
"""Most steps between two looks: after 1, 2, 4, 8, 16, 32, 48 ... steps, however many of them an update makes."""

SEARCHES = 1.0
"""Least time [s] between two searches for such bodies, and for those that sink."""

HEAVIER = 100.0
"""What bears on a body of so many times less mass presses it in: by about 5 micrometres times the ratio."""

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
"""By MuJoCo's kind of warning: our code and text. The other kinds are divergence, see `divergence`."""


class Monitor:
    """Examines an engine at fixed numbers of steps. Each of its warnings is given once.

    They do not depend on how many steps an update makes at once, so that subscribers change no warning.
    """

    def __init__(self, engine: MujocoEngine, warn: Warn) -> None:
        self._engine, self._warn, self._option = engine, warn, engine.model.opt
        self._counters = memoryview(engine.data.warning.number)
        self.iterations = memoryview(engine.data.solver_niter)
        """The solver's iterations in each island of the last step."""
        self.spent = NEVER
        """Bytes in them by which `check_solver` has work: a search for bytes takes a tenth of the time of a comparison
        of numbers, which is 1 % of a step.
        """
        self._steps, self._next, self._searched = 0, 1, 0
        self._ahead = True
        self._solver_told = False
        self._lightest = lightest_share(engine.model)
        self._told = set[int]()
        self._spinning = ""
        self._deep: Overlap | None = None
        self._tumbling: Tumbling | None = Tumbling(engine.model, len(engine.body_paths), engine.chains)
        self._watch: BodyWatch | None = None

    def until_look(self) -> int:
        """The number of steps until the next look. At one: warns of a body that stops tumbling in the first of them."""
        if self._ahead:
            self._ahead, self.spent = False, self._spent()
            if self._tumbling is not None:
                self._check_tumbling(self._tumbling)
        return self._next - self._steps

    def stepped(self, steps: int) -> None:
        """Counts steps that were made, up to the next look at the most; looks if it is due."""
        self._steps += steps
        if self._steps == self._next:
            self._next += min(self._steps, EVERY)
            self._ahead = True
            self._look()

    def _look(self) -> None:
        counters = self._counters
        if counters[0] or counters[1] or counters[2] or counters[6]:
            self._tell_counted()
        if self._steps < WATCHED or self._steps % WATCHED == 0:
            if self._watch is None:
                self._watch = BodyWatch(self._engine)
            self._watch.look(self._engine, self._warn)
        if (self._steps - self._searched) * self._engine.dt >= SEARCHES:
            self._searched = self._steps
            self._find_lost()
            self._find_sunk()

    def close(self) -> None:
        """Releases the engine's memory."""
        self._counters.release()
        self.iterations.release()

    def divergence(self) -> str:
        """The message about a failed step."""
        return divergence(self._engine, self._spinning)

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

    def _spent(self) -> bytes:
        option = self._option
        if self._solver_told:
            return NEVER
        if option.noslip_iterations:  # they are counted, too
            return ALWAYS
        return int(option.iterations).to_bytes(4, sys.byteorder)

    def check_solver(self) -> None:
        """Warns if the solver stopped far from the solution.

        Newton and CG report the distance from the minimum, PGS the improvement of its last iteration.
        """
        data, cap = self._engine.data, int(self._engine.model.opt.iterations)
        if max(self.iterations) < cap:
            return
        count = len(data.solver.gradient) // len(self.iterations)
        stats = data.solver
        newton = self._engine.model.opt.solver != mujoco.mjtSolver.mjSOL_PGS
        residuals: Any = stats.gradient if newton else stats.improvement
        worst = max(
            float(residuals[island * count + done - 1])
            for island, done in enumerate(self.iterations)
            if cap <= done <= count
        )
        if worst > RESIDUAL * self._lightest:
            self._solver_told, self.spent = True, NEVER
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
            self._spinning = self._engine.body_name(worst.body)
            much = f"{min(worst.share, 10.0 if worst.grows else 1.0):.0%} a second"
            effect = f"its wobble grows by {much}" if worst.grows else f"it loses {much} of its angular momentum"
            better = "" if model.opt.integrator == RK4 else ", or set physics.integrator to rk4"
            self._warn(
                "spin-too-fast",
                self._spinning,
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

    def _find_sunk(self) -> None:
        """Warns of a body that overlaps deeply at two looks: what has just collided is apart again by the second."""
        engine, before = self._engine, self._deep
        now = self._deep = deepest_overlap(engine)
        if before is None or now is None or min(before.depth, now.depth) <= DEEP:
            return
        masses, paths = engine.model.body_mass, engine.body_paths
        moved = [one for one in now.bodies if 0 < one <= len(paths) and paths[one - 1] not in engine.kinematic]
        body = min(moved, key=lambda one: float(masses[one]), default=0)
        if body not in before.bodies or not body:
            return
        other = sum(now.bodies) - body
        against = engine.body_name(other) if 0 < other <= len(paths) else "static geometry"
        load = max(partners(engine, body), key=lambda one: float(masses[one]))
        times = float(masses[load] / masses[body])
        if times > HEAVIER:
            why = f"{engine.body_name(load)}, which bears on it, has {times:.2g} times its mass"
            better = "make their masses more alike"
        else:
            why = f"contact is that soft at {1 / float(engine.dt):g} Hz"
            better = "raise physics_hz"
        self._warn(
            "bodies-sink",
            engine.body_name(body),
            f"it and {against} overlap by {now.depth:.2g} m and stay so: {why}; {better}, or lower "
            "physics.contact_softness",
        )


DEEP = 0.01
"""Bodies that overlap by more than this [m] do not rest on each other: they are pushed apart, or sink."""


@dataclass(frozen=True, slots=True)
class Overlap:
    """A pair of bodies of the model in contact, the lower number first (0: what stands), and how deep [m]."""

    bodies: tuple[int, int]
    depth: float


def deepest_overlap(engine: MujocoEngine, body: int | None = None) -> Overlap | None:
    """The deepest overlap of rigid bodies that push each other, or of one body with others; None without any."""
    sides, depths = _pushing(engine)
    if body is not None:
        depths = np.where((sides == body).any(axis=1), depths, -np.inf)
    if not depths.size or not math.isfinite(depths.max()):
        return None
    first, second = sorted(sides[depths.argmax()].tolist())
    return Overlap((first, second), float(depths.max()))


def partners(engine: MujocoEngine, body: int) -> list[int]:
    """The bodies that push a body, and the body itself."""
    sides, _ = _pushing(engine)
    return [body, *np.unique(sides[(sides == body).any(axis=1)]).tolist()]


def _pushing(engine: MujocoEngine) -> tuple[Any, Floats]:
    """The bodies (n, 2) of the contacts between rigid bodies that push, and their depths (n,) [m]."""
    contact = engine.data.contact
    geoms = np.asarray(contact.geom)
    pushes = (geoms >= 0).all(axis=1) & (np.asarray(contact.efc_address) >= 0)
    return engine.model.geom_bodyid[geoms[pushes]], -np.asarray(contact.dist, np.float64)[pushes]


_KINDS = mujoco.mjtWarning
_STATE = {
    int(_KINDS.mjWARN_BADQPOS): ("a position", "qpos"),
    int(_KINDS.mjWARN_BADQVEL): ("a velocity", "qvel"),
    int(_KINDS.mjWARN_BADQACC): ("an acceleration", "qacc"),
}
"""The kinds of warnings that mean divergence: the state that is NaN or above 1e10, and its array."""


def divergence(engine: MujocoEngine, spinning: str) -> str:
    """The message about a failed step; spinning: the path of a body that turned too fast for its steps, if any."""
    model, data = engine.model, engine.data
    kind = next(kind for kind in _STATE if data.warning.number[kind])
    place = int(data.warning[kind].lastinfo)
    if kind == int(_KINDS.mjWARN_BADQPOS):
        joint = int(np.searchsorted(model.jnt_qposadr, place, side="right")) - 1
        body = int(model.jnt_bodyid[joint])
    else:
        body = int(model.dof_bodyid[place])
    name, values = _STATE[kind]
    cause, hint = _cause(engine, body, spinning)
    return (
        f"{engine.body_name(body)}: the simulation diverged here, at {float(data.time):.6g} s of physics: "
        f"{name} became {float(getattr(data, values)[place]):.3g}{cause}. {hint}"
    )


def _cause(engine: MujocoEngine, body: int, spinning: str) -> tuple[str, str]:
    """The likely cause as the end of a sentence, and what to do."""
    if drive := unstable_drive(engine):
        path, needed = drive
        kind = EXPLICIT[int(engine.model.opt.integrator)]
        return (
            f", for the drive of {path} is too stiff for {kind} at {1 / float(engine.dt):g} Hz",
            f"Raise physics_hz to {math.ceil(needed):,}, or leave physics.integrator out",
        )
    if spinning == engine.body_name(body):
        better = "" if int(engine.model.opt.integrator) == RK4 else ", or set physics.integrator to rk4"
        return ", for it turned too far in a step", f"Raise physics_hz{better}"
    overlap = deepest_overlap(engine, body)
    if overlap is not None and overlap.depth > DEEP:
        names = [engine.body_name(one) for one in overlap.bodies if one not in (0, body)]
        against = names[0] if names else "static geometry"
        return f", for it overlapped {against} by {overlap.depth:.3g} m", "Move them apart, or raise physics_hz"
    return "", "Raise physics_hz, lower the stiffness, speeds or mass ratios around it, or move apart what overlaps"
