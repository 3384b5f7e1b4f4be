"""How the physics of worlds may differ on a device: fields of the model that are kept by world, and the state."""

from __future__ import annotations

import dataclasses
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.sim.physics.mujoco.speed_limits import SpeedLimits

STATE = ("qpos", "qvel", "ctrl", "mocap_pos", "mocap_quat")
"""The state in which a world begins."""

UNUSED = ("vis", "tex_", "mat_", "light_", "cam_", "geom_rgba", "site_rgba", "skin_", "bvh_", "dof_M0")
"""Fields that a step on a device does not read: what only pictures have, and trees of MuJoCo's own rays."""


@cache
def _known(kind: str) -> dict[str, bool]:
    """The fields of mujoco-warp's "Model" or "Option", and whether worlds may have values of their own for them."""
    types = import_module("mujoco_warp._src.types")
    return {
        each.name: (getattr(each.type, "shape", None) or (0,))[0] == "*"
        for each in dataclasses.fields(getattr(types, kind))
    }


def difference(first: Any, other: Any) -> dict[str, np.ndarray]:
    """What an engine has otherwise than the first: fields of the model, "opt.NAME", "data.NAME" and "drives.NAME".

    Raises UserError for what all worlds share.
    """
    if first.body_paths != other.body_paths:
        raise UserError("it changes which bodies there are, and worlds share them")
    found: dict[str, np.ndarray] = {}
    one, two = first.model, other.model
    for prefix, kind, old, new in (("", "Model", one, two), ("opt.", "Option", one.opt, two.opt)):
        known = _known(kind)
        for name in _names(old):
            here, there = np.asarray(getattr(old, name)), np.asarray(getattr(new, name))
            if np.array_equal(here, there, equal_nan=here.dtype.kind == "f") or name.startswith(UNUSED):
                continue
            if here.shape != there.shape or (name in known and not known[name]):
                raise UserError(f"it changes {name} of MuJoCo's model, which worlds share")
            if name not in known:
                continue  # MuJoCo derives it for steps of its own
            found[prefix + name] = there.copy()
    pairs = [(f"data.{name}", getattr(first.data, name), getattr(other.data, name)) for name in STATE]
    gains = "targets", "stiffness", "damping"
    pairs += [(f"drives.{name}", getattr(first.drives, name), getattr(other.drives, name)) for name in gains]
    pairs += [("drives.gains", first.drives.controls[1], other.drives.controls[1])]
    return found | {name: np.array(there) for name, here, there in pairs if not np.array_equal(here, there)}


def left_out(engine: Any) -> list[str]:
    """What the engine adds to MuJoCo's own steps in this world, which is not done on a device."""
    parts = {
        "restitution": bool(engine.compiled.restitution),
        "friction of their own for contacts at rest": engine.friction.switching,
        "greatest speeds": SpeedLimits(engine.model, engine.compiled).limited,
        "forces on bodies": bool(engine.world.forces),
        "grippers": bool(engine.compiled.grippers),
        "moving surfaces": engine.friction.surfaces is not None,
        "steps divided for chains and loops": engine.divides,
        "gentle limits of drives' forces": engine.drives.limited,
    }
    return [name for name, there in parts.items() if there]


def _names(model: Any) -> list[str]:
    """The fields of a model, or of its options, that are numbers."""
    return [n for n in dir(model) if n[0] != "_" and isinstance(getattr(model, n), np.ndarray | int | float)]
