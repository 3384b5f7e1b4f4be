"""One Open3D ray casting scene: triangles in, nearest hits out. The one file that touches Open3D."""

from __future__ import annotations

import functools
import gc
import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np

from graph.errors import RunError
from graph.sim.libraries import import_open3d

MAX_SCENES = 500
"""Each scene opens an Embree device, and the process ends with a crash at about 1011 of them (raycasting facts, 4)."""

_alive = [0]


@functools.cache
def _open3d() -> tuple[Any, Any]:
    """(RaycastingScene, Tensor.from_numpy); importing Open3D takes a second, so it happens at the first scene."""
    open3d = import_open3d()
    return open3d.t.geometry.RaycastingScene, open3d.core.Tensor.from_numpy


@dataclass(frozen=True, slots=True)
class TriangleHits:
    """Nearest hits of n rays: distance (n,) float32, inf where nothing is hit; triangle (n,) uint32, 2^32 - 1 there;
    normals (n, 3) float32, unit, by the winding of the triangle, zero where nothing is hit.
    """

    distance: np.ndarray
    triangle: np.ndarray
    normals: np.ndarray


class TriangleScene:
    """Triangles with their acceleration structure.

    vertices: (v, 3) float32; triangles: (m, 3) uint32. warm: build the acceleration structure now, not at the first
    cast. Raises RunError when too many scenes are alive.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray, *, warm: bool = True) -> None:
        if _alive[0] >= MAX_SCENES:
            gc.collect()  # Apps that were dropped without being closed may hold some
        if _alive[0] >= MAX_SCENES:
            raise RunError(
                f"ray casting: {MAX_SCENES} scenes are alive, the most this process can hold; use fewer different "
                "`exclude` sets, lidars less than a kilometre apart, or close Apps that are done"
            )
        make, self._tensor = _open3d()
        self._scene = make()
        self._scene.add_triangles(self._as_tensor(vertices, np.float32), self._as_tensor(triangles, np.uint32))
        _alive[0] += 1
        weakref.finalize(self, _forget)
        if warm:
            self.cast(np.zeros((1, 6), np.float32), 1)

    def cast(self, rays: np.ndarray, threads: int) -> TriangleHits:
        """Nearest hits of rays (n, 6) float32, C-contiguous: origin, unit direction. threads: 0 means all cores."""
        hits = self._scene.cast_rays(self._tensor(rays), nthreads=threads)
        return TriangleHits(hits["t_hit"].numpy(), hits["primitive_ids"].numpy(), hits["primitive_normals"].numpy())

    def _as_tensor(self, array: np.ndarray, dtype: type[np.generic]) -> Any:
        return self._tensor(np.ascontiguousarray(array, dtype))


def _forget() -> None:
    _alive[0] -= 1


def alive() -> int:
    """How many scenes exist now."""
    return _alive[0]
