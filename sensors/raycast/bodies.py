"""Moving geometry: light meshes together in one scene, heavy meshes each in a scene of their own frame.

Only rays that may meet a body's bounding sphere, and that nothing nearer has stopped yet, are cast. Which rays those
are changes no result: a ray's hit does not depend on the rays cast with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from .nearest import Nearest
from .rays import NO_SURFACE, RayBundle
from .triangles import TriangleHits, TriangleScene
from .windows import RayGrid

if TYPE_CHECKING:
    from graph.sim.geometry import Mesh

HEAVY_TRIANGLES = 150
"""From here on casting in the body's frame costs less than rebuilding (raycasting facts, 3)."""

FULL_CAST = 0.6
"""Share of the rays from which on picking them costs more than casting them all."""


@dataclass(frozen=True, slots=True)
class Moving:
    """A mesh that moves, its surface number and its body's."""

    mesh: Mesh
    surface: int
    body: int


class Spheres:
    """Bounding spheres of meshes in their bodies' frames."""

    def __init__(self, moving: Sequence[Moving]) -> None:
        meshes = [entry.mesh for entry in moving]
        boxes = [(np.min(mesh.vertices, axis=0), np.max(mesh.vertices, axis=0)) for mesh in meshes]
        self.local = np.array([(low + high) / 2 for low, high in boxes]).reshape(-1, 3)
        radii = [
            np.sqrt(((mesh.vertices - centre) ** 2).sum(axis=1).max())
            for mesh, centre in zip(meshes, self.local, strict=True)
        ]
        self.radii = np.array(radii) * (1 + 1e-6) + 1e-6
        self.bodies = np.array([entry.body for entry in moving], np.intp)
        self.surfaces = np.array([entry.surface for entry in moving], np.int32)

    def centres(self, poses: np.ndarray) -> np.ndarray:
        """(m, 3) float64 [m], world, for body poses (b, 4, 4)."""
        pose = poses[self.bodies]
        return np.asarray((pose[:, :3, :3] @ self.local[:, :, None])[:, :, 0] + pose[:, :3, 3])

    def windows(self, rays: RayBundle, centres: np.ndarray, skip: frozenset[int]) -> tuple[np.ndarray, np.ndarray]:
        """(index, owner) of rays that may hit a sphere within their reach, and some more; sorted by owner.

        Spheres of the surfaces in `skip` are left out.
        """
        radii = self.radii + spread_of(rays)
        towards = centres - rays.origin
        distance = np.sqrt((towards**2).sum(axis=1))
        seen = distance - radii <= rays.reach
        if rays.swing:
            radii = radii + rays.swing * distance
        if skip:
            seen &= ~np.isin(self.surfaces, list(skip))
        which = np.flatnonzero(seen)
        grid = rays.grid if rays.grid is not None else RayGrid(rays.directions)
        index, owner = grid.near(towards[which], radii[which])
        if rays.first or len(rays.table) < grid.count:
            inside = np.flatnonzero((index >= rays.first) & (index < rays.first + len(rays.table)))
            index, owner = index[inside] - rays.first, owner[inside]
        return index, which[owner]


def spread_of(rays: RayBundle) -> float:
    """How far [m] the farthest ray starts from the bundle's origin."""
    return 0.0 if rays.offsets is None else float(np.sqrt((rays.offsets**2).sum(axis=1).max(initial=0.0)))


class LightBodies:
    """Small moving meshes, transformed and rebuilt as one scene when a pose in it changed since the last build.

    The scene depends on the anchor, the meshes and their poses alone, never on who casts.
    """

    def __init__(self, moving: Sequence[Moving]) -> None:
        meshes, bodies = [entry.mesh for entry in moving], [entry.body for entry in moving]
        counts = [len(mesh.vertices) for mesh in meshes]
        starts = np.cumsum([0, *counts[:-1]])
        self._local = np.concatenate([np.asarray(mesh.vertices, np.float64) for mesh in meshes])
        self._triangles = np.concatenate(
            [np.asarray(mesh.triangles, np.uint32) + np.uint32(s) for mesh, s in zip(meshes, starts, strict=True)]
        )
        self._used = np.unique(np.asarray(bodies))
        self._vertex_body = np.repeat(np.searchsorted(self._used, bodies), counts)
        self._surface = np.repeat(
            np.array([*(entry.surface for entry in moving), NO_SURFACE], np.int32),
            [*(len(mesh.triangles) for mesh in meshes), 1],
        )
        self._built_for: bytes | None = None
        self._scene: TriangleScene | None = None
        self.builds = 0

    def cast(
        self,
        rays: RayBundle,
        index: np.ndarray,
        anchor: np.ndarray,
        poses: np.ndarray,
        threads: int,
        nearest: Nearest,
    ) -> None:
        """Adds hits of the anchored rays `index` (with repeats) with the bodies at `poses`, (b, 4, 4) float64 [m]."""
        if not len(index):
            return
        count = len(rays.table)
        chosen = np.zeros(count, bool)
        chosen[index] = True
        index = np.flatnonzero(chosen)
        scene = self._built(poses, anchor)
        if len(index) > FULL_CAST * count:
            nearest.add(scene.cast(rays.table, threads), self._surface_of)
        else:
            picked = np.take(rays.table, index, axis=0, mode="clip")
            nearest.add_rows(index, scene.cast(picked, threads), self._surface_of)

    def _surface_of(self, triangle: np.ndarray) -> np.ndarray:
        return np.take(self._surface, triangle, mode="clip")

    def _built(self, poses: np.ndarray, anchor: np.ndarray) -> TriangleScene:
        state = np.ascontiguousarray(poses[self._used])
        key = state.tobytes()
        if self._scene is None or key != self._built_for:
            self._scene = None
            self._scene = TriangleScene(self._vertices(state, anchor), self._triangles, warm=False)
            self._built_for = key
            self.builds += 1
        return self._scene

    def _vertices(self, poses: np.ndarray, anchor: np.ndarray) -> np.ndarray:
        rotation = poses[self._vertex_body, :3, :3]
        origin = poses[:, :3, 3] - anchor
        world = origin[self._vertex_body]
        for column in range(3):
            world += rotation[:, :, column] * self._local[:, column, None]
        return np.asarray(world, np.float32)


class HeavyBodies:
    """Meshes with many triangles: one scene for each unique mesh, about its centre; rays go into each body's frame."""

    def __init__(self, groups: Sequence[Sequence[Moving]], spheres: Spheres, first: int) -> None:
        """groups: the copies of each unique mesh; spheres: theirs begin at number `first`, group after group."""
        copies = [copy for group in groups for copy in group]
        self._surfaces = np.array([copy.surface for copy in copies], np.int32)
        self._bodies = np.array([copy.body for copy in copies], np.intp)
        self._centres, self._radii = spheres.local[first:], spheres.radii[first:]
        self._ends = np.cumsum([len(group) for group in groups])
        self._meshes = [group[0].mesh for group in groups]
        self._scenes: list[TriangleScene | None] = [None] * len(groups)

    def cast(
        self,
        rays: RayBundle,
        windows: tuple[np.ndarray, np.ndarray],
        centres: np.ndarray,
        poses: np.ndarray,
        threads: int,
        nearest: Nearest,
    ) -> None:
        """Adds hits with the copies at `poses`, whose sphere centres are `centres` (m, 3) [m, world].

        windows: rays, and the copy that each may meet, sorted by copy.
        """
        index, owner = windows
        if not len(index):
            return
        rotations = poses[self._bodies, :3, :3]
        index, owner, picked = self._narrowed(rays, index, owner, centres, nearest.distance)
        if not len(index):
            return
        local = _into_bodies(rays, picked, index, owner, rotations, centres)
        bounds = np.searchsorted(owner, np.concatenate([[0], self._ends]))
        parts = [
            self._scene(number).cast(local[low:high], threads)
            for number, (low, high) in enumerate(pairwise(bounds))
            if high > low
        ]
        found = parts[0] if len(parts) == 1 else TriangleHits.joined(parts)
        nearest.add_bodies(index, owner, found, rotations.astype(np.float32), self._surfaces)

    def _narrowed(
        self, rays: RayBundle, index: np.ndarray, owner: np.ndarray, centres: np.ndarray, blocked: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rays that point at their owner's sphere and are not stopped before it, with their rows of the table."""
        towards = centres - rays.origin
        distance = np.maximum(np.sqrt((towards**2).sum(axis=1)), 1e-12)
        radii = self._radii + spread_of(rays)
        cosine = np.cos(np.arcsin(np.minimum(radii / distance, 1.0)) + 1e-4)
        cosine[distance <= radii * 1.001] = -2.0
        open_ = np.flatnonzero(blocked[index] > (distance - radii - 1e-3).astype(np.float32)[owner])
        index, owner = index[open_], owner[open_]
        picked = np.take(rays.table, index, axis=0, mode="clip")
        unit = (towards / distance[:, None]).astype(np.float32)
        counts = np.bincount(owner, minlength=len(centres))
        along = _dot([np.repeat(unit[:, axis], counts) for axis in range(3)], picked[:, 3:6])
        near = np.flatnonzero(along >= np.repeat(cosine.astype(np.float32), counts))
        return index[near], owner[near], np.take(picked, near, axis=0, mode="clip")

    def _scene(self, number: int) -> TriangleScene:
        scene = self._scenes[number]
        if scene is None:
            mesh = self._meshes[number]
            first = 0 if number == 0 else int(self._ends[number - 1])
            vertices = (mesh.vertices - self._centres[first]).astype(np.float32)
            scene = self._scenes[number] = TriangleScene(vertices, mesh.triangles)
        return scene


def _into_bodies(
    rays: RayBundle,
    picked: np.ndarray,
    index: np.ndarray,
    owner: np.ndarray,
    rotations: np.ndarray,
    centres: np.ndarray,
) -> np.ndarray:
    """Rays (k, 6) float32, rows `picked` of the table, each in its owner's frame about its centre.

    The shift is worked out in float64.
    """
    counts = np.bincount(owner, minlength=len(centres))
    start = (np.swapaxes(rotations, 1, 2) @ (rays.origin - centres)[:, :, None])[:, :, 0].astype(np.float32)
    turn = rotations.astype(np.float32)
    local = np.empty_like(picked)
    offsets = None if rays.offsets is None else np.take(rays.offsets, index, axis=0, mode="clip")
    for axis in range(3):
        columns = [np.repeat(turn[:, row, axis], counts) for row in range(3)]
        local[:, 3 + axis] = _dot(columns, picked[:, 3:6])
        local[:, axis] = np.repeat(start[:, axis], counts)
        if offsets is not None:
            local[:, axis] += _dot(columns, offsets)
    return local


def _dot(columns: list[np.ndarray], vectors: np.ndarray) -> np.ndarray:
    total = columns[0] * vectors[:, 0]
    total += columns[1] * vectors[:, 1]
    total += columns[2] * vectors[:, 2]
    return np.asarray(total)
