"""Moving solids with closed forms: rays that may meet them are met by formula."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graph.sim.geometry.surfaces import Solid

from .forms import Forms
from .nearest import Nearest
from .places import Pairs
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

    def cast(
        self, rays: RayBundle, looks: Sequence[RayBundle], pairs: Pairs, poses: np.ndarray, nearest: Nearest
    ) -> None:
        """Adds hits of the rays of some pairs. looks: the p bundles that make up `rays`.

        poses: (p or 1, b, 4, 4) float64 [m] of the bodies, as each bundle sees them.
        """
        origins = np.array([look.origin for look in looks])[pairs.look]
        moved = poses[pairs.look if len(poses) > 1 else 0, self.bodies[pairs.surface]]
        forms = self._forms.some(pairs.surface).seen_from(origins, moved)
        met = forms.meet(pairs.index, pairs.pair, rays.directions, None if rays.parts else rays.offsets)
        surfaces = self.surfaces[pairs.surface]

        def spots(some: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return np.full(len(some), NOTHING), np.zeros((len(some), 2), np.float32)

        length = met.length.astype(np.float32)
        nearest.add_some(pairs.index.take(met.rows), length, surfaces.take(met.owner), met.normals, spots)
