"""Moving solids with closed forms: rays that may meet them are met by formula."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graph.sim.geometry.surfaces import Solid

from .forms import Forms
from .nearest import Nearest
from .rays import NOTHING, RayBundle


class MovingSolids:
    """Solids, each with its surface number and its body's.

    surfaces, bodies: (m,) of each; boxes: (m, 2, 3) [m] around them and radii: (m,) [m] of spheres about the boxes'
    centres, in the frames of the bodies.
    """

    def __init__(self, solids: Sequence[tuple[Solid, int, int]]) -> None:
        self._forms = Forms([solid.form for solid, _, _ in solids])
        numbers = np.array([(surface, body) for _, surface, body in solids], np.intp)[self._forms.order]
        self.surfaces, self.bodies = numbers[:, 0].astype(np.uint32), numbers[:, 1]
        self.boxes, self.radii = self._forms.boxes, self._forms.radii

    def cast(self, rays: RayBundle, index: np.ndarray, owner: np.ndarray, poses: np.ndarray, nearest: Nearest) -> None:
        """Adds hits of the rays `index` (k,), each with the solid `owner` (k,), ascending.

        poses: (b, 4, 4) float64 [m] of the bodies.
        """
        if not len(index):
            return
        forms = self._forms.seen_from(rays.origin, poses[self.bodies])
        met = forms.meet(index, owner, rays.directions, rays.offsets)

        def spots(some: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return np.full(len(some), NOTHING), np.zeros((len(some), 2), np.float32)

        surfaces = self.surfaces.take(met.owner)
        nearest.add_some(index.take(met.rows), met.length.astype(np.float32), surfaces, met.normals, spots)
