"""Which colliders overlap a box that is in no model: each that is near is copied, once, into a model beside a box."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim import transforms
from graph.sim.physics.protocol import RayHit
from graph.sim.transforms import Floats, apply

from .geoms import GEOMS
from .library import mujoco
from .triggers import GROUP

if TYPE_CHECKING:
    from .engine import MujocoEngine

MOST_STEPS = 200
"""Of a swept sphere towards one shape; it comes near a flat face in one step, and past an edge in a few dozen."""
TOUCHES = 1e-6
"""The distance [m] at which a swept sphere has arrived."""
_MEMORY = 1 << 20
"""For the contacts of a model of two [bytes]; a query uses a few KiB."""


class BoxQueries:
    """Finds what overlaps a box or a sphere, with MuJoCo's own distance between two convex shapes.

    Triggers, geoms that collide with nothing, height fields and deformables are left out.
    """

    def __init__(self, engine: MujocoEngine, shape: Any = mujoco.mjtGeom.mjGEOM_BOX) -> None:
        self._shape = shape
        model = engine.model
        collides = (model.geom_contype | model.geom_conaffinity).astype(bool)
        known = np.isin(model.geom_type, [int(kind) for kind in GEOMS.values()])
        self._geoms = np.flatnonzero(collides & known & (model.geom_group != GROUP))
        planes = model.geom_type[self._geoms] == mujoco.mjtGeom.mjGEOM_PLANE
        self._radii = np.where(planes, np.inf, model.geom_rbound[self._geoms])
        self._engine = engine
        self._pairs: dict[int, tuple[Any, Any]] = {}

    def overlapping(self, pose: Floats, half: Floats) -> list[tuple[str, str]]:
        """The paths of the colliders and of their bodies (empty: static); see `PhysicsEngine.overlapping`."""
        engine = self._engine
        engine.place_geoms()
        rotation, data = pose[:3, :3], engine.data
        centers = apply(rotation.T, data.geom_xpos[self._geoms] - pose[:3, 3])
        gaps = np.linalg.norm(centers - np.clip(centers, -half, half), axis=1)
        found: dict[tuple[str, str], None] = {}
        for row in np.flatnonzero(gaps <= self._radii).tolist():
            geom = int(self._geoms[row])
            owner = engine.colliders[geom]
            turn = rotation.T @ data.geom_xmat[geom].reshape(3, 3)
            if owner not in found and self._overlaps(geom, centers[row], turn, half):
                found[owner] = None
        return list(found)

    def swept(self, origin: Floats, direction: Floats, radius: float, most: float) -> list[RayHit]:
        """The first hit of a sphere on each collider, the nearest first; see `PhysicsEngine.sphere_hits`.

        The sphere goes on by its distance from the shape, until it touches it: it cannot miss a convex shape.
        """
        engine = self._engine
        engine.place_geoms()
        data = engine.data
        found: dict[tuple[str, str], RayHit] = {}
        offsets = data.geom_xpos[self._geoms] - origin
        along = np.clip(apply(direction[None], offsets)[:, 0], 0, most)
        gaps = np.linalg.norm(offsets - along[:, None] * direction, axis=1)
        for row in np.flatnonzero(gaps <= self._radii + radius).tolist():
            geom = int(self._geoms[row])
            if hit := self._first_touch(geom, origin, direction, radius, most):
                collider, body = owner = engine.colliders[geom]
                if owner not in found or hit[0] < found[owner].distance:
                    found[owner] = RayHit(collider, body, *hit)
        return sorted(found.values(), key=lambda one: (one.distance, one.collider))

    def _first_touch(
        self, geom: int, origin: Floats, direction: Floats, radius: float, most: float
    ) -> tuple[float, Floats, Floats] | None:
        """How far a sphere goes until it touches a geom, the point and the normal there; None if it never does."""
        model, data = self._pair(geom, np.full(3, radius))
        at, turn = self._engine.data.geom_xpos[geom], self._engine.data.geom_xmat[geom].reshape(3, 3)
        data.mocap_quat[0] = transforms.quaternion(turn)
        gone, ends = 0.0, np.zeros(6)
        for _ in range(MOST_STEPS):
            center = origin + gone * direction
            data.mocap_pos[0] = at - center
            mujoco.mj_kinematics(model, data)
            gap = mujoco.mj_geomDistance(model, data, 0, 1, 1e9, ends)
            if gap < TOUCHES:
                if gone == 0.0:
                    return 0.0, origin, -direction
                point = ends[3:] + center
                return gone, point, (center - point) / np.linalg.norm(center - point)
            gone += gap
            if gone > most or (gap > 0 and (center - at) @ direction > self._radius(geom) + radius):
                return None
        return None

    def _radius(self, geom: int) -> float:
        return float(self._radii[np.searchsorted(self._geoms, geom)])

    def _overlaps(self, geom: int, place: Floats, turn: Floats, half: Floats) -> bool:
        """Whether a geom at this place, in the axes of the box, overlaps a box about the origin."""
        model, data = self._pair(geom, half)
        data.mocap_pos[0], data.mocap_quat[0] = place, transforms.quaternion(turn)
        mujoco.mj_kinematics(model, data)
        return bool(mujoco.mj_geomDistance(model, data, 0, 1, 1e-6, None) < 0)

    def _pair(self, geom: int, half: Floats) -> tuple[Any, Any]:
        """The model of the box or sphere of this size beside a geom, and its data."""
        if geom not in self._pairs:
            self._pairs[geom] = _beside_a(self._shape, self._engine.model, geom)
        model, data = self._pairs[geom]
        model.geom_size[0], model.geom_rbound[0] = half, np.linalg.norm(half)
        return model, data


def _beside_a(shape: Any, model: Any, geom: int) -> tuple[Any, Any]:
    """A model of a box or sphere, geom 0, and a copy of a geom on a body that is placed by hand; and its data."""
    spec = mujoco.MjSpec()
    spec.memory = _MEMORY
    spec.worldbody.add_geom(type=shape, size=[1, 1, 1])
    copy = spec.worldbody.add_body(mocap=True).add_geom(type=int(model.geom_type[geom]))
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        points = model.mesh_vert[first : first + count].astype(np.float64).ravel()
        spec.add_mesh(name="copy", uservert=points, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
        copy.meshname = "copy"
    else:
        copy.size = model.geom_size[geom]
    beside = spec.compile()
    return beside, mujoco.MjData(beside)
