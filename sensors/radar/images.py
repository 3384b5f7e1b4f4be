"""The radar as mirrors show it, and how fast the ways to it grow.

A ray that has met flat faces goes on as if it came from the radar's image in them, so that the length of its way is
that to one plane. Rates of ways need no points either: a rigid body's velocity along a ray is the same at all points of
the ray, as if the body extended to the ray's origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sensors.compiled import compiled, inlined
from sensors.vectors import Vector, dot, row_of

_MIX = np.uint64(0x9E3779B97F4A7C15)


@dataclass(frozen=True, slots=True)
class Twists:
    """Velocities of bodies as the radar sees them, as if each extended to the radar.

    linear [m/s], angular [rad/s]: (b + 1, 3) float64; the last, which body -1 finds, are those of what stands still.
    """

    linear: np.ndarray
    angular: np.ndarray

    @classmethod
    def of(cls, bodies: np.ndarray, own: np.ndarray | None) -> Twists:
        """bodies: (b, 6), own: (6,) twists at the radar's place, in the world; own: None where the radar stands."""
        all_of_them = np.vstack((bodies, np.zeros((1, 6))))
        if own is not None:
            all_of_them = all_of_them - own
        return cls(all_of_them[:, :3], all_of_them[:, 3:])

    def seen_from(self, rotation: np.ndarray) -> Twists:
        """The same in the axes of a sensor that is turned by `rotation` (3, 3), sensor to world."""
        return Twists(self.linear @ rotation, self.angular @ rotation)


class Images(NamedTuple):
    """The radar as mirrors show it, one image for each order of faces that tubes have met; c of them.

    place: (c, 3) float64 from the radar [m]; all vectors are in the sensor's axes. turn: (c, 3, 3), what the mirrors
    make of directions. rate: (c, 3) [m/s], how fast ways from it to the last mirror grow is that times their direction.
    key: (c,) uint64 of the faces, whatever their order.
    """

    place: np.ndarray
    turn: np.ndarray
    rate: np.ndarray
    key: np.ndarray

    @classmethod
    def none(cls) -> Images:
        """The radar itself."""
        return cls(np.zeros((1, 3)), np.eye(3)[None], np.zeros((1, 3)), np.zeros(1, np.uint64))

    def beyond(
        self,
        image: np.ndarray,
        normal: np.ndarray,
        height: np.ndarray,
        plane: np.ndarray,
        speeds: tuple[Twists, np.ndarray],
    ) -> Images:
        """The images of some of them, by their numbers (m,), in planes (m,).

        normal: (m, 3), height: (m,) [m] over the radar, of the planes; speeds: the twists, and the planes' bodies (m,).
        """
        twists, body = speeds
        count = len(image)
        place, rate = np.empty((2, count, 3))
        found = Images(place, np.empty((count, 3, 3)), rate, self.key[image] + plane_keys(plane))
        _mirror(self, image, normal, height, twists.linear, twists.angular, body, found)
        return found


@compiled
def _mirror(
    images: Images,
    image: np.ndarray,
    normals: np.ndarray,
    height: np.ndarray,
    linear: np.ndarray,
    angular: np.ndarray,
    bodies: np.ndarray,
    found: Images,
) -> None:
    """Writes the places, turns and rates of `Images.beyond`."""
    for row in range(len(image)):
        of, body, normal = image[row], bodies[row], row_of(normals, row)
        place, known = row_of(images.place, of), row_of(images.rate, of)
        twice = 2.0 * (height[row] - dot(normal, place))
        further = place[0] + twice * normal[0], place[1] + twice * normal[1], place[2] + twice * normal[2]
        speed, spin = row_of(linear, body), row_of(angular, body)
        own, there = _at(speed, spin, place), _at(speed, spin, further)
        coming = known[0] + own[0], known[1] + own[1], known[2] + own[2]
        back = 2.0 * dot(normal, coming)
        for axis in range(3):
            found.place[row, axis] = further[axis]
            found.rate[row, axis] = coming[axis] - back * normal[axis] - there[axis]
            column = images.turn[of, 0, axis], images.turn[of, 1, axis], images.turn[of, 2, axis]
            along = 2.0 * dot(normal, column)
            for other in range(3):
                found.turn[row, other, axis] = column[other] - along * normal[other]


@inlined
def _at(speed: Vector, spin: Vector, place: Vector) -> Vector:
    """The velocity of a body's place from its twist."""
    (x, y, z), (a, b, c) = spin, place
    return speed[0] + (y * c - z * b), speed[1] + (z * a - x * c), speed[2] + (x * b - y * a)


def plane_keys(plane: np.ndarray) -> np.ndarray:
    """(k,) uint64 of planes; sums of them tell sets of planes."""
    return np.asarray((plane.astype(np.uint64) + np.uint64(1)) * _MIX)
