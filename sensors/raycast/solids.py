"""Moving solids with closed forms: rays that may meet them are found by windows, and met by formula."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graph.sim.geometry.surfaces import Solid

from .forms import Forms
from .nearest import Nearest
from .places import Bounds, windows
from .rays import NOTHING, RayBundle

ALL_PAIRS = 100_000
"""Up to this many pairs of a ray and a solid, all are computed: it costs less than to select."""


class MovingSolids:
    """Solids, each with its surface number and its body's."""

    def __init__(self, solids: Sequence[tuple[Solid, int, int]]) -> None:
        self._forms = Forms([solid.form for solid, _, _ in solids])
        numbers = np.array([(surface, body) for _, surface, body in solids], np.intp)[self._forms.order]
        self.surfaces, self._bodies = numbers[:, 0].astype(np.uint32), numbers[:, 1]
        self._bounds = Bounds(self._forms.boxes, self._forms.radii, self._bodies)

    def cast(self, rays: RayBundle, poses: np.ndarray, skip: np.ndarray | None, nearest: Nearest) -> None:
        """Adds hits with the bodies at `poses` (b, 4, 4) float64 [m]; skip: (m,) bool, solids that are left out."""
        places = self._bounds.places(rays, poses)
        seen = (places.distance - places.radius <= rays.reach) & rays.may_meet(
            places.towards, places.distance, places.half
        )
        if skip is not None:
            seen &= ~skip
        which = np.flatnonzero(seen)
        if not len(which):
            return
        count = len(rays.table)
        if rays.grid is None and count * len(which) <= ALL_PAIRS:
            index, owner = np.tile(np.arange(count), len(which)), np.repeat(which, count)
        else:
            index, owner = windows(rays, places, which)
        forms = self._forms.seen_from(rays.origin, poses[self._bodies])
        rows, length = forms.meet(index, owner, rays.directions, rays.offsets)
        index, owner = np.take(index, rows), np.take(owner, rows)

        def normals(some: np.ndarray) -> np.ndarray:
            return forms.normals(index[some], owner[some], length[some], rays.directions, rays.offsets)

        def spots(some: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return np.full(len(some), NOTHING), np.zeros((len(some), 2), np.float32)

        nearest.add_some(index, length.astype(np.float32), np.take(self.surfaces, owner), normals, spots)
