"""Where moving surfaces are as seen from the origin of rays, and which rays may meet them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .rays import MARGIN_RAD, RayBundle
from .windows import RayGrid

_SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)


@dataclass(frozen=True, slots=True)
class Places:
    """Positions of m moving surfaces, seen from a bundle's origin; of p bundles each array begins with an axis of p.

    towards: (m, 3) float64 [m] to the centres of their spheres, world axes; distance: (m,) [m] to them, more than 0;
    radius: (m,) [m], enlarged by the spread of the rays' origins; half: (m,) [rad], of the cone that holds each.
    """

    towards: np.ndarray
    distance: np.ndarray
    radius: np.ndarray
    half: np.ndarray

    def some(self, rows: slice) -> Places:
        """Those of some of the surfaces."""
        return Places(self.towards[rows], self.distance[rows], self.radius[rows], self.half[rows])


class Bounds:
    """Boxes (m, 2, 3) [m] around m moving surfaces, and spheres about the boxes' centres; in the frames of bodies.

    radii: (m,) [m] of the spheres; bodies: (m,), which body carries each.
    """

    def __init__(self, boxes: np.ndarray, radii: np.ndarray, bodies: np.ndarray) -> None:
        self.centres, half = boxes.mean(axis=1), (boxes[:, 1] - boxes[:, 0]) / 2
        self.radii, self.bodies = radii, bodies
        points = np.concatenate([self.centres[:, None], self.centres[:, None] + half[:, None] * _SIGNS], axis=1)
        self._points = np.ascontiguousarray(np.swapaxes(points, 1, 2))  # (m, 3, 9): centre and corners of each box
        self._turned: tuple[bytes, np.ndarray, np.ndarray] | None = None
        """The bodies' poses that were last asked for, and the points turned and their shifts by these."""

    def places(self, rays: RayBundle, poses: np.ndarray) -> Places:
        """Where they are with the bodies at `poses` (b, 4, 4) float64 [m]."""
        return self._places(rays.origin, rays.spread(), rays.swing, poses)

    def places_of(self, parts: Sequence[RayBundle], poses: np.ndarray) -> Places:
        """The same for p bundles of rays, each of which starts at one place."""
        origins = np.stack([part.origin for part in parts])
        return self._places(origins[:, None], 0.0, max(part.swing for part in parts), poses)

    def _places(self, origins: np.ndarray, spread: float, swing: float, poses: np.ndarray) -> Places:
        key = poses.tobytes()
        if self._turned is None or self._turned[0] != key:
            self._turned = key, poses[self.bodies, :3, :3] @ self._points, poses[self.bodies, :3, 3]
        _, turned, moved = self._turned
        points = turned + (moved - origins)[..., None]
        towards = points[..., 0]
        lengths = np.maximum(np.sqrt((points * points).sum(axis=-2)), 1e-12)
        distance = lengths[..., 0]
        radius = self.radii + spread
        half = np.arcsin(np.minimum(radius / distance, 1.0))
        half[distance <= radius * 1.001] = np.pi
        if not spread:  # any cone of less than a right angle that holds a box's corners holds the box
            along = (points[..., 1:] * towards[..., None]).sum(axis=-2) / lengths[..., 1:]
            cosine = along.min(axis=-1) / distance
            corners = np.arccos(np.clip(cosine, -1.0, 1.0))
            half = np.where(cosine > 1e-3, np.minimum(half, corners), half)
        return Places(towards, distance, radius, half + (MARGIN_RAD + swing))


def may_meet(parts: Sequence[RayBundle], places: Places) -> np.ndarray:
    """(p, m) bool, whether rays of p bundles may go into the cones of the surfaces, placed for each of them."""
    cones = [part.cone or (np.array([0.0, 0.0, 1.0]), np.pi) for part in parts]
    axes, angles = np.stack([axis for axis, _ in cones]), np.array([[angle] for _, angle in cones])
    between = np.arccos(np.clip((places.towards * axes[:, None]).sum(axis=2) / places.distance, -1.0, 1.0))
    return np.asarray(between <= places.half + (angles + MARGIN_RAD))


def windows_of(
    parts: Sequence[RayBundle], places: Places, which: np.ndarray, sensor: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(index, pair): as `windows`, for the surfaces `which` (k,) as the bundles `sensor` (k,) see them; pair: of these.

    index: counted through all bundles, whose grids differ in how they are turned only.
    """
    grids = [part.grid or RayGrid(part.directions.T) for part in parts]
    turns = np.stack([grid.rotation for grid in grids])[sensor]
    axes = (places.towards[sensor, which, None] @ turns)[:, 0]
    index, counts = grids[0].near_local(axes, places.half[sensor, which])
    pair = np.repeat(np.arange(len(which)), counts)
    return index + len(parts[0].table) * sensor.take(pair), pair


def windows(rays: RayBundle, places: Places, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(index, owner) of rays that may lie in the cones of the surfaces `which`, and some more; sorted by owner."""
    grid = rays.grid if rays.grid is not None else RayGrid(rays.directions.T)
    index, counts = grid.near(places.towards[which], places.half[which])
    owner = np.repeat(which, counts)
    if rays.first or len(rays.table) < grid.count:
        inside = np.flatnonzero((index >= rays.first) & (index < rays.first + len(rays.table)))
        index, owner = index[inside] - rays.first, owner[inside]
    return index, owner
