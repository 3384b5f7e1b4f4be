"""Small moving meshes that are few or close to a sensor: one scene for all of them, so that each ray is cast only once.

A close mesh fills much of the view, and many such meshes (the links of the robot that carries the sensor) would bring
each ray into many cells (see `bodies`); rebuilding a few thousand triangles costs less. The same holds for a world with
only a few hundred moving triangles. Which meshes are gathered depends only on their positions and sizes, never on the
rays or on other casts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from graph.base.records import dataclass

from .nearest import Nearest, cast_picked
from .rays import RayBundle
from .triangles import TriangleScene

if TYPE_CHECKING:
    from graph.sim.geometry.surfaces import Mesh

NEAR_RAD = np.deg2rad(20.0)
"""Half of a mesh's angular size, from which on it is near."""

MOST_TRIANGLES = 2000
"""Larger meshes go into cells even if near: casting their rays costs less than rebuilding them."""

FEW_TRIANGLES = 600
"""Total triangles of all small meshes up to which they are gathered at any distance."""

NEAR_ANCHOR_M = 64.0
"""Within this distance of the static scenes' anchor its frame is precise enough, and one scene serves all sensors."""

FULL_CAST = 0.6
"""Fraction of the rays from which on selecting them costs more than casting them all."""


@dataclass(frozen=True, slots=True)
class Moving:
    """A moving mesh, its surface number and its body's."""

    mesh: Mesh
    surface: int
    body: int


class _Layout:
    """Some of the meshes side by side: the data that does not change when they move."""

    def __init__(self, entries: Sequence[Moving]) -> None:
        counts = [len(entry.mesh.vertices) for entry in entries]
        starts = np.cumsum([0, *counts[:-1]])
        self.local = np.concatenate([np.asarray(entry.mesh.vertices, np.float64) for entry in entries])
        self.owner = np.repeat(np.arange(len(entries)), counts)
        self.bodies = np.array([entry.body for entry in entries], np.intp)
        faces = [np.asarray(entry.mesh.triangles, np.uint32) for entry in entries]
        self.triangles = np.concatenate([each + np.uint32(at) for each, at in zip(faces, starts, strict=True)])
        surfaces = np.array([entry.surface for entry in entries], np.uint32)
        sizes = [len(each) for each in faces]
        self.surface = np.repeat(surfaces, sizes)
        """(t,) uint32, of each triangle."""
        self.first = np.repeat(np.cumsum([0, *sizes[:-1]], dtype=np.uint32), sizes)
        """(t,) uint32, the first triangle of its mesh."""

    def scene(self, poses: np.ndarray, origin: np.ndarray) -> TriangleScene:
        """The meshes with their bodies at `poses` (k, 4, 4) [m], about an origin."""
        rotation = poses[self.owner, :3, :3]
        world = (poses[:, :3, 3] - origin)[self.owner]
        for column in range(3):
            world += rotation[:, :, column] * self.local[:, column, None]
        return TriangleScene(world.astype(np.float32), self.triangles, warm=False)


class NearMeshes:
    """Moving meshes that may be gathered; numbered as `moving`."""

    def __init__(self, moving: Sequence[Moving]) -> None:
        self._moving = moving
        counts = np.array([len(entry.mesh.triangles) for entry in moving])
        self.small = counts <= MOST_TRIANGLES
        """(m,) bool, which of them may be near."""
        self.few = bool(counts[self.small].sum() <= FEW_TRIANGLES)
        """Whether all small meshes are gathered."""
        self.all_few = self.few and bool(self.small.all())
        """Whether all meshes are gathered."""
        self._layout: tuple[bytes, _Layout] | None = None
        self._scene: tuple[tuple[bytes, ...], TriangleScene] | None = None

    def cast(
        self,
        rays: RayBundle,
        window: np.ndarray | None,
        which: np.ndarray,
        anchor: np.ndarray,
        poses: np.ndarray,
        threads: int,
        nearest: Nearest,
    ) -> None:
        """Adds hits with the meshes `which` (k,), bodies at `poses` (b, 4, 4) float64 [m].

        window: the rays that may meet them, with repeats; None: all rays.
        """
        frame = anchor if np.abs(rays.origin - anchor).max() < NEAR_ANCHOR_M else rays.origin
        start = (rays.origin - frame).astype(np.float32)
        index = None if window is None else _chosen(window, len(rays.table))
        if index is None or len(index):
            layout = self._layout_of(which)
            scene = self._scene_of(layout, which, poses[layout.bodies], frame)
            cast_picked(rays, index, start, scene, layout.surface, layout.first, threads, nearest)

    def _layout_of(self, which: np.ndarray) -> _Layout:
        key = which.tobytes()
        if self._layout is None or self._layout[0] != key:
            self._layout = key, _Layout([self._moving[number] for number in which])
        return self._layout[1]

    def _scene_of(self, layout: _Layout, which: np.ndarray, poses: np.ndarray, origin: np.ndarray) -> TriangleScene:
        key = (which.tobytes(), origin.tobytes(), poses.tobytes())
        if self._scene is None or self._scene[0] != key:
            self._scene = None  # the old scene is freed before the next is made
            self._scene = key, layout.scene(poses, origin)
        return self._scene[1]


def _chosen(index: np.ndarray, count: int) -> np.ndarray | None:
    """Each of the selected rays once, in order; None if casting all `count` rays is as cheap."""
    chosen = np.zeros(count, bool)
    chosen[index] = True
    found = np.flatnonzero(chosen)
    return None if len(found) > FULL_CAST * count else found
