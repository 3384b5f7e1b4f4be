"""Casts rays at some surfaces alone, as if nothing else existed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from graph.sim.geometry.surfaces import Mesh, Plane

from .forms import Forms
from .planes import cast_plane
from .rays import RayBundle
from .triangles import TriangleScene
from .world import CastWorld


def cast_alone(
    world: CastWorld, surfaces: Sequence[int], rays: RayBundle, index: np.ndarray | None, state: Any = None
) -> np.ndarray:
    """Distances (k,) float32 [m] of rays of a bundle to the nearest of some surfaces; infinite for a miss.

    index: (k,) rays that may meet them; None: all. The scene is built about the rays' origin and then dropped: for
    occasional use with few surfaces.
    """
    which = slice(None) if index is None else index
    table = np.zeros((len(rays.table[which]), 6), np.float32)
    table[:, 3:6] = rays.table[which, 3:6]
    offsets = None if rays.offsets is None else rays.offsets[which]
    if offsets is not None:
        table[:, :3] = offsets
    nearest = np.full(len(table), np.inf, np.float32)
    poses = world.body_poses(state)
    vertices, triangles, start = [], [], 0
    for number in surfaces:
        mesh = world.surfaces[number]
        if isinstance(mesh, Mesh) and not world.is_solid(mesh) and len(mesh.triangles):
            vertices.append((world.vertices(number, poses, state) - rays.origin).astype(np.float32))
            triangles.append(np.asarray(mesh.triangles, np.uint32) + np.uint32(start))
            start += len(mesh.vertices)
    if start:
        scene = TriangleScene(np.concatenate(vertices), np.concatenate(triangles), warm=False)
        nearest = scene.cast(table, world.threads).distance
    every = np.arange(len(table))
    for number in surfaces:
        solid = world.surfaces[number]
        if world.is_solid(solid):
            form, body = Forms([solid.form]), world.body_of[number]
            pose = poses[body][None] if body >= 0 and poses is not None else None
            length = form.seen_from(rays.origin, pose).meet(every, np.zeros_like(every), table, offsets)
            np.minimum(nearest, length.astype(np.float32), out=nearest)
        if isinstance(world.surfaces[number], Plane):
            origin, normal = world.plane(number, poses)
            height = float((rays.origin - origin) @ normal)
            np.minimum(nearest, cast_plane(height, offsets, table, normal), out=nearest)
    return nearest
