"""One Open3D ray casting scene: triangles in, nearest hits out. Only this file imports Open3D."""

from __future__ import annotations

import functools
import gc
import hashlib
import weakref
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.base.records import dataclass
from graph.base.sharing import Shared
from graph.sim.libraries import import_open3d

MAX_SCENES = 500
"""Each scene opens an Embree device, and the process crashes at about 1011 of them (`sensors/README.md`)."""

_alive, _built = [0], [0]
_shared: Shared[bytes, TriangleScene] = Shared()

SKIN = 2e-4
"""A ray that leaves a surface within this distance of its origin, in units of the scene, started on that surface and
continues: a sensor placed exactly on its mount sees the world.

It is several float32 spacings at 500 from the scene's origin (`sensors/README.md`).
"""


@functools.cache
def _open3d() -> tuple[Any, Any]:
    """(RaycastingScene, Tensor.from_numpy); importing Open3D takes a second, so it happens at the first scene."""
    open3d = import_open3d()
    return open3d.t.geometry.RaycastingScene, open3d.core.Tensor.from_numpy


@dataclass(frozen=True, slots=True)
class TriangleHits:
    """Nearest hits of n rays.

    distance (n,) float32, inf without a hit; triangle (n,) uint32, 2^32 - 1 without a
    hit; normals (n, 3) float32, unit, by the winding of the triangle, zero without a hit. uv: (n, 2) float32, the
    shares of the triangle's second and third corner in the place hit; None if not requested.
    """

    distance: np.ndarray
    triangle: np.ndarray
    normals: np.ndarray
    uv: np.ndarray | None = None

    def some(self, rows: slice) -> TriangleHits:
        """The hits of some rays; the arrays are parts of these."""
        uv = None if self.uv is None else self.uv[rows]
        return TriangleHits(self.distance[rows], self.triangle[rows], self.normals[rows], uv)


class TriangleScene:
    """Triangles with their acceleration structure.

    vertices: (v, 3) float32; triangles: (m, 3) uint32. warm: build the acceleration structure now, not at the first
    cast. Raises RunError if too many scenes exist.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray, *, warm: bool = True) -> None:
        if _alive[0] >= MAX_SCENES:
            gc.collect()  # Apps that were dropped without close() may still hold some
        if _alive[0] >= MAX_SCENES:
            raise RunError(
                f"ray casting: {MAX_SCENES} scenes are alive, the most this process can hold; use fewer different "
                "`exclude` sets, lidars less than a kilometre apart, or close Apps that are done"
            )
        make, self._tensor = _open3d()
        self._scene = make()
        self._scene.add_triangles(self._as_tensor(vertices, np.float32), self._as_tensor(triangles, np.uint32))
        _alive[0] += 1
        _built[0] += 1
        weakref.finalize(self, _forget)
        if warm:
            self._cast(np.zeros((1, 6), np.float32), 1)

    def cast(self, rays: np.ndarray, threads: int, *, uv: bool = False) -> TriangleHits:
        """Nearest hits of rays (n, 6) float32, C-contiguous: origin, unit direction. threads: 0 means all cores.

        A surface that a ray leaves at its origin, by the winding of the triangle, is not hit (`SKIN`).
        """
        found = self._cast(rays, threads, uv=uv)
        if found.distance.min(initial=np.inf) < SKIN:
            self._leave(rays, threads, found)
        return found

    def blocked(self, rays: np.ndarray, reach: float, threads: int) -> np.ndarray:
        """(n,) bool, whether rays (n, 6) float32 hit anything within `reach` lengths of their directions."""
        found = self._scene.test_occlusions(self._tensor(np.ascontiguousarray(rays)), 0.0, reach, threads)
        return np.asarray(found.numpy())

    def _leave(self, rays: np.ndarray, threads: int, found: TriangleHits) -> None:
        near = np.flatnonzero(found.distance < SKIN)
        outwards = (rays[near, 3:] * found.normals[near]).sum(axis=1) > 0
        leaving = near[outwards]
        if not len(leaving):
            return
        further = rays[leaving]
        further[:, :3] += np.float32(SKIN) * further[:, 3:]
        beyond = self._cast(further, threads, uv=found.uv is not None)
        found.distance[leaving] = beyond.distance + np.float32(SKIN)
        found.triangle[leaving], found.normals[leaving] = beyond.triangle, beyond.normals
        if found.uv is not None:
            found.uv[leaving] = beyond.uv

    def _cast(self, rays: np.ndarray, threads: int, *, uv: bool = False) -> TriangleHits:
        hits = self._scene.cast_rays(self._tensor(rays), nthreads=threads)
        names = "t_hit", "primitive_ids", "primitive_normals", *(("primitive_uvs",) if uv else ())
        return TriangleHits(*(hits[name].numpy() for name in names))

    def _as_tensor(self, array: np.ndarray, dtype: type[np.generic]) -> Any:
        return self._tensor(np.ascontiguousarray(array, dtype))


def shared_scene(vertices: np.ndarray, triangles: np.ndarray) -> TriangleScene:
    """The scene of these triangles: that of another sensor or App of this process if there is one, else a new one.

    Arrays as for `TriangleScene`; scenes are the same if all bytes are.
    """
    digest = hashlib.sha256(len(vertices).to_bytes(8, "little"))  # faster than blake2b, where processors help
    digest.update(np.ascontiguousarray(vertices, np.float32).data)
    digest.update(np.ascontiguousarray(triangles, np.uint32).data)
    return _shared.of(digest.digest(), lambda: TriangleScene(vertices, triangles))


def _forget() -> None:
    _alive[0] -= 1


def alive() -> int:
    """How many scenes exist now."""
    return _alive[0]


def built() -> int:
    """How many scenes this process has built so far."""
    return _built[0]
