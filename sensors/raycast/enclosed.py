"""Standing solids in a scene of triangles: the triangles enclose them, and the formula says where a ray meets them.

A ray that meets the triangles of a solid but not the solid goes on behind them. So the scene stays as fast as it is for
triangles, whatever the number of solids, and a range is exact. A surface that is between a solid and the triangles
around it, at most about `mesh.tolerance` from the solid, may be taken for the solid.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graph.sim.geometry.surfaces import Solid

from .forms import Forms
from .rays import NOTHING, RayBundle
from .triangles import SKIN, TriangleHits, TriangleScene

MARGIN_M = 1e-4
"""Triangles lie so far outside their solid, for vertices are rounded to float32."""

MOST_STEPS = 64
"""Triangles around solids that a ray passes at most."""


class Enclosed:
    """The solids of a static scene. first: the number of their first triangle; they are the scene's last."""

    def __init__(self, solids: Sequence[Solid], first: int) -> None:
        self._forms = Forms([solid.form for solid in solids])
        self._first = np.uint32(first)
        self._solid = np.repeat(np.arange(len(solids)), [len(solid.triangles) for solid in solids])

    def correct(self, scene: TriangleScene, rays: RayBundle, found: TriangleHits, threads: int) -> None:
        """Replaces hits with the triangles of solids, which `rays` have met in the scene."""
        rows = self._on_solids(found.triangle)
        if not len(rows):
            return
        forms = self._forms.seen_from(rays.origin)
        for _ in range(MOST_STEPS):
            tried = rows, self._solid[found.triangle[rows] - self._first], rays.table, rays.offsets
            length = forms.meet(*tried)
            passed = rows[np.isinf(length)]
            travelled = found.distance[passed]
            found.distance[rows], found.normals[rows] = length, forms.normals(*tried, length)
            rows = self._go_on(scene, rays, found, passed, travelled, threads)
            if not len(rows):
                break
        found.distance[rows], found.triangle[rows], found.normals[rows] = np.inf, NOTHING, 0.0

    def _on_solids(self, triangle: np.ndarray) -> np.ndarray:
        return np.flatnonzero((triangle >= self._first) & (triangle != NOTHING))

    def _go_on(
        self,
        scene: TriangleScene,
        rays: RayBundle,
        found: TriangleHits,
        rows: np.ndarray,
        travelled: np.ndarray,
        threads: int,
    ) -> np.ndarray:
        """Writes what the rays `rows` meet behind their triangles; returns those that meet triangles of solids."""
        if not len(rows):
            return rows
        travelled = travelled + np.float32(SKIN)
        table = rays.table[rows]
        table[:, :3] += travelled[:, None] * table[:, 3:6]
        beyond = scene.cast(table, threads, uv=found.uv is not None)
        found.distance[rows] = beyond.distance + travelled
        found.triangle[rows], found.normals[rows] = beyond.triangle, beyond.normals
        if found.uv is not None:
            found.uv[rows] = beyond.uv
        return np.take(rows, self._on_solids(beyond.triangle))


def enclosing(solids: Sequence[Solid]) -> list[np.ndarray]:
    """The vertices (n, 3) [m] of each solid's triangles, enlarged about its centre until all lie outside the solid."""
    known: dict[tuple[int, str], float] = {}
    found = []
    for solid in solids:
        form = solid.form
        key = id(solid.triangles), f"{form.kind} {form.low} {form.high}"
        if key not in known:  # the same for all copies, whatever their frames: it is a ratio along lines
            known[key] = _enlarged(solid)
        thin = float(np.linalg.svd(form.frame[:3, :3], compute_uv=False)[-1])
        scale, centre = known[key] + min(MARGIN_M / thin, 0.01), form.frame[:3, 3]
        found.append(np.asarray(centre + scale * (solid.vertices - centre)))
    return found


def _enlarged(solid: Solid) -> float:
    """By what to enlarge a solid's triangles for the plane of each to be outside the solid, or touch it."""
    corners = solid.vertices[solid.triangles.astype(np.intp)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    away = ((corners[:, 0] - solid.form.frame[:3, 3]) * normals).sum(axis=1)
    reach = solid.form.support(solid.form.frame[:3, :3].T @ normals.T)
    return float((reach[away > 0] / away[away > 0]).max())
