"""Moving meshes: all in one scene, each in its own cell; rays are transformed into the frame of each mesh they may hit.

Nothing is ever rebuilt: the rays move, not the meshes. A ray enters at the mesh's bounding sphere, which keeps float32
as precise there as near the origin; a hit beyond the sphere belongs to another cell and does not count. The choice of
rays does not change a result: a ray's hit does not depend on the other rays.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .near import NEAR_RAD, Moving, NearMeshes
from .nearest import Nearest, turn_each
from .places import Pairs, Places, windows
from .rays import RayBundle
from .triangles import TriangleScene

PITCH = 4.0
"""Distance between the cells' centres, in radii of their content: outside one sphere, a ray is not yet in the next."""

BEFORE = 1.01
"""Where a ray enters: this many radii before the point of its line nearest to the centre."""

BEYOND = 2.05
"""Beyond this distance, in radii, a hit does not belong to the mesh."""

ALL_ROUND_RAD = np.deg2rad(60.0)
"""Above this half angle of a near mesh, all rays are cast at the near meshes."""

FEW_RAYS = 10_000
"""Up to this many rays it costs less to cast all at a few small meshes than to select."""


class MovingMeshes:
    """The scene of all moving meshes; copies of one mesh (`Mesh.unique_key`) share a cell.

    surfaces, bodies: (m,), the surface number of each and its body's; boxes: (m, 2, 3) [m] around them and radii: (m,)
    [m] of spheres about the boxes' centres, in the frames of the bodies.
    """

    def __init__(self, moving: Sequence[Moving]) -> None:
        self.surfaces = np.array([entry.surface for entry in moving], np.uint32)
        self.bodies = np.array([entry.body for entry in moving], np.intp)
        points = [entry.mesh.vertices for entry in moving]
        self.boxes = np.array([(each.min(axis=0), each.max(axis=0)) for each in points])
        centre = self.boxes.mean(axis=1)
        radii = [np.sqrt(((each - at) ** 2).sum(axis=1).max()) for each, at in zip(points, centre, strict=True)]
        self.radii = np.array(radii) * (1 + 1e-6) + 1e-6
        self._lengths = self.radii.astype(np.float32)
        self._near = NearMeshes(moving)
        if not self._near.all_few:  # otherwise all are gathered
            self._build(moving, centre)

    @property
    def few(self) -> bool:
        """Whether all meshes are small and few, so that all rays may be cast at all of them."""
        return self._near.all_few

    def _build(self, moving: Sequence[Moving], centre: np.ndarray) -> None:
        first: dict[bytes, int] = {}
        for number, entry in enumerate(moving):
            first.setdefault(entry.mesh.unique_key, number)
        side = int(np.ceil(round(len(first) ** (1 / 3), 6)))
        order = np.arange(len(first))
        cells = PITCH * (np.stack([order % side, order // side % side, order // side**2], axis=1) - (side - 1) / 2)
        # By content: in what order the file names the meshes changes no cell, and so no last bit of a hit.
        first = dict(sorted(first.items()))
        cell_of = dict(zip(first, cells, strict=True))
        self._cells = np.array([cell_of[entry.mesh.unique_key] for entry in moving])
        vertices, triangles, start, begins, count = [], [], 0, {}, 0
        for cell, at in zip(cells, first.values(), strict=True):
            mesh = moving[at].mesh
            vertices.append(((mesh.vertices - centre[at]) / self.radii[at] + cell).astype(np.float32))
            triangles.append(np.asarray(mesh.triangles, np.uint32) + np.uint32(start))
            begins[mesh.unique_key] = count
            start, count = start + len(mesh.vertices), count + len(mesh.triangles)
        self._begins = np.array([begins[entry.mesh.unique_key] for entry in moving], np.uint32)
        self._counts = np.array([len(entry.mesh.triangles) for entry in moving], np.uint32)
        self._scene = TriangleScene(np.concatenate(vertices), np.concatenate(triangles))

    def cast_together(
        self, rays: RayBundle, kept: np.ndarray, anchor: np.ndarray, poses: np.ndarray, threads: int, nearest: Nearest
    ) -> bool:
        """Adds hits of all rays with the meshes kept (m,) bool, if these are few and small; whether that was done."""
        if not self.few or not (rays.parts or len(rays.table) <= FEW_RAYS):
            return False
        if kept.any():
            self._near.cast(rays, None, np.flatnonzero(kept), anchor, poses, threads, nearest)
        return True

    def cast_near(
        self,
        rays: RayBundle,
        places: Places,
        seen: np.ndarray,
        kept: np.ndarray,
        anchor: np.ndarray,
        poses: np.ndarray,
        threads: int,
        nearest: Nearest,
    ) -> np.ndarray:
        """Adds hits with the meshes seen (1, m) bool that are small and near (see `near`); which of them, (1, m) bool.

        poses: (b, 4, 4) float64 [m] of the bodies.
        """
        near = seen & self._near.small
        if not self._near.few:
            near &= places.half > NEAR_RAD
        if near.any():
            around = places.half[near].max() > ALL_ROUND_RAD
            index = None if around else windows(rays, (rays,), places, near).index
            gathered = np.flatnonzero(self._near.small & kept if self._near.few else near)
            self._near.cast(rays, index, gathered, anchor, poses, threads, nearest)
        return near

    def cast(
        self, rays: RayBundle, pairs: Pairs, places: Places, poses: np.ndarray, threads: int, nearest: Nearest
    ) -> None:
        """Adds hits of the rays of some pairs, each in the cell of its mesh.

        poses: (p or 1, b, 4, 4) float64 [m] of the bodies, as each bundle sees them.
        """
        index, pair, which = pairs.index, pairs.pair, pairs.surface
        rotations = poses[pairs.look if len(poses) > 1 else 0, self.bodies[which], :3, :3]
        turns = np.ascontiguousarray(rotations.transpose(1, 2, 0), np.float32)
        local, entry = self._into_cells(rays, pairs, places.towards[pairs.look, which], rotations, turns)
        found = self._scene.cast(local, threads, uv=nearest.with_spots)
        own = np.flatnonzero(found.distance <= BEYOND)
        begins, counts = self._begins[which], self._counts[which]
        if rays.offsets is not None:  # a ray with its own origin may start in the cell of another mesh, and meet that
            place = found.triangle.take(own) - begins.take(pair[own])  # below its begin it wraps around
            own = own[place < counts.take(pair[own])]
        index, pair = index[own], pair[own]
        distance = (found.distance[own] + entry[own]) * self._lengths[which].take(pair)

        def normals(rows: np.ndarray) -> np.ndarray:
            return turn_each(found.normals.take(own[rows], axis=0), turns, pair[rows])

        def spots(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            assert found.uv is not None
            triangle = found.triangle.take(own[rows]) - begins.take(pair[rows])
            return triangle, found.uv.take(own[rows], axis=0)

        nearest.add_some(index, distance, self.surfaces[which].take(pair), normals, spots)

    def _into_cells(
        self, rays: RayBundle, pairs: Pairs, towards: np.ndarray, rotations: np.ndarray, turns: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rays (r, 6) float32 in their meshes' cells, and their entry distances, (r,) float32; both in radii.

        towards: (k, 3) [m] to the meshes of the pairs; turns: (3, 3, k) float32, the rotations. The shift between the
        frames is computed in float64.
        """
        index, radii = pairs.index, self.radii[pairs.surface]
        towards = towards / radii[:, None]
        shift = self._cells[pairs.surface] - (np.swapaxes(rotations, 1, 2) @ towards[:, :, None])[:, :, 0]
        frames = np.concatenate([towards.T, shift.T, 1 / radii[None], turns.reshape(9, -1)], dtype=np.float32)
        each = np.repeat(frames, np.bincount(pairs.pair, minlength=len(radii)), axis=1)  # much faster than by number
        way, at, scale, turn = each[:3], each[3:6], each[6], each[7:].reshape(3, 3, -1)
        directions = rays.directions.take(index, axis=1)
        entry = _dot(way, directions)  # to the point nearest to the mesh's centre
        if rays.offsets is not None:
            offsets = rays.offsets.take(index, axis=0, mode="clip").T * scale
            entry -= _dot(directions, offsets)
        entry -= np.float32(BEFORE)
        np.maximum(entry, np.float32(0), out=entry)
        local = np.empty((len(index), 6), np.float32)
        for axis in range(3):
            if rays.offsets is not None:
                at[axis] += _dot(turn[:, axis], offsets)
            direction = _dot(turn[:, axis], directions)
            local[:, 3 + axis] = direction
            np.add(at[axis], np.multiply(direction, entry, out=direction), out=local[:, axis])
        return local, entry


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Dot products of vectors (3, n), pairwise."""
    total = first[0] * second[0]
    total += first[1] * second[1]
    total += first[2] * second[2]
    return np.asarray(total)
