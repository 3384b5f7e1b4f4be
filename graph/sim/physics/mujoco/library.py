"""The one module that imports MuJoCo, and the memory that a model takes.

It also keeps MuJoCo's own warnings off the terminal and out of log files.

What a warning means for a run is read from the counters of `MjData` (see `engine`).
"""

from __future__ import annotations

import sys
from typing import Any

import mujoco  # noqa: TID253

from graph.base.errors import UserError

if mujoco.get_mju_user_warning() is None:
    mujoco.set_mju_user_warning(lambda text: None)

# Without OpenGL, MuJoCo keeps the error of its import, whose traceback would keep the first App of the process alive.
_kept = getattr(sys.modules.get("mujoco.rendering.classic.gl_context"), "_import_error", None)
while isinstance(_kept, BaseException):
    _kept.__traceback__, _kept = None, _kept.__cause__ or _kept.__context__

__all__ = ["mujoco"]

WIDTHS = {int(mujoco.mjtJoint.mjJNT_FREE): (7, 6), int(mujoco.mjtJoint.mjJNT_BALL): (4, 3)}
"""Numbers of coordinates and of velocities of the kinds of joints that do not have one of each."""

CROWD, CROWD_MEMORY, BODY_MEMORY = 1000, 2 << 30, 128 << 10
"""MuJoCo's own estimate of memory for contacts grows with the square of the number of bodies: above this number, a
model gets at least this many bytes, and so many for each body (resting boxes use 24 KiB).

Unused memory is not taken from the system.
"""


def give_memory(spec: Any, bodies: int) -> None:
    """Sets the memory for the contacts of a model of many bodies, unless its specification sets it."""
    if spec.memory < 0 and bodies > CROWD:
        spec.memory = max(CROWD_MEMORY, bodies * BODY_MEMORY)


def state_of(model: Any) -> Any:
    """The `MjData` of a model. Raises UserError if there is not enough memory for it."""
    try:
        return mujoco.MjData(model)
    except mujoco.FatalError as error:
        raise _too_little(model) from error


def forward(model: Any, data: Any) -> None:
    """Computes all that follows from a state (`mj_forward`). Raises UserError if its contacts find no memory."""
    try:
        mujoco.mj_forward(model, data)
    except mujoco.FatalError as error:
        raise _too_little(model) from error


def _too_little(model: Any) -> UserError:
    room = f"{model.narena >> 20:,} MiB for the contacts of {model.nbody - 1:,} bodies"
    return UserError(f"physics: MuJoCo cannot work with {room}; change <size memory>, or use fewer bodies")
