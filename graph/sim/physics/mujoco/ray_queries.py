"""Which colliders a ray hits, with MuJoCo's rays at single geoms: every collider on the way, not the nearest alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graph.sim.physics.protocol import RayHit
from graph.sim.transforms import Floats, apply

from .library import mujoco
from .triggers import GROUP

if TYPE_CHECKING:
    from .engine import MujocoEngine


def ray_hits(engine: MujocoEngine, origin: Floats, direction: Floats, most: float) -> list[RayHit]:
    """The first hit on each collider, the nearest first; see `PhysicsEngine.ray_hits`."""
    model, data = engine.model, engine.data
    engine.place_geoms()
    collides = (model.geom_contype | model.geom_conaffinity).astype(bool) & (model.geom_group != GROUP)
    geoms = np.flatnonzero(collides)
    offsets = data.geom_xpos[geoms] - origin
    along = np.clip(apply(direction[None], offsets)[:, 0], 0, most)
    gaps = np.linalg.norm(offsets - along[:, None] * direction, axis=1)
    planes = model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_PLANE
    near = geoms[planes | (gaps <= model.geom_rbound[geoms])]
    found: dict[tuple[str, str], RayHit] = {}
    for geom in near.tolist():
        normal = np.zeros(3)
        distance = _distance(engine, geom, origin, direction, normal)
        if 0 <= distance <= most:
            if normal @ direction > 0:  # it leaves the shape here, so it began inside
                distance, normal = 0.0, -direction
            collider, body = owner = engine.colliders[geom]
            if owner not in found or distance < found[owner].distance:
                found[owner] = RayHit(collider, body, distance, origin + distance * direction, normal)
    return sorted(found.values(), key=lambda hit: (hit.distance, hit.collider))


def _distance(engine: MujocoEngine, geom: int, origin: Floats, direction: Floats, normal: Floats) -> float:
    """The distance [m] at which a ray meets one geom, and the normal there; -1 if it misses."""
    model, data = engine.model, engine.data
    kind = model.geom_type[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return float(mujoco.mj_rayMesh(model, data, geom, origin, direction, normal))
    if kind == mujoco.mjtGeom.mjGEOM_HFIELD:
        return float(mujoco.mj_rayHfield(model, data, geom, origin, direction, normal))
    place, size = data.geom_xpos[geom], model.geom_size[geom]
    return float(mujoco.mju_rayGeom(place, data.geom_xmat[geom], size, origin, direction, int(kind), normal))
