"""The message about a simulation that diverged: the body, the time, the likely cause, what to do."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .library import mujoco
from .overlaps import DEEP, deepest_overlap
from .step_size import EXPLICIT, RK4, unstable_drive

if TYPE_CHECKING:
    from .engine import MujocoEngine

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
