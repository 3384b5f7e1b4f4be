"""Finds whether anything lies between points and lights."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sensors.compiled import compiled

from .rays import RayBundle
from .world import CastWorld

REACH = 0.9999
"""Fraction of the way to a light that is checked: the shape of the light itself casts no shadow."""


class Shadows:
    """The world in one state, for any number of rays from points near `origin` (3,) float64 [m].

    Solids cast the shadows of their triangles, which lie inside: no point on a solid is in a shadow of its own.
    """

    def __init__(self, world: CastWorld, exclude: frozenset[str]) -> None:
        self.world = world
        """The geometry of the world."""
        self._world, self._exclude = world.facets, exclude

    def blocked(
        self, origin: np.ndarray, points: np.ndarray, ways: np.ndarray, some: np.ndarray, state: Any, *, far: bool
    ) -> np.ndarray:
        """(k,) bool of `some` (k,) of the points.

        points: (3, n) float32 [m] from `origin`; ways: (3, n) float32, to the light, or the unit direction (3, 1) of
        one that is infinitely `far`.
        """
        world, reach = self._world, np.inf if far else REACH
        rays, offsets = np.empty((len(some), 6), np.float32), np.empty((len(some), 3), np.float32)
        found, lengths = np.zeros(len(some), bool), np.full(len(some), np.inf, np.float32)
        bundle = RayBundle(origin, rays, offsets, self._exclude)
        anchor, static = (origin, None) if world.device else world.static_scene(origin, self._exclude)
        _start(rays, offsets, points, ways, some, (origin - anchor).astype(np.float32))
        if static is not None:
            found = static.blocked(rays, reach, world.threads)
        if not far:
            _to_unit(rays, lengths, reach)
        if world.device:
            return np.asarray(world.cast(bundle, state).distance < lengths)
        lengths[found] = 0
        return np.asarray(found | world.blocked(bundle, lengths, state))


@compiled
def _start(
    rays: np.ndarray, offsets: np.ndarray, points: np.ndarray, ways: np.ndarray, some: np.ndarray, shift: np.ndarray
) -> None:
    """Rays (k, 6) from `some` (k,) of the points (3, n), shifted, along their ways (3, n) or the one way (3, 1).

    offsets: (k, 3) of the points without the shift.
    """
    one = ways.shape[1] == 1
    for ray, point in enumerate(some):
        for axis in range(3):
            offsets[ray, axis] = points[axis, point]
            rays[ray, axis] = points[axis, point] + shift[axis]
            rays[ray, 3 + axis] = ways[axis, 0 if one else point]


@compiled
def _to_unit(rays: np.ndarray, lengths: np.ndarray, reach: float) -> None:
    """Makes the directions of rays (n, 6) unit vectors, and writes `reach` times their lengths."""
    for ray in range(len(rays)):
        x, y, z = rays[ray, 3], rays[ray, 4], rays[ray, 5]
        length = math.sqrt(x * x + y * y + z * z)
        lengths[ray] = reach * length
        for axis in range(3):
            rays[ray, 3 + axis] /= length
