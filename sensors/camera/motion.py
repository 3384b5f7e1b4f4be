"""Motion vectors: where in the image what a pixel shows was one frame before."""

from __future__ import annotations

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import apply, inverse_rigid, transformed
from sensors.raycast.world import CastWorld

from .lens import Lens
from .rays import TO_USD
from .view import View


@dataclass(slots=True)
class Instant:
    """The camera (4, 4) and the bodies (b, 4, 4) at the time of a frame, float64 [m]; the world they are of."""

    world: CastWorld
    pose: np.ndarray
    bodies: np.ndarray | None


def motion_vectors(lens: Lens, view: View, before: Instant | None, now: Instant) -> np.ndarray:
    """(n, 2) float32 [px]: the place then less the place now, +x to the right, +y down.

    0 where nothing is, for the first frame, and for what was where the lens does not see.
    """
    out = np.zeros((len(view.depth), 2), np.float32)
    if before is None or before.world is not now.world:
        return out
    hit = np.flatnonzero(np.isfinite(view.hits.distance))
    body = now.world.body_of[view.hits.surfaces(hit)]
    if np.array_equal(before.pose, now.pose):
        moved = np.zeros(len(now.world.bodies) + 1, bool)
        if now.bodies is not None and before.bodies is not None:
            moved[:-1] = (before.bodies != now.bodies).any(axis=(1, 2))
        kept = np.flatnonzero(moved[body])
        hit, body = hit[kept], body[kept]
    if not len(hit):
        return out
    points = view.rays.points(view.bundle, hit, view.hits.distance[hit])
    if now.bodies is not None and before.bodies is not None:
        back = before.bodies @ np.stack([inverse_rigid(pose) for pose in now.bodies])
        for number in np.unique(body[body >= 0]).tolist():
            rows = np.flatnonzero(body == number)
            points[rows] = transformed(back[number], points[rows])
    local = apply((before.pose[:3, :3] @ TO_USD).T, points - before.pose[:3, 3])
    then = lens.project(local.T)
    moved_by = (then - lens.centres()[:, hit]).T
    out[hit] = np.where(np.isfinite(moved_by), moved_by, 0.0)
    return out
