"""The stage as something rays can hit: static geometry built once, moving geometry only where it moved."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from graph.sim.geometry import Mesh, Plane

from .bodies import HEAVY_TRIANGLES, HeavyBodies, LightBodies, Moving, Spheres
from .nearest import Nearest
from .planes import cast_plane
from .rays import NO_SURFACE, Hits, RayBundle
from .triangles import TriangleScene

GRID_M = 1000.0
"""Scenes are built around the points of this grid, each sensor using the one nearest to it: rays and vertices are
shifted in float64 before they are rounded to float32, so precision is the same everywhere in the world."""

KEPT_SCENES = 32
"""Static scenes kept for (anchor, exclude) pairs; the one not used for longest goes first."""


class CastWorld:
    """Casts against one collection of geometry.

    geometry: meshes and infinite planes; those with a body move with it. poses: gives the bodies' poses, (b, 4, 4)
    float64 world [m] in the order of `bodies`, for a snapshot (None: now). threads: rays are cast on so many (0: all).
    `surfaces` lists the geometry in the order of the indices in `Hits.surface`.
    """

    def __init__(
        self,
        geometry: Sequence[Mesh | Plane],
        poses: Callable[[Any], np.ndarray] | None = None,
        threads: Callable[[], int] = lambda: 0,
    ) -> None:
        self.surfaces = tuple(geometry)
        self.bodies = tuple(dict.fromkeys(str(surface.body) for surface in geometry if surface.body is not None))
        number = {body: index for index, body in enumerate(self.bodies)}
        self.body_of = np.array([number.get(str(s.body), -1) if s.body else -1 for s in geometry] or [-1], np.int32)
        self.cache: dict[str, Any] = {}
        """What users of the world have worked out about its surfaces."""
        self._poses = poses
        self._threads = threads
        self._sets: OrderedDict[tuple[bytes, frozenset[str]], _Scenes] = OrderedDict()
        moving = [
            Moving(surface, index, int(self.body_of[index]))
            for index, surface in enumerate(self.surfaces)
            if isinstance(surface, Mesh) and surface.body is not None and len(surface.triangles)
        ]
        self.lights = [entry for entry in moving if not is_heavy(entry.mesh)]
        copies: dict[Any, list[Moving]] = {}
        for entry in moving:
            if is_heavy(entry.mesh):
                copies.setdefault(entry.mesh.unique_key, []).append(entry)
        groups = list(copies.values())
        self._spheres = Spheres([*self.lights, *(entry for group in groups for entry in group)])
        self._heavy = HeavyBodies(groups, self._spheres, len(self.lights))
        self._planes = [(index, s) for index, s in enumerate(self.surfaces) if isinstance(s, Plane)]

    def cast(self, rays: RayBundle, poses: Any = None, *, normals: bool = False, surfaces: bool = False) -> Hits:
        """Nearest hits; see `RayCaster`. Normals follow the winding, in world axes."""
        anchor = np.round(rays.origin / GRID_M) * GRID_M
        scenes = self._scenes(anchor, rays.exclude)
        threads = self._threads()
        table = rays.table
        if scenes.static or scenes.light:
            rays.start_at((rays.origin - anchor).astype(np.float32))
        nearest = Nearest(len(table), normals=normals, surfaces=surfaces)
        if scenes.static:
            nearest.add(scenes.static.cast(table, threads), scenes.static_surface)
        body_poses = self._poses(poses) if self.bodies and self._poses else None
        for index, plane in self._planes:
            if index not in scenes.skip:
                self._add_plane(nearest, index, plane, rays, body_poses)
        if len(self._spheres.bodies) and body_poses is not None:
            self._add_bodies(nearest, scenes, rays, anchor, body_poses)
        return nearest.hits()

    def _add_bodies(
        self, nearest: Nearest, scenes: _Scenes, rays: RayBundle, anchor: np.ndarray, poses: np.ndarray
    ) -> None:
        threads, spheres = self._threads(), self._spheres
        centres = spheres.centres(poses)
        index, owner = spheres.windows(rays, centres, scenes.skip)
        lights = len(self.lights)
        split = int(np.searchsorted(owner, lights))
        if scenes.light:
            scenes.light.cast(rays, index[:split], anchor, poses, threads, nearest)
        heavy = index[split:], owner[split:] - lights
        self._heavy.cast(rays, heavy, centres[lights:], poses, threads, nearest)

    def _add_plane(
        self, nearest: Nearest, index: int, plane: Plane, rays: RayBundle, body_poses: np.ndarray | None
    ) -> None:
        origin, normal = np.asarray(plane.origin, np.float64), np.asarray(plane.normal, np.float64)
        body = self.body_of[index]
        if body >= 0 and body_poses is not None:
            pose = body_poses[body]
            origin, normal = pose[:3, :3] @ origin + pose[:3, 3], pose[:3, :3] @ normal
        height = float((rays.origin - origin) @ normal)
        nearest.add_surface(cast_plane(height, rays.offsets, rays.directions, normal), normal, index)

    def _scenes(self, anchor: np.ndarray, exclude: frozenset[str]) -> _Scenes:
        key = (anchor.tobytes(), exclude)
        scenes = self._sets.get(key)
        if scenes is None:
            while len(self._sets) >= KEPT_SCENES:
                self._sets.popitem(last=False)
            scenes = self._sets[key] = _Scenes(self, anchor, exclude)
        else:
            self._sets.move_to_end(key)
        return scenes


def is_heavy(mesh: Mesh) -> bool:
    """Whether a moving mesh has enough triangles to be cast in its own frame: decided by data, never by load."""
    return len(mesh.triangles) >= HEAVY_TRIANGLES


def excluded(path: str, exclude: frozenset[str]) -> bool:
    """Whether a prim is one of the excluded ones or lies below one."""
    return any(path == other or path.startswith(f"{other}/") for other in exclude)


class _Scenes:
    """The static scene and the light bodies for one anchor and exclude set."""

    def __init__(self, world: CastWorld, anchor: np.ndarray, exclude: frozenset[str]) -> None:
        self.skip = frozenset(i for i, s in enumerate(world.surfaces) if exclude and excluded(str(s.path), exclude))
        static = [
            (i, s)
            for i, s in enumerate(world.surfaces)
            if isinstance(s, Mesh) and s.body is None and i not in self.skip and len(s.triangles)
        ]
        moving = [entry for entry in world.lights if entry.surface not in self.skip]
        self.static: TriangleScene | None = None
        self._surface = np.zeros(0, np.int32)
        if static:
            vertices = [(np.asarray(s.vertices, np.float64) - anchor).astype(np.float32) for _, s in static]
            starts = np.cumsum([0, *(len(v) for v in vertices)]).astype(np.uint32)
            triangles = [np.asarray(s.triangles, np.uint32) + at for (_, s), at in zip(static, starts, strict=False)]
            self.static = TriangleScene(np.concatenate(vertices), np.concatenate(triangles))
            surfaces, counts = [i for i, _ in static], [len(t) for t in triangles]
            self._surface = np.repeat(np.array([*surfaces, NO_SURFACE], np.int32), [*counts, 1])
        self.light: LightBodies | None = None
        if moving:
            self.light = LightBodies(moving)

    def static_surface(self, triangle: np.ndarray) -> np.ndarray:
        """The surface of each triangle index of the static scene; `NO_SURFACE` for indices beyond its triangles."""
        return np.take(self._surface, triangle, mode="clip")
