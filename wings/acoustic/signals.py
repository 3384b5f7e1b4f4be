"""From rays to signals: the direct wave and the first echoes between two mounts.

Echoes are those of hard surfaces in Kirchhoff's approximation: on the lit side the pressure is twice that of the
incident wave, elsewhere 0. The surface that a ray tube meets adds

    (j k / 2 pi) A D_t D_r (r_t / r_r) (cos_r / cos_t) exp(-j k (r_t + r_r)) dW sinc sinc

to the pressure at a receiver (A: amplitude at 1 m; D: directivities; r: distances to transmitter and receiver; cos: of
the angles to the surface's normal; dW: the tube's solid angle). The sincs integrate a phase that is linear over the
tube. Over an infinite wall this is the image source: A D_t D_r / (r_t + r_r).
"""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import apply
from sensors.raycast.rays import RayBundle, RayMemory, cast_ranged
from sensors.raycast.world import CastWorld

from .fan import Fan
from .waves import SPEED_OF_SOUND, Membrane, absorption

CLEAR = 1e-3
"""How far [m] from both ends of a way nothing counts as standing in it: the surface that it starts on does not."""

GRAZING = 1e-4
"""Least cosine between a ray and a normal."""


class Air:
    """What a sound of one frequency [Hz] does on its way."""

    def __init__(self, frequency: float) -> None:
        self.wave_number = 2 * math.pi * frequency / SPEED_OF_SOUND
        self._absorption = absorption(frequency)

    def wave(self, length: np.ndarray) -> np.ndarray:
        """Phase and absorption over a length [m], complex128; spreading apart."""
        return np.asarray(np.exp(-(1j * self.wave_number + self._absorption) * length.astype(np.float64)))


@dataclass(frozen=True, slots=True)
class Scene:
    """What is cast at: the world in a state, without the excluded prims."""

    world: CastWorld
    poses: Any
    exclude: frozenset[str]

    def open(self, starts: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Which straight ways from starts (n, 3) to end (3,), world [m], nothing stands in, (n,) bool."""
        ways = end - starts
        lengths = np.linalg.norm(ways, axis=1)
        directions = ways / np.maximum(lengths, 1e-12)[:, None]
        ranges = CLEAR, float(lengths.max(initial=0.0))
        hits = cast_ranged(self.world, starts, directions, ranges, self.poses, self.exclude)
        return np.asarray(hits.distance >= lengths - 2 * CLEAR)


@dataclass(frozen=True, slots=True)
class Lit:
    """The surfaces that a transmitter's tubes meet; float32, vectors by axis.

    origin: (3,) float64, where the transmitter is, world [m]. directions: (3, n) unit; distances: (n,) [m]; normals:
    (3, n) unit, towards the transmitter; cosines: (n,) between them. waves: (n,) D_t dW r_t / cos_t. across, up: (3, n)
    [m], the sides of each tube's footprint.
    """

    origin: np.ndarray
    directions: np.ndarray
    distances: np.ndarray
    normals: np.ndarray
    cosines: np.ndarray
    waves: np.ndarray
    across: np.ndarray
    up: np.ndarray


class Beam:
    """The fan of a transmitter as it is turned in the world, kept while its turn stays the same."""

    def __init__(self, fan: Fan, membrane: Membrane) -> None:
        self._fan = fan
        self._solid = (membrane.gain(fan.directions[0]) * fan.solid).astype(np.float32)
        self._table = np.zeros((len(fan.solid), 6), np.float32)
        self._memory = RayMemory()
        self._turned_by = b""

    def _turn(self, rotation: np.ndarray) -> None:
        if rotation.tobytes() == self._turned_by:
            return
        turn = rotation.astype(np.float32)
        self._directions, self._across, self._up = (
            apply(turn, part, axis=0) for part in (self._fan.directions, self._fan.across, self._fan.up)
        )
        self._table[:, 3:] = self._directions.T
        self._memory.forget()
        self._turned_by = rotation.tobytes()

    def lit(self, scene: Scene, pose: np.ndarray, reach: float) -> Lit:
        """What the tubes meet within `reach` [m], from a mount with this pose (4, 4)."""
        self._turn(pose[:3, :3])
        origin = pose[:3, 3]
        parts: tuple[np.ndarray, ...] = self._directions, self._across, self._up, self._solid
        bundle = RayBundle(
            origin=origin,
            table=self._table,
            exclude=scene.exclude,
            reach=reach,
            columns=self._directions,
            memory=self._memory,
        )
        hits = scene.world.cast(bundle, scene.poses, normals=True)
        assert hits.normals is not None
        normals, distances = np.ascontiguousarray(hits.normals.T), hits.distance
        cosines = -_dot(normals, self._directions)
        met = (distances < reach) & (distances > CLEAR) & (np.abs(cosines) > GRAZING)
        if not met.all():
            rows = np.flatnonzero(met)
            normals, distances, cosines = normals.take(rows, axis=1), distances[rows], cosines[rows]
            parts = tuple(part.take(rows, axis=-1) for part in parts)
        directions, across, up, solid = parts
        normals *= np.sign(cosines)
        cosines = np.abs(cosines)
        sides = []
        for side in (across, up):
            along = _dot(side, normals) / cosines  # so that the side lies in the surface
            sides.append((side + along * directions) * distances)
        return Lit(origin, directions, distances, normals, cosines, solid * distances / cosines, *sides)


def echoes(
    scene: Scene, air: Air, membrane: Membrane, lit: Lit, receiver: np.ndarray, *, is_sender: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Delays (n,) [s] and waves (n,) complex of the first echoes at a receiver with this pose (4, 4).

    is_sender: the receiver is the transmitter itself, which sees all that it lights.
    """
    if is_sender:
        ways, distances, cosines = lit.directions, lit.distances, lit.cosines
    else:
        lit, ways, distances, cosines = _seen(scene, lit, receiver[:3, 3])
    gain = membrane.gain(apply(receiver[None, :3, 0].astype(np.float32), ways, axis=0)[0])
    lengths = lit.distances + distances
    slope = np.float32(air.wave_number / (2 * math.pi)) * (lit.directions + ways)
    footprint = np.sinc(_dot(slope, lit.across)) * np.sinc(_dot(slope, lit.up))
    spread = lit.waves * gain * cosines / distances * footprint
    return lengths / SPEED_OF_SOUND, 1j * air.wave_number / (2 * math.pi) * spread * air.wave(lengths)


def _seen(scene: Scene, lit: Lit, place: np.ndarray) -> tuple[Lit, np.ndarray, np.ndarray, np.ndarray]:
    """What a receiver at `place` (3,) hears of the lit surfaces.

    Its part of them, unit vectors (3, n) and distances (n,) [m] from the receiver, cosines (n,) to the normals.
    """
    points = lit.directions * lit.distances
    ways = points - (place - lit.origin).astype(np.float32)[:, None]
    distances = np.sqrt(_dot(ways, ways))
    facing = -_dot(ways, lit.normals)
    seen = (facing > 0) & (distances > CLEAR)
    rows = np.flatnonzero(seen)
    if len(rows):
        rows = rows[scene.open(lit.origin + points[:, rows].T, place)]
    taken = Lit(lit.origin, *(getattr(lit, one.name)[..., rows] for one in fields(Lit)[1:]))
    distances = distances[rows]
    return taken, ways[:, rows] / distances, distances, facing[rows] / distances


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(n,) products of vectors (3, n)."""
    return np.asarray(first[0] * second[0] + first[1] * second[1] + first[2] * second[2])


def direct(
    scene: Scene, air: Air, membrane: Membrane, sender: np.ndarray, receiver: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Delay and wave of the sound that goes straight from mount to mount, poses (4, 4); none where that is blocked.

    A mount that listens while it sends does not hear itself.
    """
    way = receiver[:3, 3] - sender[:3, 3]
    length = float(np.linalg.norm(way))
    if length <= CLEAR or not scene.open(sender[None, :3, 3], receiver[:3, 3])[0]:
        return np.zeros(0), np.zeros(0, np.complex128)
    cosines = np.array([way @ sender[:3, 0], -way @ receiver[:3, 0]]) / length
    lengths = np.array([length])
    return lengths / SPEED_OF_SOUND, membrane.gain(cosines).prod() / length * air.wave(lengths)
