"""One look of a camera: rays in, and what they meet between the near and the far distance."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.base.records import dataclass
from sensors.raycast.rays import NOTHING, Hits, RayBundle
from sensors.raycast.world import CastWorld

from .config import CameraConfig
from .line_exposure import LineExposure
from .rays import CameraRays


@dataclass(slots=True)
class View:
    """What the rays of a camera met in one state of the world; arrays of one entry for each ray.

    depth: (n,) float32 [m] from the image plane, infinite where nothing is, as in `hits.distance`. lift: (n,) float32
    [m], how far the smooth surface rises above the triangle that was hit; None where all are flat. faced: whether the
    normals are turned towards the camera.
    """

    rays: CameraRays
    bundle: RayBundle
    hits: Hits
    depth: np.ndarray
    lift: np.ndarray | None = None
    faced: bool = False

    def facing_normals(self) -> np.ndarray:
        """(n, 3) float32 unit normals, world axes, turned towards the camera."""
        normals = self.hits.normals
        assert normals is not None
        if not self.faced:
            self.rays.face(normals)
            self.faced = True
        return normals

    def points(self) -> np.ndarray:
        """(n, 3) float32 [m], world, of what the rays met; not a number where they met nothing."""
        out = np.full((len(self.depth), 3), np.nan, np.float32)
        hit = np.flatnonzero(np.isfinite(self.hits.distance))
        out[hit] = self.rays.points(self.bundle, hit, self.hits.distance[hit])
        return out


def look(
    world: CastWorld,
    rays: CameraRays,
    config: CameraConfig,
    pose: np.ndarray,
    poses: Any,
    exclude: frozenset[str],
    *,
    normals: bool,
    spots: bool = False,
    lines: LineExposure | None = None,
) -> View:
    """Casts the rays of a camera at `pose` (4, 4) float64 [m] into the world in a state `poses`.

    spots: whether the hits say where on their surfaces they are. lines: of a rolling shutter; then `pose` and `poses`
    are those of the end of its last line.
    """
    if lines is None:
        bundle = rays.bundle(pose, exclude, grid=bool(len(world.moving_surfaces) or world.soft))
        hits = world.cast(bundle, poses, normals=normals, spots=spots)
    else:
        bundle = rays.line_bundle(pose, lines.poses(), lines.line_of(), exclude)
        hits = lines.cast(world, bundle, normals=normals, spots=spots)
    return shown(world, rays, config, bundle, hits, poses)


def shown(world: CastWorld, rays: CameraRays, config: CameraConfig, bundle: RayBundle, hits: Hits, poses: Any) -> View:
    """What a camera shows of what its rays hit: between the near and the far distance. It changes `hits` in place."""
    distance = hits.distance
    if rays.dark is not None:
        _forget(hits, rays.dark)
    reach = distance if rays.wide or rays.along is None else distance * rays.along
    if config.near > 0:
        close = np.flatnonzero(reach < config.near)
        if len(close):
            _look_behind(world, rays, config, bundle, hits, poses, close)
            if reach is not distance and rays.along is not None:
                np.multiply(distance, rays.along, out=reach)
    beyond = np.flatnonzero((reach > config.far) & np.isfinite(reach))
    if len(beyond):
        _forget(hits, beyond)
        reach[beyond] = np.inf
    return View(rays, bundle, hits, _depth(rays, distance) if rays.wide else reach)


def _look_behind(
    world: CastWorld,
    rays: CameraRays,
    config: CameraConfig,
    bundle: RayBundle,
    hits: Hits,
    poses: Any,
    close: np.ndarray,
) -> None:
    """What is nearer than the near distance is not shown; rays begin there, as in a rasteriser."""
    start = np.full(len(close), config.near, np.float32)
    if not rays.wide and rays.along is not None:
        start /= rays.along[close]
    beyond = rays.further(close, bundle, start)
    behind = world.cast(beyond, poses, normals=hits.normals is not None, spots=hits.spots is not None)
    hits.distance[close] = behind.distance + start
    hits.number[close] = behind.number
    if hits.normals is not None and behind.normals is not None:
        hits.normals[close] = behind.normals
    if hits.spots is not None and behind.spots is not None:
        hits.spots.triangle[close], hits.spots.uv[close] = behind.spots.triangle, behind.spots.uv


def _forget(hits: Hits, rays: np.ndarray) -> None:
    hits.distance[rays], hits.number[rays] = np.inf, NOTHING
    if hits.normals is not None:
        hits.normals[rays] = 0


def _depth(rays: CameraRays, distance: np.ndarray) -> np.ndarray:
    """Distances from the image plane of a lens that also looks sideways."""
    assert rays.along is not None
    with np.errstate(invalid="ignore"):
        depth = distance * rays.along
    depth[~np.isfinite(distance)] = np.inf
    return np.asarray(depth)
