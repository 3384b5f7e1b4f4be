"""What the radar sees without a further ray: its fan has looked there already."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sensors.compiled import inlined
from sensors.vectors import Vector, dot

from .bins import whole
from .setting import Faces, height_of, normal_of

SIGHT_M = 5e-3
"""A point is in sight if a ray to it comes so near."""

UNKNOWN, SEEN, HIDDEN = 0, 1, 2


class Steps(NamedTuple):
    """Directions in equal steps: `across` in a row, `up` rows, the lowest first.

    left, lowest: azimuth and elevation [rad] where the first steps begin, wide, tall: [rad] of each.
    """

    across: int
    up: int
    left: float
    wide: float
    lowest: float
    tall: float


NO_STEPS = Steps(0, 0, 0.0, 1.0, 0.0, 1.0)


class Sights(NamedTuple):
    """What the fan meets: plane (n,) int32 of each of its rays, row by row, negative where none is known. patch: (p,)
    int64, the flat patch of each plane. Without rays nothing is known.
    """

    steps: Steps
    plane: np.ndarray
    patch: np.ndarray


@inlined
def looks(sights: Sights, faces: Faces, face: Any, back: Vector, out: Any) -> int:
    """Whether the radar sees a place on a face `out` [m] away in the direction `back`, a unit vector in its axes.

    Known where the four rays of the fan about it meet one flat patch: it is that of the face, or before or behind it.
    What is narrower than the fan's steps is overlooked there.
    """
    steps, plane = sights.steps, sights.plane
    if len(plane) == 0:
        return UNKNOWN
    place = (math.atan2(back[1], back[0]) - steps.left) / steps.wide - 0.5
    level = (math.asin(min(max(back[2], -1.0), 1.0)) - steps.lowest) / steps.tall - 0.5
    column, row = whole(place), whole(level)
    if not (0 <= column < steps.across - 1 and 0 <= row < steps.up - 1):
        return UNKNOWN
    at = row * steps.across + column
    one, two, three, four = plane[at], plane[at + 1], plane[at + steps.across], plane[at + steps.across + 1]
    if min(min(one, two), min(three, four)) < 0 or max(max(one, two), max(three, four)) >= len(sights.patch):
        return UNKNOWN
    patch, curved = sights.patch[one], faces.curved[one]
    if not one == two == three == four:  # mostly all are one plane
        if sights.patch[two] != patch or sights.patch[three] != patch or sights.patch[four] != patch:
            return UNKNOWN
        curved = curved or faces.curved[two] or faces.curved[three] or faces.curved[four]
    if curved:
        return UNKNOWN
    if 0 <= face < len(sights.patch) and sights.patch[face] == patch:
        return SEEN
    wall = np.int64(one)
    slope = dot(normal_of(faces, wall), back)
    away = height_of(faces, wall) / slope if slope != 0 else np.inf
    return HIDDEN if 0 < away < out - SIGHT_M else UNKNOWN
