"""Surfaces that move with bodies: the rays that may meet them are found by windows, for meshes and solids at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graph.sim.geometry.surfaces import Solid

from .bodies import MovingMeshes
from .forms import Forms
from .near import Moving
from .nearest import Nearest
from .places import Bounds, Pairs, windows
from .rays import RayBundle


class MovingSolids:
    """Solids, each with its surface number and its body's.

    surfaces, bodies: (m,) of each; boxes: (m, 2, 3) [m] around them and radii: (m,) [m] of spheres about the boxes'
    centres, in the frames of the bodies.
    """

    def __init__(self, solids: Sequence[tuple[Solid, int, int]]) -> None:
        self._forms = Forms([solid.form for solid, _, _ in solids])
        self.surfaces = np.array([surface for _, surface, _ in solids], np.uint32)
        self.bodies = np.array([body for _, _, body in solids], np.intp)
        self.boxes, self.radii = self._forms.boxes, self._forms.radii

    def cast(
        self, rays: RayBundle, looks: Sequence[RayBundle], pairs: Pairs, poses: np.ndarray, nearest: Nearest
    ) -> None:
        """Adds hits of the rays of some pairs. looks: the p bundles that make up `rays`.

        poses: (p or 1, b, 4, 4) float64 [m] of the bodies, as each bundle sees them.
        """
        origins = np.array([look.origin for look in looks])[pairs.look]
        moved = poses[pairs.look if len(poses) > 1 else 0, self.bodies[pairs.surface]]
        forms = self._forms.some(pairs.surface).seen_from(origins, moved)
        tried = pairs.index, pairs.pair, rays.table, None if rays.parts else rays.offsets
        length = forms.meet(*tried)
        normals = forms.normals(*tried, length) if nearest.with_normals else None
        nearest.add_some(pairs.index, length.astype(np.float32), self.surfaces[pairs.surface].take(pairs.pair), normals)


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
        """Adds hits with the bodies at `poses` (s, b, 4, 4) float64 [m] in each of the states that the rays look at.

        skip: (m,) bool, surfaces that are left out.
        """
        kept = np.ones(len(self.surfaces), bool) if skip is None else ~skip
        looks = rays.parts or rays.spans or (rays,)
        seen = np.array([kept] * len(looks))
        meshes = slice(self._first, None)
        states = [
            (slice(number, number + 1) if rays.spans else slice(None), one, poses[number], nearest.some(rows))
            for number, (rows, one) in enumerate(rays.by_state() if self._meshes is not None else ())
        ]
        for at, one, now, own in states:
            if self._meshes is not None and self._meshes.cast_together(one, kept[meshes], anchor, now, threads, own):
                seen[at, meshes] = False
        if not seen.any():
            return
        places = self._bounds.places(looks, poses)
        seen &= places.distance - places.radius <= rays.reach
        for at, one, now, own in states:
            if self._meshes is not None and seen[at, meshes].any():
                seen[at, meshes] &= ~self._meshes.cast_near(
                    one, places.some(at, meshes), seen[at, meshes], kept[meshes], anchor, now, threads, own
                )
        solids, others = windows(rays, looks, places, seen, nearest.distance).parted(self._first)
        if self._meshes is not None and len(others.index):
            self._meshes.cast(rays, others, places.some(slice(None), meshes), poses, threads, nearest)
        if self._solids is not None and len(solids.index):
            self._solids.cast(rays, looks, solids, poses, nearest)
