"""Moving solids with closed forms: rays that may meet them are met by formula."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graph.sim.geometry.surfaces import Solid

from .forms import Forms, Met
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
        if len(index):
            forms = self._forms.seen_from(rays.origin, poses[self.bodies])
            self._add(forms.meet(index, owner, rays.directions, rays.offsets), self.surfaces, index, nearest)

    def cast_parts(
        self,
        rays: RayBundle,
        index: np.ndarray,
        pair: np.ndarray,
        seen: tuple[np.ndarray, np.ndarray],
        poses: np.ndarray,
        nearest: Nearest,
    ) -> None:
        """The same for the rays of several sensors, each with a pair of a solid and a sensor.

        seen: (n,) the solid, ascending, and (n,) the sensor of each pair.
        """
        if not len(index):
            return
        which, sensor = seen
        origins = np.stack([part.origin for part in rays.parts])[sensor]
        forms = self._forms.some(which).seen_from(origins, poses[self.bodies[which]])
        self._add(forms.meet(index, pair, rays.directions, None), self.surfaces[which], index, nearest)

    def _add(self, met: Met, surfaces: np.ndarray, index: np.ndarray, nearest: Nearest) -> None:
        def spots(some: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return np.full(len(some), NOTHING), np.zeros((len(some), 2), np.float32)

        length = met.length.astype(np.float32)
        nearest.add_some(index.take(met.rows), length, surfaces.take(met.owner), met.normals, spots)
