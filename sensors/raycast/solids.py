"""Moving solids with closed forms: rays that may meet them are met by formula."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graph.sim.geometry.surfaces import Solid

from .forms import Forms
from .nearest import Nearest
from .places import Pairs
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
