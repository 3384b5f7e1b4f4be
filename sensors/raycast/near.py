"""Small moving meshes close to a sensor: put together to one scene where they are, so that each ray is cast but once.

What is close takes up much of the view, and many such meshes, as the links of the robot that carries the sensor, would
bring each ray into many cells (see `bodies`); rebuilding a few thousand triangles costs less. Which meshes count as
near depends on where they are and how large, never on the rays or on who else casts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .nearest import Nearest
from .rays import RayBundle
from .triangles import TriangleScene

if TYPE_CHECKING:
    from .bodies import Moving

NEAR_RAD = np.deg2rad(20.0)
"""Half the angle that a mesh takes up, from which on it is near."""

MOST_TRIANGLES = 2000
"""Larger meshes go into cells however near: the rays they get cost less than rebuilding them."""

FULL_CAST = 0.6
"""Share of the rays from which on picking them costs more than casting them all."""


@dataclass(slots=True)
class _Gathered:
    scene: TriangleScene
    surface: np.ndarray
    """(t,) uint32, of each triangle."""


class NearMeshes:
    """Moving meshes that may be gathered; they are numbered as `moving`."""

    def __init__(self, moving: Sequence[Moving]) -> None:
        self._moving = moving
        self.small = np.array([len(entry.mesh.triangles) <= MOST_TRIANGLES for entry in moving])
        """(m,) bool, which of them may be near."""
        self._latest: tuple[tuple[bytes, ...], _Gathered] | None = None

    def cast(
        self,
        rays: RayBundle,
        windows: tuple[np.ndarray, np.ndarray] | None,
        which: np.ndarray,
        poses: np.ndarray,
        threads: int,
        nearest: Nearest,
    ) -> None:
        """Adds hits with the meshes `which` (k,), bodies at `poses` (b, 4, 4) float64 [m].

        windows: the rays that may meet them, with repeats, and whose each is; None: all may.
        """
        gathered = self._gathered(which, rays.origin, poses)
        rays.start_at(np.zeros(3, np.float32))
        index, table = None, rays.table
        if windows is not None:
            chosen = np.zeros(len(table), bool)
            chosen[windows[0]] = True
            index = np.flatnonzero(chosen)
            if len(index) > FULL_CAST * len(table):
                index = None
            else:
                table = np.take(table, index, axis=0, mode="clip")
        found = gathered.scene.cast(table, threads)
        hit = np.flatnonzero(np.isfinite(found.distance))
        surface = np.take(gathered.surface, found.triangle[hit])
        target = hit if index is None else index[hit]
        nearest.add_some(target, found.distance[hit], surface, lambda rows: np.take(found.normals, hit[rows], axis=0))

    def _gathered(self, which: np.ndarray, origin: np.ndarray, poses: np.ndarray) -> _Gathered:
        entries = [self._moving[number] for number in which]
        bodies = poses[[entry.body for entry in entries]]
        key = (which.tobytes(), origin.tobytes(), bodies.tobytes())
        if self._latest is None or self._latest[0] != key:
            self._latest = None  # its scene goes before the next is made
            self._latest = key, _gather(entries, bodies, origin)
        return self._latest[1]


def _gather(entries: Sequence[Moving], poses: np.ndarray, origin: np.ndarray) -> _Gathered:
    vertices, triangles, start = [], [], 0
    for entry, pose in zip(entries, poses, strict=True):
        world = entry.mesh.vertices @ pose[:3, :3].T + (pose[:3, 3] - origin)
        vertices.append(world.astype(np.float32))
        triangles.append(np.asarray(entry.mesh.triangles, np.uint32) + np.uint32(start))
        start += len(world)
    counts = [len(each) for each in triangles]
    surface = np.repeat(np.array([entry.surface for entry in entries], np.uint32), counts)
    return _Gathered(TriangleScene(np.concatenate(vertices), np.concatenate(triangles), warm=False), surface)
