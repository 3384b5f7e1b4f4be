"""The radar as mirrors show it, and how fast the ways to it grow.

A ray that has met flat faces goes on as if it came from the radar's image in them, so that the length of its way is
that to one plane. Rates of ways need no points either: a rigid body's velocity along a ray is the same at all points of
the ray, as if the body extended to the ray's origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

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

    def at(self, body: Any, place: np.ndarray) -> np.ndarray:
        """Velocities (..., 3) [m/s] of bodies, by number, at places (..., 3) [m] from the radar."""
        x, y, z = np.moveaxis(self.angular[body], -1, 0)
        a, b, c = np.moveaxis(place, -1, 0)
        return np.asarray(self.linear[body] + np.stack((y * c - z * b, z * a - x * c, x * b - y * a), -1))


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
        self, image: np.ndarray, normal: np.ndarray, height: np.ndarray, plane: np.ndarray, speeds: tuple[Twists, Any]
    ) -> Images:
        """The images of some of them, by their numbers (m,), in planes (m,).

        normal: (m, 3), height: (m,) [m] over the radar, of the planes; speeds: the twists, and the planes' bodies (m,).
        """
        place, turn, rate = self.place[image], self.turn[image], self.rate[image]
        twists, body = speeds
        away = height - (normal * place).sum(axis=1)
        further = place + 2.0 * away[:, None] * normal
        coming = rate + twists.at(body, place)
        mirrored = coming - 2.0 * (normal * coming).sum(axis=1)[:, None] * normal
        return Images(
            further,
            turn - 2.0 * normal[:, :, None] * np.einsum("ci,cij->cj", normal, turn)[:, None],
            mirrored - twists.at(body, further),
            self.key[image] + plane_keys(plane),
        )


def plane_keys(plane: np.ndarray) -> np.ndarray:
    """(k,) uint64 of planes; sums of them tell sets of planes."""
    return np.asarray((plane.astype(np.uint64) + np.uint64(1)) * _MIX)
