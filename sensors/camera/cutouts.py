"""Looks through places that are not seen: cut-out leaves, wire netting, prims without opacity."""

from __future__ import annotations

from typing import Any

import numpy as np

from sensors.raycast.rays import NOTHING, Hits, RayBundle, Spots
from sensors.raycast.world import CastWorld

from .looks import Looks
from .view import View

MOST_LAYERS = 32
"""A ray ends behind so many unseen places, one behind the other."""


def see_through(world: CastWorld, view: View, looks: Looks, far: float, state: Any) -> View:
    """The view with what lies behind unseen places; the same view where all is seen.

    far: distance from the image plane [m] that is shown. Of a rolling shutter, what lies behind is as in `state`.
    """
    rows = np.flatnonzero(np.isfinite(view.hits.distance))
    rows = rows[looks.unseen(view.hits, rows)]
    if not len(rows):
        return view
    view.facing_normals()
    hits = _copied(view.hits)
    for _ in range(MOST_LAYERS):
        start = hits.distance[rows]
        start += np.float32(2e-4) + np.float32(2e-6) * start
        beyond = view.rays.further(rows, view.bundle, start)
        behind = world.cast(beyond, state, normals=True, spots=hits.spots is not None)
        _face(behind, beyond)
        _put(hits, rows, behind, behind.distance + start)
        rows = rows[np.isfinite(behind.distance)]
        rows = rows[looks.unseen(hits, rows)]
        if not len(rows):
            break
    hits.distance[rows], hits.number[rows] = np.inf, NOTHING
    along = view.rays.along
    depth = hits.distance if along is None else hits.distance * along
    outside = depth > far
    hits.distance[outside], hits.number[outside] = np.inf, NOTHING
    return View(view.rays, view.bundle, hits, depth, faced=True)


def _copied(hits: Hits) -> Hits:
    spots = None if hits.spots is None else Spots(hits.spots.triangle.copy(), hits.spots.uv.copy())
    assert hits.normals is not None
    return Hits(hits.distance.copy(), hits.normals.copy(), hits.number.copy(), hits.surface_of, spots)


def _face(hits: Hits, rays: RayBundle) -> None:
    """Turns normals towards where the rays come from."""
    assert hits.normals is not None
    away = (hits.normals * rays.table[:, 3:6]).sum(axis=1) > 0
    hits.normals[away] *= np.float32(-1)


def _put(hits: Hits, rows: np.ndarray, found: Hits, distance: np.ndarray) -> None:
    hits.distance[rows], hits.number[rows] = distance, found.number
    if hits.normals is not None and found.normals is not None:
        hits.normals[rows] = found.normals
    if hits.spots is not None and found.spots is not None:
        hits.spots.triangle[rows], hits.spots.uv[rows] = found.spots.triangle, found.spots.uv
