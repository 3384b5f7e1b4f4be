"""Triggers: colliders without contact forces, whose content can be queried."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .library import mujoco

if TYPE_CHECKING:
    from .engine import MujocoEngine

GROUP = 5
"""The model's group of triggers; rays of grippers ignore it."""

SOLID = np.array([group != GROUP for group in range(mujoco.mjNGROUP)], dtype=np.uint8)
"""Groups that rays hit."""


def triggered(engine: MujocoEngine) -> dict[str, tuple[str, ...]]:
    """By the path of each trigger, the paths of the colliders that overlap it now, in the order of the model.

    Colliders of its own body are left out, and static colliders if the trigger is static too.
    """
    model, data = engine.model, engine.data
    triggers = np.flatnonzero((model.geom_group == GROUP) & (model.geom_contype == 0))
    if not len(triggers):
        return {}
    assert len(engine.positions) >= 0  # geoms are at the present poses of the bodies
    solid = np.flatnonzero((model.geom_group != GROUP) & (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE))
    still = model.body_weldid[model.geom_bodyid] == 0
    still &= model.body_mocapid[model.geom_bodyid] < 0
    found: dict[str, dict[str, None]] = {}
    fromto = np.zeros(6)
    for trigger in triggers.tolist():
        inside = found.setdefault(engine.colliders[trigger][0], {})
        apart = np.linalg.norm(data.geom_xpos[solid] - data.geom_xpos[trigger], axis=1)
        near = solid[apart <= model.geom_rbound[solid] + model.geom_rbound[trigger]]
        for other in near.tolist():
            if model.geom_bodyid[other] == model.geom_bodyid[trigger] != 0 or (still[other] and still[trigger]):
                continue
            if mujoco.mj_geomDistance(model, data, trigger, other, 1e-6, fromto) < 0:
                inside[engine.colliders[other][0]] = None
    return {path: tuple(inside) for path, inside in found.items()}
