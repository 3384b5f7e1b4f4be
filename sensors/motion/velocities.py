"""Velocities of hit points: rigid bodies, relative to the world or to a moving sensor."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sensors.compiled import compiled

if TYPE_CHECKING:
    from graph.sim.state.prim_poses import PrimPoses
    from sensors.raycast.world import CastWorld


class Velocities(NamedTuple):
    """Gives the velocities of surfaces of a world.

    sensor_path: relative to this sensor, with its own translation and rotation included (the rate of change of the
    point's sensor-frame coordinates, along world axes); None: velocities in the world.
    """

    fabric: PrimPoses
    world: CastWorld
    sensor_path: str | None

    def of(
        self,
        surfaces: np.ndarray,
        levers: Callable[[], np.ndarray],
        origin: np.ndarray,
        poses: Any,
        own: Callable[[], np.ndarray | None],
    ) -> tuple[np.ndarray | slice, np.ndarray] | None:
        """The rows that move (m,), or all as a slice, and their velocities (m, 3) float32 [m/s] along world axes.

        None if nothing moves.

        surfaces: (k,) that were hit. levers: gives the levers (3, k) float32 [m, world axes] from an origin to the hit
        points. origin: (3,) float64 [m, world]. poses: a state. own: gives the sensor's velocities, (6, k) float32
        [m/s, rad/s], when each ray was fired, as if it extended to the origin; None: those of the state for all rays.
        """
        fabric, world = self.fabric, self.world
        poses = poses or fabric.capture()
        body = np.take(world.body_of, surfaces, mode="clip")
        moving = np.flatnonzero(body >= 0)
        carrier = None if self.sensor_path is None else fabric.body_of(self.sensor_path)
        if carrier is None and not len(moving):
            return None
        twists = twists_at(fabric, world.bodies, origin, poses) if len(moving) else _AT_REST
        if carrier is None:
            return moving, _of_points(moving, body, levers(), twists, _AT_REST)
        twist = own()
        if twist is None:
            twist = twists_at(fabric, (carrier,), origin, poses)
        return slice(None), _of_points(np.arange(len(surfaces)), body, levers(), twists, twist)


def twists_at(fabric: PrimPoses, bodies: tuple[str, ...], place: np.ndarray, poses: Any) -> np.ndarray:
    """(6, n) float32 linear [m/s] and angular [rad/s] velocities, world axes, of bodies at a place (3,) float64 [m].

    As if each body extended to that place.
    """
    twists = np.array(poses.velocities(bodies))
    origins = np.asarray(fabric.rigid_matrices(bodies, poses))[:, :3, 3]
    twists[:, :3] += np.cross(twists[:, 3:], place - origins)
    return np.ascontiguousarray(twists.T, np.float32)


_AT_REST = np.zeros((6, 1), np.float32)


def _of_points(
    rows: np.ndarray, body: np.ndarray, levers: np.ndarray, twists: np.ndarray, own: np.ndarray
) -> np.ndarray:
    """(m, 3) float32 [m/s], see `_velocities`."""
    found = np.empty((len(rows), 3), np.float32)
    _velocities(rows, body, np.ascontiguousarray(levers), twists, own, found)
    return found


@compiled
def _velocities(
    rows: np.ndarray, body: np.ndarray, levers: np.ndarray, twists: np.ndarray, own: np.ndarray, found: np.ndarray
) -> None:
    """Writes v + w x r of points `rows` (m,) on bodies (k,), -1 for what stands, less that of the sensor.

    levers: (3, k); twists: (6, b) of the bodies; own: (6, k or 1) of the sensor.
    """
    for at in range(len(rows)):
        row, carrier = rows[at], body[rows[at]]
        ray = min(row, own.shape[1] - 1)
        for axis in range(3):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            up, across = levers[j, row], levers[i, row]
            speed = np.float32(0)
            if carrier >= 0:
                speed = up * twists[3 + i, carrier] - across * twists[3 + j, carrier] + twists[axis, carrier]
            found[at, axis] = speed - (up * own[3 + i, ray] - across * own[3 + j, ray] + own[axis, ray])
