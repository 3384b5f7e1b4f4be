"""Moving meshes: all in one scene, each in its own cell; rays are transformed into the frame of each mesh they may hit.

Nothing is ever rebuilt: the rays move, not the meshes. A ray enters at the mesh's bounding sphere, which keeps float32
as precise there as near the origin; a hit beyond the sphere belongs to another cell and does not count. The choice of
rays does not change a result: a ray's hit does not depend on the other rays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sensors.compiled import compiled

from .near import NEAR_RAD, Moving, NearMeshes
from .nearest import Nearest
from .places import Pairs, Places, windows
from .rays import COMMON, RayBundle, Spots
from .triangles import shared_scene

PITCH = 4.0
"""Distance between the cells' centres, in radii of their content: outside one sphere, a ray is not yet in the next."""

BEFORE = 1.01
"""Where a ray enters: this many radii before the point of its line nearest to the centre."""

BEYOND = 2.05
"""Beyond this distance, in radii, a hit does not belong to the mesh."""

ALL_ROUND_RAD = np.deg2rad(60.0)
"""Above this half angle of a near mesh, all rays are cast at the near meshes."""

SCATTERED_M = 1.0
"""Rays that begin farther than this from their origin have nothing near them in common."""

BESIDE = np.float32(1e-3)
"""A ray is not cast if it passes a mesh's box by more than this, in radii of its sphere."""

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
        self._halves = ((self.boxes[:, 1] - self.boxes[:, 0]) / (2 * self.radii[:, None])).astype(np.float32) + BESIDE
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
        self._scene = shared_scene(np.concatenate(vertices), np.concatenate(triangles))

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
            near &= places.half > (NEAR_RAD if rays.spread() < SCATTERED_M else math.inf)
        if near.any():
            around = rays.grid is not None and places.half[near].max() > ALL_ROUND_RAD
            index = None if around else windows(rays, (rays,), places, near, nearest.distance).index
            gathered = np.flatnonzero(self._near.small & kept if self._near.few else near)
            self._near.cast(rays, index, gathered, anchor, poses, threads, nearest)
        return near

    def cast(
        self, rays: RayBundle, pairs: Pairs, places: Places, poses: np.ndarray, threads: int, nearest: Nearest
    ) -> None:
        """Adds hits of the rays of some pairs, each in the cell of its mesh.

        poses: (p or 1, b, 4, 4) float64 [m] of the bodies, as each bundle sees them.
        """
        which, radii = pairs.surface, self.radii[pairs.surface]
        turns = poses[pairs.look if len(poses) > 1 else 0, self.bodies[which], :3, :3]
        towards = places.towards[pairs.look, which] / radii[:, None]
        shift = self._cells[which] - (np.swapaxes(turns, 1, 2) @ towards[:, :, None])[:, :, 0]  # in float64
        cells, halves = self._cells[which].astype(np.float32), self._halves[which]
        frames = np.concatenate([towards, shift, turns.reshape(-1, 9), cells, halves], axis=1, dtype=np.float32)
        offsets = COMMON if rays.offsets is None else rays.offsets
        lengths, room = radii.astype(np.float32), len(pairs.index)
        local, entry = np.empty((room, 6), np.float32), np.empty(room, np.float32)
        index, pair = np.empty((2, room), np.intp)
        count = _into_cells(
            *(pairs.index, pairs.pair, rays.table, offsets, nearest.distance, frames, lengths),
            *(local, entry, index, pair),
        )
        if not count:
            return
        local, entry, index, pair = local[:count], entry[:count], index[:count], pair[:count]
        found = self._scene.cast(local, threads, uv=nearest.with_spots)
        met = found.distance, found.triangle, found.normals
        distance, triangle, normals = (np.empty_like(one) for one in met)
        _out_of_cells(
            *(pair, entry, *met, frames, lengths, self._begins[which], self._counts[which]),
            *(distance, triangle, normals),
        )
        spots = None if found.uv is None else Spots(triangle, found.uv)
        nearest.add_some(index, distance, self.surfaces[which].take(pair), normals, spots)


@compiled
def _into_cells(
    index: np.ndarray,
    pair: np.ndarray,
    table: np.ndarray,
    offsets: np.ndarray,
    nearest: np.ndarray,
    frames: np.ndarray,
    radii: np.ndarray,
    local: np.ndarray,
    entry: np.ndarray,
    rays: np.ndarray,
    meshes: np.ndarray,
) -> int:
    """Writes rays (r, 6) float32 in their meshes' cells, and their entry distances, (r,) float32; both in radii. Of
    those that may meet the mesh's box before their nearest hit so far, which it counts, also `rays` and `meshes` (r,).

    index, pair: of the ray and its mesh, which are tried. table, offsets, nearest: of all rays. frames: (k, 21)
    float32, of each mesh the way to its centre in radii, the place of the rays' origin in its cell, its rotation, by
    rows, its cell, and half its box in radii; radii: (k,) [m].
    """
    count = 0
    for row in range(len(index)):
        ray, mesh = index[row], pair[row]
        own, scale = min(ray, len(offsets) - 1), np.float32(1) / radii[mesh]
        x, y, z = offsets[own, 0] * scale, offsets[own, 1] * scale, offsets[own, 2] * scale
        u, v, w = table[ray, 3], table[ray, 4], table[ray, 5]
        # To the point nearest to the mesh's centre, less the way before it.
        ahead = frames[mesh, 0] * u + frames[mesh, 1] * v + frames[mesh, 2] * w - (u * x + v * y + w * z)
        entry[count] = ahead = max(ahead - np.float32(BEFORE), np.float32(0))
        # The end of the way, as far as the nearest hit, which is rounded up.
        enter, leave = np.float32(0), nearest[ray] * scale * (1 + BESIDE) - ahead + BESIDE
        for axis in range(3):
            one, two, three = frames[mesh, 6 + axis], frames[mesh, 9 + axis], frames[mesh, 12 + axis]
            direction = one * u + two * v + three * w
            start = frames[mesh, 3 + axis] + (one * x + two * y + three * z) + direction * ahead
            local[count, axis], local[count, 3 + axis] = start, direction
            each = np.float32(1) / (direction + np.float32(1e-20))  # a ray along a side is never, or always, within
            span, middle = abs(each) * frames[mesh, 18 + axis], each * (frames[mesh, 15 + axis] - start)
            enter, leave = max(enter, middle - span), min(leave, middle + span)
        if enter <= leave:
            rays[count], meshes[count] = ray, mesh
            count += 1
    return count


@compiled
def _out_of_cells(
    pair: np.ndarray,
    entry: np.ndarray,
    distance: np.ndarray,
    triangle: np.ndarray,
    normals: np.ndarray,
    frames: np.ndarray,
    radii: np.ndarray,
    begins: np.ndarray,
    counts: np.ndarray,
    far: np.ndarray,
    own: np.ndarray,
    turned: np.ndarray,
) -> None:
    """Writes hits in the cells (r,) as distances [m], inf for those of other meshes, triangles of meshes, and normals.

    entry, frames, radii: of `_into_cells`; begins, counts: (k,) uint32, the triangles of each mesh in the scene.
    """
    for row in range(len(pair)):
        mesh = pair[row]
        own[row] = triangle[row] - begins[mesh]
        far[row] = (distance[row] + entry[row]) * radii[mesh]
        # A ray with its own origin may start in the cell of another mesh, and meet that.
        if not (distance[row] <= BEYOND and begins[mesh] <= triangle[row] < begins[mesh] + counts[mesh]):
            far[row] = np.inf
        x, y, z = normals[row, 0], normals[row, 1], normals[row, 2]
        for axis in range(3):
            one, two, three = frames[mesh, 6 + 3 * axis], frames[mesh, 7 + 3 * axis], frames[mesh, 8 + 3 * axis]
            turned[row, axis] = one * x + two * y + three * z
