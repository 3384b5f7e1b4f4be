"""The scene queries of `omni.physx`: rays, moving spheres, spheres and boxes against the colliders, in stage units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graph.isaac.session import app
from graph.sim.physics.protocol import RayHit
from graph.sim.transforms import rigid

__all__ = ["get_physx_scene_query_interface"]
Point = tuple[float, float, float]
Report = Callable[[Any], bool]


@dataclass(frozen=True)
class OverlapHit:
    collision: str
    rigid_body: str


@dataclass(frozen=True)
class SceneQueryHit(OverlapHit):
    distance: float
    position: Point
    normal: Point
    face_index: int = -1
    material: str = ""


class _SceneQueries:
    """Before physics has started only rays hit; reports that are false end a query."""

    def raycast_closest(self, origin: Any, dir: Any, distance: float, bothSides: bool = False) -> dict[str, Any]:
        return _nearest(_ray(origin, dir, distance))

    def raycast_any(self, origin: Any, dir: Any, distance: float, bothSides: bool = False) -> bool:
        return bool(_ray(origin, dir, distance))

    def raycast_all(self, origin: Any, dir: Any, distance: float, reportFn: Report, bothSides: bool = False) -> bool:
        return _told(_ray(origin, dir, distance), reportFn) > 0

    def sweep_sphere_closest(
        self, radius: float, origin: Any, dir: Any, distance: float, bothSides: bool = False
    ) -> dict[str, Any]:
        return _nearest(_ray(origin, dir, distance, radius))

    def sweep_sphere_any(self, radius: float, origin: Any, dir: Any, distance: float, bothSides: bool = False) -> bool:
        return bool(_ray(origin, dir, distance, radius))

    def sweep_sphere_all(
        self, radius: float, origin: Any, dir: Any, distance: float, reportFn: Report, bothSides: bool = False
    ) -> bool:
        return _told(_ray(origin, dir, distance, radius), reportFn) > 0

    def overlap_sphere(self, radius: float, pos: Any, reportFn: Report, anyHit: bool = False) -> int:
        return _told(_in_sphere(radius, pos)[: 1 if anyHit else None], reportFn)

    def overlap_sphere_any(self, radius: float, pos: Any) -> bool:
        return bool(_in_sphere(radius, pos))

    def overlap_box(self, halfExtent: Any, pos: Any, rot: Any, reportFn: Report, anyHit: bool = False) -> int:
        """rot: quaternion x, y, z, w."""
        return _told(_in_box(halfExtent, pos, rot)[: 1 if anyHit else None], reportFn)

    def overlap_box_any(self, halfExtent: Any, pos: Any, rot: Any) -> bool:
        return bool(_in_box(halfExtent, pos, rot))


def get_physx_scene_query_interface() -> _SceneQueries:
    return _SceneQueries()


def _vector(values: Any) -> np.ndarray:
    return np.array([*values], np.float64)


def _unit() -> float:
    return float(app().meters_per_unit)


def _ray(origin: Any, way: Any, distance: float, radius: float = 0.0) -> list[SceneQueryHit]:
    """The first hit on each collider, the nearest first. Raises ValueError for a direction without a length."""
    engine, unit, direction = app().physics, _unit(), _vector(way)
    length = float(np.linalg.norm(direction))
    if not (np.isfinite(length) and length > 0):
        raise ValueError(f"the direction {direction.tolist()} has no length")
    start, direction, most = _vector(origin) * unit, direction / length, float(distance) * unit
    if engine is None:
        return [] if radius else _on_surfaces(start, direction, most)
    found: Sequence[RayHit] = (
        engine.sphere_hits(start, direction, float(radius) * unit, most)
        if radius
        else engine.ray_hits(start, direction, most)
    )
    return [
        SceneQueryHit(
            hit.collider,
            hit.body or hit.collider,
            hit.distance / unit,
            tuple((hit.position / unit).tolist()),
            tuple(hit.normal.tolist()),
        )
        for hit in found
    ]


def _on_surfaces(start: np.ndarray, direction: np.ndarray, most: float) -> list[SceneQueryHit]:
    """The nearest hit of a ray in a world in which nothing moves; [m]."""
    from sensors.raycast.rays import cast_ranged
    from sensors.raycast.shared import cast_world

    world = cast_world(app().world)
    hits = cast_ranged(world, start[None], direction[None], (0.0, most), normals=True)
    away = float(hits.distance[0])
    if not np.isfinite(away) or away > most or hits.normals is None:
        return []
    path, unit = world.surfaces[int(hits.surfaces()[0])].path, _unit()
    place = (start + direction * away) / unit
    return [SceneQueryHit(path, path, away / unit, tuple(place.tolist()), tuple(hits.normals[0].tolist()))]


def _in_sphere(radius: float, pos: Any) -> list[OverlapHit]:
    engine = app().physics
    found = [] if engine is None else engine.overlapping_sphere(_vector(pos) * _unit(), float(radius) * _unit())
    return [OverlapHit(collider, body or collider) for collider, body in found]


def _in_box(half: Any, pos: Any, rot: Any) -> list[OverlapHit]:
    from .transforms import quat_to_rot_matrix

    engine, (x, y, z, w) = app().physics, _vector(rot)
    if engine is None:
        return []
    pose = rigid(quat_to_rot_matrix(np.array([w, x, y, z])), _vector(pos) * _unit())
    found = engine.overlapping(pose, _vector(half) * _unit())
    return [OverlapHit(collider, body or collider) for collider, body in found]


def _nearest(hits: Sequence[SceneQueryHit]) -> dict[str, Any]:
    if not hits:
        return {"hit": False}
    one = hits[0]
    return {
        "hit": True,
        "distance": one.distance,
        "position": one.position,
        "normal": one.normal,
        "faceIndex": one.face_index,
        "rigidBody": one.rigid_body,
        "collision": one.collision,
        "material": one.material,
    }


def _told(hits: Sequence[Any], report: Report) -> int:
    """How many hits were reported, until a report is false."""
    for number, hit in enumerate(hits, start=1):
        if not report(hit):
            return number
    return len(hits)
