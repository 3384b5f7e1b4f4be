"""The protocol of ray casting: a bundle of rays goes in, nearest hits come out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

NO_SURFACE = -1


@dataclass(slots=True)
class RayBundle:
    """Rays of one geometry state.

    table: (n, 6) float32, C-contiguous; its columns 3 to 5 are the unit directions, world axes; columns 0 to 2 are
    the caster's, which writes the ray origins there, relative to where its scenes are anchored. origin: (3,) float64,
    world [m], near all ray origins. offsets: (n, 3) float32 [m], world axes, each ray's origin less `origin`; None
    where all start there. exclude: prim paths that are never hit, nor what lies below them. order: an `AzimuthOrder`
    of the directions, if the caller has one: only a speed-up.
    """

    origin: np.ndarray
    table: np.ndarray
    offsets: np.ndarray | None = None
    exclude: frozenset[str] = frozenset()
    order: AzimuthOrder | None = None

    @property
    def directions(self) -> np.ndarray:
        """(n, 3) float32 unit directions, world axes: a view of the table."""
        return self.table[:, 3:6]


@dataclass(slots=True)
class Hits:
    """Nearest hits of a bundle.

    distance: (n,) float32 [m], inf where nothing is hit. normals: (n, 3) float32, unit, world axes, by the winding of
    the surface, or None if not asked for. surface: (n,) int32 index into the caster's `surfaces`, `NO_SURFACE` where
    nothing is hit, or None if not asked for.
    """

    distance: np.ndarray
    normals: np.ndarray | None = None
    surface: np.ndarray | None = None


class RayCaster(Protocol):
    """Anything that can say what rays hit first."""

    def cast(self, rays: RayBundle, poses: Any = None, *, normals: bool = False, surfaces: bool = False) -> Hits:
        """Hits against the geometry in the state `poses`, None meaning now. The same rays give the same bytes,
        whoever else casts and with however many threads.
        """


class AzimuthOrder:
    """Directions sorted by azimuth about one axis, to find those near another direction quickly.

    local: (n, 3) float32 unit directions in a frame that `rotation` (3, 3) turns into the world's.
    """

    def __init__(self, local: np.ndarray) -> None:
        azimuth = np.arctan2(local[:, 1], local[:, 0])
        self._index = np.argsort(azimuth, kind="stable")
        self._azimuth = azimuth[self._index]
        self.rotation: np.ndarray = np.eye(3)

    def near(self, direction: np.ndarray, half_angle: float) -> np.ndarray:
        """Indices of all directions within half_angle [rad] of a world direction (3,), and of some others."""
        x, y = (self.rotation.T @ direction)[:2]
        sine = np.sin(half_angle) + 1e-6
        level = float(np.hypot(x, y))
        if half_angle >= np.pi / 2 or level <= sine:
            return self._index
        width = float(np.arcsin(sine / level)) + 1e-6
        centre = float(np.arctan2(y, x))
        low, high = centre - width, centre + width
        parts = [self._between(low, high)]
        if low < -np.pi:
            parts.append(self._between(low + 2 * np.pi, np.pi + 1e-6))
        if high > np.pi:
            parts.append(self._between(-np.pi - 1e-6, high - 2 * np.pi))
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _between(self, low: float, high: float) -> np.ndarray:
        first, last = np.searchsorted(self._azimuth, (low, high))
        return self._index[first:last]
