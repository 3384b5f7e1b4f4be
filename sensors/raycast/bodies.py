"""Moving geometry: light bodies together in one scene, heavy meshes each in a scene of their own frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .rays import RayBundle
from .triangles import TriangleHits, TriangleScene

if TYPE_CHECKING:
    from graph.sim.geometry import Mesh

HEAVY_TRIANGLES = 150
"""From here on casting in the body's frame costs less than rebuilding (raycasting facts, 3)."""


class LightBodies:
    """Small moving meshes, transformed and rebuilt as one scene when a pose in it changed since the last build.

    The scene depends on the anchor, the meshes and their poses alone, never on who casts.
    """

    def __init__(self, meshes: Sequence[Mesh], surfaces: Sequence[int], bodies: Sequence[int]) -> None:
        counts = [len(mesh.vertices) for mesh in meshes]
        starts = np.cumsum([0, *counts[:-1]])
        self._local = np.concatenate([np.asarray(mesh.vertices, np.float64) for mesh in meshes])
        self._triangles = np.concatenate(
            [np.asarray(mesh.triangles, np.uint32) + np.uint32(s) for mesh, s in zip(meshes, starts, strict=True)]
        )
        self._used = np.unique(np.asarray(bodies))
        self._vertex_body = np.repeat(np.searchsorted(self._used, bodies), counts)
        self._surface = np.repeat(np.asarray(surfaces, np.int32), [len(mesh.triangles) for mesh in meshes])
        self._built_for: bytes | None = None
        self._scene: TriangleScene | None = None
        self.builds = 0

    def cast(self, table: np.ndarray, anchor: np.ndarray, poses: np.ndarray, threads: int) -> TriangleHits:
        """Hits of anchored rays with the bodies at `poses`, (b, 4, 4) float64 world [m] of all bodies."""
        state = np.ascontiguousarray(poses[self._used])
        key = state.tobytes()
        if self._scene is None or key != self._built_for:
            self._scene = None
            self._scene = TriangleScene(self._vertices(state, anchor), self._triangles, warm=False)
            self._built_for = key
            self.builds += 1
        return self._scene.cast(table, threads)

    def surface_of(self, triangle: np.ndarray) -> np.ndarray:
        """The surface of each triangle index."""
        return np.asarray(self._surface[triangle])

    def _vertices(self, poses: np.ndarray, anchor: np.ndarray) -> np.ndarray:
        rotation = poses[self._vertex_body, :3, :3]
        origin = poses[:, :3, 3] - anchor
        world = origin[self._vertex_body]
        for column in range(3):
            world += rotation[:, :, column] * self._local[:, column, None]
        return np.asarray(world, np.float32)


class HeavyMesh:
    """One mesh with many triangles, and every body that carries it: rays are moved into each body's frame.

    Only rays that may meet a body's bounding sphere are cast; a body whose sphere holds the sensor gets them all.
    """

    def __init__(self, meshes: Sequence[Mesh], surfaces: Sequence[int], bodies: Sequence[int]) -> None:
        vertices = np.asarray(meshes[0].vertices, np.float64)
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        self._centre = (low + high) / 2
        self._radius = float(np.sqrt(((vertices - self._centre) ** 2).sum(axis=1).max())) * (1 + 1e-6) + 1e-6
        self._vertices = (vertices - self._centre).astype(np.float32)
        self._triangles = np.asarray(meshes[0].triangles, np.uint32)
        self._scene: TriangleScene | None = None
        self._instances = list(zip(surfaces, bodies, strict=True))

    def cast(
        self, rays: RayBundle, poses: np.ndarray, threads: int, skip: frozenset[int]
    ) -> tuple[list[tuple[int, np.ndarray, slice, np.ndarray]], TriangleHits] | None:
        """All bodies' windows in one call.

        skip: surfaces left out. Returns per body (surface, indices into the bundle, rows of the hits, rotation of the
        body), and the hits with normals in body frames; None where no ray comes near.
        """
        windows, blocks, start = [], [], 0
        spread = 0.0 if rays.offsets is None else float(np.sqrt((rays.offsets**2).sum(axis=1).max(initial=0.0)))
        for surface, body in self._instances:
            if surface in skip:
                continue
            rotation = poses[body, :3, :3]
            centre = poses[body, :3, 3] + rotation @ self._centre
            index = _window(rays, centre - rays.origin, self._radius + spread)
            if len(index):
                blocks.append(_into_body(rays, index, rotation, centre))
                windows.append((surface, index, slice(start, start + len(index)), rotation))
                start += len(index)
        if not windows:
            return None
        if self._scene is None:
            self._scene = TriangleScene(self._vertices, self._triangles)
        return windows, self._scene.cast(blocks[0] if len(blocks) == 1 else np.concatenate(blocks), threads)


def _window(rays: RayBundle, to_centre: np.ndarray, radius: float) -> np.ndarray:
    """Indices of the rays that may meet a sphere: those within its apparent radius, a little widened."""
    distance = float(np.linalg.norm(to_centre))
    if distance <= radius * 1.001:
        return np.arange(len(rays.directions))
    half_angle = float(np.arcsin(radius / distance)) + 1e-4
    towards = to_centre / distance
    if rays.order is None:
        return np.flatnonzero(_along(rays.directions, towards) >= np.float32(np.cos(half_angle)))
    index = rays.order.near(towards, half_angle)
    near = _along(rays.directions[index], towards) >= np.float32(np.cos(half_angle))
    return np.asarray(np.sort(index[near]))


def _along(directions: np.ndarray, towards: np.ndarray) -> np.ndarray:
    x, y, z = towards.astype(np.float32)
    cosine = directions[:, 0] * x
    cosine += directions[:, 1] * y
    cosine += directions[:, 2] * z
    return np.asarray(cosine)


def _into_body(rays: RayBundle, index: np.ndarray, rotation: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Rays (k, 6) float32 in the body's frame about its centre; the shift is worked out in float64."""
    block = np.empty((len(index), 6), np.float32)
    turn = rotation.astype(np.float32)
    block[:, 0:3] = rotation.T @ (rays.origin - centre)
    if rays.offsets is not None:
        block[:, 0:3] += turned_back(rays.offsets[index], turn)
    block[:, 3:6] = turned_back(rays.directions[index], turn)
    return block


def turned_back(vectors: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) in the axes of the rotated frame: R^T v, column by column, so that no length changes the sums."""
    out = np.empty(vectors.shape, np.result_type(vectors, rotation))
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    column, term = np.empty(len(vectors), out.dtype), np.empty(len(vectors), out.dtype)
    for axis in range(3):
        np.multiply(x, rotation[0, axis], out=column)
        column += np.multiply(y, rotation[1, axis], out=term)
        column += np.multiply(z, rotation[2, axis], out=term)
        out[:, axis] = column
    return out


def turned(vectors: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) of the rotated frame in the outer axes: R v, column by column."""
    return turned_back(vectors, rotation.T)
