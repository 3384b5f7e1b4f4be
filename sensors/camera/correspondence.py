"""Where in another picture the place is that a pixel shows: in that of the frame before, or of a second camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.sim.renderer.wrapper import unwrapped
from graph.sim.scene.prim_paths import prim_at
from graph.sim.transforms import apply, inverse_rigid, transformed
from sensors.raycast.shadows import Shadows
from sensors.raycast.world import CastWorld

from .lens import Floats, Lens, ParallelLens
from .names import CROSS_CAMERA
from .rays import TO_USD
from .view import View

if TYPE_CHECKING:
    from graph.sim.renderer.view import WorldView

    from .runtime import CameraRuntime


@dataclass(slots=True)
class Instant:
    """One frame's state: the world, and the poses of the camera (4, 4) and of its bodies (b, 4, 4), float64 [m]."""

    world: CastWorld
    pose: np.ndarray
    bodies: np.ndarray | None


def motion_vectors(lens: Lens, view: View, before: Instant | None, now: Instant) -> np.ndarray:
    """(n, 2) float32 [px]: a pixel's place in the earlier image less its place now, +x to the right, +y down.

    0 in the first frame, for pixels that show nothing, and for what was outside of the lens's view.
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


INVALID = -1.0
"""All four numbers of a pixel without a ray, and the offsets where the second camera images nothing."""


@dataclass(frozen=True)
class Reference:
    """The second camera: its lens and its pose (4, 4) float64 [m], USD camera to world."""

    lens: Lens
    pose: np.ndarray

    def project(self, points: Floats, directions: Floats) -> Floats:
        """(2, n) u, v [px] of world points (n, 3) [m], and of directions (m, 3) after them."""
        if isinstance(self.lens, ParallelLens):
            directions = np.full_like(directions, np.nan)  # it images what is at a finite place only
        ways = np.concatenate([points - self.pose[:3, 3], directions])
        return self.lens.project(apply((self.pose[:3, :3] @ TO_USD).T, ways).T)

    def eyes(self, points: Floats) -> Floats:
        """(n, 3) [m] world, where the rays to points begin."""
        if not isinstance(self.lens, ParallelLens):
            return np.broadcast_to(self.pose[:3, 3], points.shape)
        ahead = apply(self.pose[None, :3, 2], points - self.pose[:3, 3])
        return np.asarray(points - ahead * self.pose[:3, 2])


def reference_of(scene: WorldView, path: str) -> CameraRuntime:
    """The camera with a render product that the camera at a path names in `crossCameraReferenceName`.

    Of several cameras of that name it is the first by path. Raises UserError without a name and without such a camera.
    """
    name = str(prim_at(scene.stage, path).GetAttribute(CROSS_CAMERA).Get() or "")
    if not name:
        raise UserError(f"{path}: set its attribute {CROSS_CAMERA} (string) to the name of the second camera")
    found = {
        product.camera_path: cast("CameraRuntime", unwrapped(product.sensor))
        for product in scene.rendering.products.values()
        if product.camera_path.rpartition("/")[2] == name and product.camera_path != path
    }
    if not found:
        raise UserError(f"{path}.{CROSS_CAMERA}: no camera named {name!r} has a render product; create one")
    return found[min(found)]


def correspondence(view: View, lens: Lens, reference: Reference, shadows: Shadows, state: Any) -> np.ndarray:
    """(n, 4) float32 for each pixel: the offset to where the second camera shows its place, whether it is hidden or
    outside there, and whether that was tested.

    Offsets are place there less place here, in widths and heights of the images, +x to the right, +y down. What is
    endlessly far is not tested, and has the offset of its direction.
    """
    out = np.zeros((len(view.depth), 4), np.float32)
    there = np.isfinite(view.hits.distance)
    hit, missed = np.flatnonzero(there), np.flatnonzero(~there)
    points = view.rays.points(view.bundle, hit, view.hits.distance[hit])
    order = np.concatenate([hit, missed])
    seen = reference.project(points, view.bundle.directions[:, missed].T.astype(np.float64))
    with np.errstate(invalid="ignore"):
        inside = np.all((seen >= 0) & (seen <= [[reference.lens.width], [reference.lens.height]]), axis=0)
    there_share = seen / [[reference.lens.width], [reference.lens.height]]
    here_share = lens.centres()[:, order] / [[lens.width], [lens.height]]
    offset = np.clip(there_share - here_share, -1.0, 1.0)
    out[order, :2] = np.where(np.isfinite(offset).all(axis=0), offset, INVALID).T
    out[order, 2] = ~inside
    out[hit, 3] = 1
    tested = np.flatnonzero(inside[: len(hit)])
    if len(tested):
        out[hit[tested], 2] = _hidden(view, hit[tested], points[tested], reference, shadows, state)
    if view.rays.dark is not None:
        out[view.rays.dark] = INVALID
    return out


def _hidden(
    view: View, hit: np.ndarray, points: Floats, reference: Reference, shadows: Shadows, state: Any
) -> np.ndarray:
    """(k,) bool, whether anything is between points and the second camera; rays begin a little in front of them."""
    distance = view.hits.distance[hit]
    back = np.float32(2e-4) + np.float32(2e-6) * distance
    starts = view.rays.offsets(view.bundle, hit, distance - back)
    ways = (reference.eyes(points) - view.bundle.origin).astype(np.float32).T - starts
    return shadows.blocked(view.bundle.origin, starts, ways, np.arange(len(hit)), state, far=False)
