"""Rays that begin at a distance from their origins, like those of PhysX sensors."""

from __future__ import annotations

from typing import Any

import numpy as np

from .rays import Hits, RayBundle, RayCaster


def cast_ranged(
    caster: RayCaster,
    origins: np.ndarray,
    directions: np.ndarray,
    ranges: tuple[float, float],
    poses: Any = None,
    exclude: frozenset[str] = frozenset(),
    *,
    normals: bool = False,
) -> Hits:
    """Hits of rays that begin at the first of two ranges [m] ahead of their origins, so that nothing nearer is hit.

    Hits farther than the second range from where the rays begin, from where their distances count, may be left out.
    origins: (n, 3) or (3,) float64, world [m]; directions: (n, 3), unit, world axes.
    """
    nearest, farthest = ranges
    starts = origins + nearest * directions
    middle = starts.mean(axis=0)
    table = np.zeros((len(directions), 6), np.float32)
    table[:, 3:] = directions
    bundle = RayBundle(middle, table, (starts - middle).astype(np.float32), exclude)
    bundle.reach = bundle.spread() + farthest * (1 + 1e-6)
    return caster.cast(bundle, poses, normals=normals)
