"""Finds whether anything lies between points and lights."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.geometry.collect import Mesh

from .planes import cast_plane
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

    def blocked(self, origin: np.ndarray, points: np.ndarray, ways: np.ndarray, state: Any, *, far: bool) -> np.ndarray:
        """(k,) bool. points:

        (k, 3) float32 [m] from `origin`; ways: (k, 3) float32, to the light, or unit directions if it is infinitely
        `far`.
        """
        world, reach = self._world, np.inf if far else REACH
        anchor, static = world.static_scene(origin, self._exclude)
        rays = np.empty((len(points), 6), np.float32)
        rays[:, 3:] = ways
        found = np.zeros(len(points), bool)
        if static is not None:
            np.add(points, (origin - anchor).astype(np.float32), out=rays[:, :3])
            found |= static.blocked(rays, reach, world.threads)
        poses = world.body_poses(state)
        if self._numbers:
            rays[:, :3] = points
            found |= self._moving_scene(origin, poses, state).blocked(rays, reach, world.threads)
        for number in world.planes(self._exclude):
            place, normal = world.plane(number, poses)
            height = float((origin - place) @ normal)
            found |= cast_plane(height, points, np.ascontiguousarray(ways.T), normal) < reach
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
