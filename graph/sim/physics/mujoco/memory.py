"""The memory that MuJoCo takes for contacts and for the state of a model."""

from __future__ import annotations

from typing import Any

from graph.base.errors import UserError

from .library import mujoco

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
