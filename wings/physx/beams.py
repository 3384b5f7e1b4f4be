"""The channels of PhysX sensors' beams, for any pattern."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.transforms import apply, transformed
from sensors.gmo.layout import ElementFlags
from sensors.raycast.rays import cast_ranged
from sensors.raycast.world import CastWorld


def fire(
    world: CastWorld,
    pose: np.ndarray,
    origins: np.ndarray,
    directions: np.ndarray,
    ranges: tuple[float, float],
    poses: Any = None,
    exclude: frozenset[str] = frozenset(),
) -> np.ndarray:
    """How far each beam goes from its origin, (n,) float32 [m]; inf without a hit.

    pose: sensor to world [m]; origins: (n, 3) or (3,) [m], directions: (n, 3), unit, in the sensor's axes. As PhysX
    does, a beam begins minRange ahead of its origin and goes maxRange from there.
    """
    nearest, farthest = ranges
    starts, ways = transformed(pose, origins), apply(pose[:3, :3], directions)
    hits = cast_ranged(world, starts, ways, ranges, poses, exclude)
    reached = hits.distance
    depths = reached + np.float32(nearest)
    depths[reached > farthest] = np.inf
    return depths


def told(
    wanted: frozenset[str], depths: np.ndarray, origins: np.ndarray, directions: np.ndarray, ranges: tuple[float, float]
) -> dict[str, np.ndarray]:
    """The requested channels of beams with these depths (inf: no hit).

    distance: the depth, maxRange without a hit. xyz: the end of the beam, in the sensor's axes; without a hit minRange
    + maxRange ahead, as in PhysX. flags: VALID for a hit.
    """
    hit = np.isfinite(depths)
    arrays: dict[str, np.ndarray] = {}
    if "distance" in wanted:
        arrays["distance"] = np.where(hit, depths, np.float32(ranges[1]))
    if "xyz" in wanted:
        ends = np.where(hit, depths, np.float32(sum(ranges)))
        arrays["xyz"] = (origins + directions * ends[:, None]).astype(np.float32)
    if "flags" in wanted:
        arrays["flags"] = np.where(hit, np.uint8(ElementFlags.VALID), np.uint8(0))
    return arrays
