"""The rays of a camera: worked out once for a lens, turned into the world for each frame."""

from __future__ import annotations

from copy import copy
from functools import cached_property

import numpy as np

from graph.base.sharing import Shared
from graph.sim.transforms import apply
from sensors.compiled import compiled
from sensors.raycast.rays import RayBundle, RayMemory, turn
from sensors.raycast.windows import RayGrid

from .lens import Lens, ParallelLens

TO_USD = np.diag([1.0, -1.0, -1.0])
"""Optical axes (right, down, forward) to those of a USD camera (right, up, backward), and back."""

FORWARD_LEFT_UP = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
"""Axes forward, left, up to those of a USD camera: directions spread over azimuth and elevation in them."""


class LensRays:
    """The rays of a lens in the camera's axes, for all cameras of this process that have it.

    local: (3, n) float32 unit. origins: (n, 3) float32 [m] of parallel rays, else None. along, dark, wide: as in
    `CameraRays`.
    """

    def __init__(self, lens: Lens, shift: tuple[float, float]) -> None:
        optical = lens.unproject(lens.centres() + np.array(shift)[:, None])
        self.local = apply(TO_USD, optical, axis=0).astype(np.float32)
        self.along = None if isinstance(lens, ParallelLens) else optical[2].astype(np.float32)
        unseen = np.flatnonzero(~optical.any(axis=0))
        self.dark = unseen if len(unseen) else None
        if self.along is not None:
            self.along[unseen] = 1.0  # such a ray has no direction: its depth is infinite, not 0 x infinity
        self.wide = bool((optical[2] < 0).any())
        self.origins = None
        if isinstance(lens, ParallelLens):
            self.origins = np.ascontiguousarray(apply(TO_USD, lens.origins(shift), axis=0).T, np.float32)

    @cached_property
    def grid(self) -> RayGrid:
        """The directions sorted by azimuth and elevation."""
        return RayGrid(apply(FORWARD_LEFT_UP.T.astype(np.float32), self.local, axis=0).T)


_shared: Shared[tuple[Lens, tuple[float, float]], LensRays] = Shared()


def lens_rays(lens: Lens, shift: tuple[float, float] = (0.0, 0.0)) -> LensRays:
    """The rays of a lens. shift: where in its pixel a ray goes, from the middle [px]."""
    return _shared.of((lens, shift), lambda: LensRays(lens, shift))


class CameraRays:
    """One ray for each pixel, row by row.

    along: (n,) float32, the distance from the image plane for each metre of a ray; None for parallel rays: 1. dark:
    (k,) rays of pixels that the lens gives no direction, or None. wide: whether rays may look sideways or back, so that
    distances from the image plane say nothing of what is near.
    """

    def __init__(self, lens: Lens, shift: tuple[float, float] = (0.0, 0.0)) -> None:
        """shift: where in its pixel a ray goes, from the middle [px]."""
        self._lens = known = lens_rays(lens, shift)
        self._local, self._origins = known.local, known.origins
        self.along, self.dark, self.wide = known.along, known.dark, known.wide
        count = self._local.shape[1]
        self._table, self._world = np.empty((count, 6), np.float32), np.empty((3, count), np.float32)
        self._memory = RayMemory()
        self._turned_by = b""
        self._rotation = np.eye(3)
        self._offsets: np.ndarray | None = None

    def copies(self, count: int) -> tuple[np.ndarray, list[CameraRays]]:
        """The rays of `count` cameras with this lens: one table (count x n, 6) float32, and the cameras, whose own
        tables are its parts.
        """
        rays = len(self)
        table, world = np.empty((count * rays, 6), np.float32), np.empty((count, 3, rays), np.float32)
        found = []
        for number in range(count):
            one = copy(self)
            one._table, one._world = table[number * rays : (number + 1) * rays], world[number]
            one._memory, one._turned_by = RayMemory(), b""
            found.append(one)
        return table, found

    def __len__(self) -> int:
        return len(self._table)

    def bundle(self, pose: np.ndarray, exclude: frozenset[str], *, grid: bool) -> RayBundle:
        """The rays of a camera at `pose` (4, 4) float64 [m], USD camera to world; grid: whether anything moves."""
        rotation = pose[:3, :3]
        if rotation.tobytes() != self._turned_by:
            turn(self._local, rotation.astype(np.float32), self._world, self._table)
            self._turned_by = rotation.tobytes()
            self._memory.forget()
            if self._origins is not None:
                self._offsets = apply(rotation.astype(np.float32), self._origins)
        bundle = RayBundle(pose[:3, 3], self._table, self._offsets, exclude, columns=self._world, memory=self._memory)
        self._rotation = rotation
        if grid:
            bundle.grid = self.grid()
        return bundle

    def line_bundle(
        self, pose: np.ndarray, poses: np.ndarray, line_of: np.ndarray, exclude: frozenset[str]
    ) -> RayBundle:
        """The rays, each from the pose of its line: poses (lines, 4, 4) [m], line_of (n,); pose: (4, 4), near them."""
        rotations, origin = poses[:, :3, :3].astype(np.float32), pose[:3, 3]
        for axis in range(3):
            column = self._world[axis]
            np.multiply(self._local[0], np.take(rotations[:, axis, 0], line_of), out=column)
            for other in (1, 2):
                column += self._local[other] * np.take(rotations[:, axis, other], line_of)
            self._table[:, 3 + axis] = column
        self._turned_by, self._rotation = b"", pose[:3, :3]
        offsets = np.take((poses[:, :3, 3] - origin).astype(np.float32), line_of, axis=0)
        if self._origins is not None:
            offsets += np.einsum("nij,nj->ni", np.take(rotations, line_of, axis=0), self._origins)
        return RayBundle(origin, self._table, offsets, exclude, columns=self._world)

    def grid(self) -> RayGrid:
        """The directions sorted by azimuth and elevation, as of the last bundle."""
        return self._lens.grid.turned(self._rotation @ FORWARD_LEFT_UP)

    def further(self, rays: np.ndarray, bundle: RayBundle, distance: np.ndarray) -> RayBundle:
        """Some rays (k,) of a bundle, each starting `distance` (k,) [m] along its way."""
        table = np.zeros((len(rays), 6), np.float32)
        table[:, 3:6] = self._world[:, rays].T
        offsets = table[:, 3:6] * distance[:, None]
        if bundle.offsets is not None:
            offsets += bundle.offsets[rays]
        return RayBundle(bundle.origin, table, offsets, bundle.exclude)

    def offsets(self, bundle: RayBundle, rays: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """(3, k) float32 [m] from the bundle's origin, world axes, at `distance` (k,) along the rays (k,)."""
        found = np.take(self._world, rays, axis=1) * distance
        return np.asarray(found if bundle.offsets is None else found + bundle.offsets[rays].T)

    def points(self, bundle: RayBundle, rays: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """(k, 3) float64 world [m], at `distance` (k,) along the rays (k,)."""
        found = self._world[:, rays].T.astype(np.float64) * distance[:, None] + bundle.origin
        return np.asarray(found if bundle.offsets is None else found + bundle.offsets[rays])

    def face(self, normals: np.ndarray) -> None:
        """Turns normals (n, 3) float32 in place, where they point the way of the ray."""
        _face(normals, self._world)


@compiled
def _face(normals: np.ndarray, columns: np.ndarray) -> None:
    for ray in range(len(normals)):
        normal = normals[ray]
        if columns[0, ray] * normal[0] + columns[1, ray] * normal[1] + columns[2, ray] * normal[2] > 0:
            for axis in range(3):
                normal[axis] = -normal[axis]
