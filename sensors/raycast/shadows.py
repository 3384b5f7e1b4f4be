"""Finds whether anything lies between points and lights."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.geometry.collect import Mesh
from sensors.compiled import compiled

from .planes import cast_plane
from .rays import RayBundle
from .standing import excluded
from .triangles import TriangleScene
from .world import CastWorld

REACH = 0.9999
"""Fraction of the way to a light that is checked: the shape of the light itself casts no shadow."""


class Shadows:
    """The world in one state, for any number of rays from points near `origin` (3,) float64 [m].

    Solids cast the shadows of their triangles, which lie inside: no point on a solid is in a shadow of its own. Static
    geometry is the scene that nearby sensors share; all moving geometry is one more scene, kept while nothing in it
    moves.
    """

    def __init__(self, world: CastWorld, exclude: frozenset[str]) -> None:
        self.world = world
        """The geometry of the world."""
        self._world, self._exclude = world.facets, exclude
        self._moving: tuple[tuple[bytes, ...], TriangleScene] | None = None
        self._numbers = [
            number
            for number, one in enumerate(self._world.surfaces)
            if isinstance(one, Mesh)
            and len(one.triangles)
            and (one.body is not None or one.source in world.soft)
            and not excluded(str(one.path), exclude)
        ]

    def blocked(
        self, origin: np.ndarray, points: np.ndarray, ways: np.ndarray, some: np.ndarray, state: Any, *, far: bool
    ) -> np.ndarray:
        """(k,) bool of `some` (k,) of the points.

        points: (3, n) float32 [m] from `origin`; ways: (3, n) float32, to the light, or the unit direction (3, 1) of
        one that is infinitely `far`.
        """
        world, reach = self._world, np.inf if far else REACH
        if world.device is not None:
            return self._blocked_on_device(origin, points, ways, some, state, reach)
        anchor, static = world.static_scene(origin, self._exclude)
        rays = np.empty((len(some), 6), np.float32)
        found = np.zeros(len(some), bool)
        if static is not None:
            _start(rays, points, ways, some, (origin - anchor).astype(np.float32))
            found |= static.blocked(rays, reach, world.threads)
        poses, planes = world.body_poses(state), world.planes(self._exclude)
        if self._numbers or planes:
            _start(rays, points, ways, some, np.zeros(3, np.float32))
        if self._numbers:
            found |= self._moving_scene(origin, poses, state).blocked(rays, reach, world.threads)
        for number in planes:
            place, normal = world.plane(number, poses)
            height = float((origin - place) @ normal)
            found |= cast_plane(height, np.ascontiguousarray(rays[:, :3]), rays, normal) < reach
        return found

    def _blocked_on_device(
        self, origin: np.ndarray, points: np.ndarray, ways: np.ndarray, some: np.ndarray, state: Any, reach: float
    ) -> np.ndarray:
        rays = np.empty((len(some), 6), np.float32)
        _start(rays, points, ways, some, np.zeros(3, np.float32))
        lengths = np.sqrt(np.square(rays[:, 3:]).sum(axis=1))
        rays[:, 3:] /= lengths[:, None]
        bundle = RayBundle(origin, rays, np.ascontiguousarray(rays[:, :3]), self._exclude)
        found: np.ndarray = self._world.cast(bundle, state).distance < reach * lengths
        return found

    def _moving_scene(self, origin: np.ndarray, poses: np.ndarray | None, state: Any) -> TriangleScene:
        placed = [self._world.vertices(number, poses, state) - origin for number in self._numbers]
        key = tuple(points.tobytes() for points in placed) if sum(map(len, placed)) < 100_000 else (b"",)
        if self._moving is None or self._moving[0] != key or key == (b"",):
            starts = np.cumsum([0, *(len(points) for points in placed)])
            triangles = [
                np.asarray(self._world.surfaces[number].triangles, np.uint32) + np.uint32(start)  # type: ignore[union-attr]
                for number, start in zip(self._numbers, starts, strict=False)
            ]
            self._moving = None  # the old scene goes before the next is made
            vertices = np.concatenate(placed).astype(np.float32)
            self._moving = key, TriangleScene(vertices, np.concatenate(triangles), warm=False)
        return self._moving[1]


@compiled
def _start(rays: np.ndarray, points: np.ndarray, ways: np.ndarray, some: np.ndarray, shift: np.ndarray) -> None:
    """Rays (k, 6) from `some` (k,) of the points (3, n), shifted, along their ways (3, n) or the one way (3, 1)."""
    one = ways.shape[1] == 1
    for ray, point in enumerate(some):
        for axis in range(3):
            rays[ray, axis] = points[axis, point] + shift[axis]
            rays[ray, 3 + axis] = ways[axis, 0 if one else point]
