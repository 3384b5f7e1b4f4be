"""Surfaces that move with bodies: the rays that may meet them are found by windows, for meshes and solids at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graph.sim.geometry.surfaces import Solid

from .bodies import MovingMeshes
from .near import Moving
from .nearest import Nearest
from .places import Bounds, may_meet, windows, windows_of
from .rays import RayBundle
from .solids import MovingSolids

ALL_PAIRS = 100_000
"""Up to this many pairs of a ray and a surface, all are tried: it costs less than to select."""


class MovingSurfaces:
    """Meshes, and solids with their surface numbers and their bodies'; numbered from 0, solids first."""

    def __init__(self, meshes: Sequence[Moving], solids: Sequence[tuple[Solid, int, int]]) -> None:
        self._solids = MovingSolids(solids) if solids else None
        self._meshes = MovingMeshes(meshes) if meshes else None
        self._first = len(solids)
        parts = [part for part in (self._solids, self._meshes) if part is not None]
        self.surfaces = np.concatenate([part.surfaces for part in parts])
        """(m,) uint32, the surface number of each."""
        self._bounds = Bounds(
            np.concatenate([part.boxes for part in parts]),
            np.concatenate([part.radii for part in parts]),
            np.concatenate([part.bodies for part in parts]),
        )

    @property
    def few_meshes(self) -> bool:
        """Whether the meshes, if any, are small and few, so that all rays may be cast at all of them."""
        return self._meshes is None or self._meshes.few

    def cast(
        self,
        rays: RayBundle,
        anchor: np.ndarray,
        poses: np.ndarray,
        skip: np.ndarray | None,
        threads: int,
        nearest: Nearest,
    ) -> None:
        """Adds hits with the bodies at `poses` (b, 4, 4) float64 [m]; skip: (m,) bool, surfaces that are left out."""
        kept = np.ones(len(self.surfaces), bool) if skip is None else ~skip
        meshes = kept[self._first :]
        if self._meshes is not None and self._meshes.cast_together(rays, meshes, anchor, poses, threads, nearest):
            meshes[:] = False
        if not kept.any():
            return
        if rays.parts:  # then all meshes were cast together
            self._cast_parts(rays, poses, kept[: self._first], nearest)
        else:
            self._cast_selected(rays, anchor, poses, kept, threads, nearest)

    def _cast_parts(self, rays: RayBundle, poses: np.ndarray, kept: np.ndarray, nearest: Nearest) -> None:
        """Adds hits of the rays of several sensors with the solids kept (m,) bool: all pairs that may meet at once."""
        if self._solids is None:
            return
        places = self._bounds.places_of(rays.parts, poses)
        which, sensor = np.nonzero((kept & may_meet(rays.parts, places)[:, : self._first]).T)
        index, pair = windows_of(rays.parts, places, which, sensor)
        before = ((places.distance - places.radius)[sensor, which] - 1e-3).astype(np.float32)
        ahead = np.flatnonzero(nearest.distance.take(index) > before.take(pair))  # a former hit stays
        self._solids.cast_parts(rays, index.take(ahead), pair.take(ahead), (which, sensor), poses, nearest)

    def _cast_selected(
        self,
        rays: RayBundle,
        anchor: np.ndarray,
        poses: np.ndarray,
        kept: np.ndarray,
        threads: int,
        nearest: Nearest,
    ) -> None:
        """Adds hits of the rays of one sensor with the surfaces kept (m,) bool."""
        places = self._bounds.places(rays, poses)
        begin = places.distance - places.radius
        seen = kept & (begin <= rays.reach)
        meshes = slice(self._first, None)
        far = places.some(meshes)
        if self._meshes is not None:
            near = self._meshes.cast_near(rays, far, seen[meshes], kept[meshes], anchor, poses, threads, nearest)
            seen[meshes] &= ~near
        which = np.flatnonzero(seen & rays.may_meet(places.towards, places.distance, places.half))
        count = len(rays.table)
        if rays.grid is None and count * len(which) <= ALL_PAIRS:
            index, owner = np.tile(np.arange(count), len(which)), np.repeat(which, count)
        else:
            index, owner = windows(rays, places, which)
        before = (begin - 1e-3).astype(np.float32)
        ahead = np.flatnonzero(nearest.distance.take(index) > before.take(owner))  # a former hit stays
        index, owner = index.take(ahead), owner.take(ahead)
        solids = int(np.searchsorted(owner, self._first))
        if self._meshes is not None:
            self._meshes.cast(rays, index[solids:], owner[solids:] - self._first, far, poses, threads, nearest)
        if self._solids is not None:
            self._solids.cast(rays, index[:solids], owner[:solids], poses, nearest)
