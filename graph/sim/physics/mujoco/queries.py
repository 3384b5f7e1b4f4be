"""Queries of an engine: contacts, colliders inside triggers, boxes and spheres, and those that rays and spheres hit.

A box or sphere is in no model: each collider near it is copied, once, into a model beside the box.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim import transforms
from graph.sim.physics.protocol import Contacts, PhysicsEngine, RayHit
from graph.sim.transforms import Floats, apply

from .geoms import GEOMS
from .library import mujoco

if TYPE_CHECKING:
    from .compile import Compiled

GROUP = 5
"""The model's group of triggers; rays of grippers ignore it."""

SOLID = np.array([group != GROUP for group in range(mujoco.mjNGROUP)], dtype=np.uint8)
"""Groups that rays hit."""


MOST_STEPS = 200
"""Of a swept sphere towards one shape; it comes near a flat face in one step, and past an edge in a few dozen."""
TOUCHES = 1e-6
"""The distance [m] at which a swept sphere has arrived."""
_MEMORY = 1 << 20
"""For the contacts of a model of two [bytes]; a query uses a few KiB."""


class EngineQueries(PhysicsEngine):
    """Which colliders touch, overlap, or are hit; `PhysicsEngine` documents the methods."""

    model: Any
    data: Any
    compiled: Compiled

    def place_geoms(self) -> None:
        """Brings bodies and geoms to the present state."""

    @cached_property
    def colliders(self) -> list[tuple[str, str]]:
        """For each geom, the paths of its collider and of its body (empty: static)."""
        known, bodies, out = self.compiled.geom_paths, self.body_paths, []
        for geom, body in enumerate(self.model.geom_bodyid.tolist()):
            path = known.get(geom) or self.model.geom(geom).name.rpartition("#")[0]
            out.append((path, bodies[body - 1] if 0 < body <= len(bodies) else ""))
        return out

    def contacts(self) -> Contacts:
        """The contacts with forces in the last step."""
        model, data, known = self.model, self.data, self.colliders
        contacts = data.contact
        active = np.flatnonzero(np.asarray(contacts.efc_address)[: data.ncon] >= 0)
        wrenches = np.zeros((len(active), 6))
        for row, index in enumerate(active.tolist()):
            mujoco.mj_contactForce(model, data, index, wrenches[row])
        frames = np.asarray(contacts.frame)[active].reshape(-1, 3, 3)
        geoms, flexes = np.asarray(contacts.geom)[active].tolist(), np.asarray(contacts.flex)[active].tolist()
        sides = [
            [known[one] if one >= 0 else (model.flex(soft).name, "") for one, soft in zip(geom, flex, strict=True)]
            for geom, flex in zip(geoms, flexes, strict=True)
        ]
        return Contacts(
            tuple((first[0], second[0]) for first, second in sides),
            tuple((first[1], second[1]) for first, second in sides),
            np.asarray(contacts.pos)[active].copy(),
            frames[:, 0].copy(),
            np.asarray(contacts.dist)[active].copy(),
            np.einsum("ni,nij->nj", wrenches[:, :3], frames),
            float(model.opt.timestep),
        )

    def triggered(self) -> dict[str, tuple[str, ...]]:
        """By the path of each trigger, the paths of the colliders that overlap it now, in the order of the model.

        Colliders of its own body are left out, and static colliders if the trigger is static too.
        """
        model, data = self.model, self.data
        triggers = np.flatnonzero((model.geom_group == GROUP) & (model.geom_contype == 0))
        if not len(triggers):
            return {}
        self.place_geoms()
        solid = np.flatnonzero((model.geom_group != GROUP) & (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE))
        still = model.body_weldid[model.geom_bodyid] == 0
        still &= model.body_mocapid[model.geom_bodyid] < 0
        found: dict[str, dict[str, None]] = {}
        fromto = np.zeros(6)
        for trigger in triggers.tolist():
            inside = found.setdefault(self.colliders[trigger][0], {})
            apart = np.linalg.norm(data.geom_xpos[solid] - data.geom_xpos[trigger], axis=1)
            near = solid[apart <= model.geom_rbound[solid] + model.geom_rbound[trigger]]
            for other in near.tolist():
                if model.geom_bodyid[other] == model.geom_bodyid[trigger] != 0 or (still[other] and still[trigger]):
                    continue
                if mujoco.mj_geomDistance(model, data, trigger, other, 1e-6, fromto) < 0:
                    inside[self.colliders[other][0]] = None
        return {path: tuple(inside) for path, inside in found.items()}

    def ray_hits(self, origin: Floats, direction: Floats, most: float) -> list[RayHit]:
        """The first hit on each collider, the nearest first."""
        model, data = self.model, self.data
        self.place_geoms()
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
            distance = _distance(model, data, geom, origin, direction, normal)
            if 0 <= distance <= most:
                if normal @ direction > 0:  # it leaves the shape here, so it began inside
                    distance, normal = 0.0, -direction
                collider, body = owner = self.colliders[geom]
                if owner not in found or distance < found[owner].distance:
                    found[owner] = RayHit(collider, body, distance, origin + distance * direction, normal)
        return sorted(found.values(), key=lambda hit: (hit.distance, hit.collider))

    @cached_property
    def _boxes(self) -> ShapeQueries:
        return ShapeQueries(self, mujoco.mjtGeom.mjGEOM_BOX)

    @cached_property
    def _spheres(self) -> ShapeQueries:
        return ShapeQueries(self, mujoco.mjtGeom.mjGEOM_SPHERE)

    def overlapping(self, pose: Floats, half: Floats) -> list[tuple[str, str]]:
        """Paths of the colliders in a box and of their bodies."""
        return self._boxes.overlapping(pose, half)

    def overlapping_sphere(self, center: Floats, radius: float) -> list[tuple[str, str]]:
        """Paths of the colliders in a sphere and of their bodies."""
        return self._spheres.overlapping(transforms.rigid(np.eye(3), center), np.full(3, radius))

    def sphere_hits(self, origin: Floats, direction: Floats, radius: float, most: float) -> list[RayHit]:
        """The colliders that a swept sphere hits."""
        return self._spheres.swept(origin, direction, radius, most)


class ShapeQueries:
    """Finds what overlaps a box or a sphere, with MuJoCo's own distance between two convex shapes.

    Triggers, geoms that collide with nothing, height fields and deformables are left out.
    """

    def __init__(self, engine: EngineQueries, shape: Any) -> None:
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


def _distance(model: Any, data: Any, geom: int, origin: Floats, direction: Floats, normal: Floats) -> float:
    """The distance [m] at which a ray meets one geom, and the normal there; -1 if it misses."""
    kind = model.geom_type[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return float(mujoco.mj_rayMesh(model, data, geom, origin, direction, normal))
    if kind == mujoco.mjtGeom.mjGEOM_HFIELD:
        return float(mujoco.mj_rayHfield(model, data, geom, origin, direction, normal))
    place, size = data.geom_xpos[geom], model.geom_size[geom]
    return float(mujoco.mju_rayGeom(place, data.geom_xmat[geom], size, origin, direction, int(kind), normal))
