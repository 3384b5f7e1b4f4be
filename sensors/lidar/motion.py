"""How fast what a ray hits moves: rigid bodies, seen from the world or from a sensor that moves itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from sensors.raycast.shared import cast_world

from .returns import Velocities

if TYPE_CHECKING:
    from graph.sim import App


def surface_velocities(app: App, sensor_path: str, in_world: bool) -> Velocities:
    """The function a scanner asks for the velocities of hit points.

    in_world: the points' velocities in the world; otherwise relative to the sensor, its own motion and turning
    included (the rate of change of the point's sensor-frame coordinates, along world axes).
    """

    def measure(
        surfaces: np.ndarray, points: Callable[[np.ndarray], np.ndarray], poses: Any
    ) -> tuple[np.ndarray, np.ndarray]:
        world = cast_world(app)
        poses = poses or app.fabric.capture()
        carrier = None if in_world else _carrier(app, sensor_path)
        body = np.take(world.body_of, surfaces, mode="clip")
        rows = np.flatnonzero(body >= 0) if carrier is None else np.arange(len(surfaces))
        if not len(rows):
            return rows, np.zeros((0, 3))
        at, body = points(rows), body[rows]
        found = np.zeros((len(rows), 3))
        moving = np.flatnonzero(body >= 0)
        if len(moving):
            twists, origins = _twists(app, world.bodies, poses)
            found[moving] = _at(twists[body[moving]], at[moving] - origins[body[moving]])
        if carrier is not None:
            twists, origins = _twists(app, (carrier,), poses)
            found -= _at(np.broadcast_to(twists, (len(rows), 6)), at - origins)
        return rows, found

    return measure


def _twists(app: App, bodies: tuple[str, ...], poses: Any) -> tuple[np.ndarray, np.ndarray]:
    """Linear and angular velocities (n, 6) and origins (n, 3) of bodies [m/s, rad/s, m], world axes."""
    origins = np.asarray(app.fabric.rigid_matrices(bodies, poses))[:, :3, 3]
    return np.asarray(poses.velocities(bodies)), origins


def _at(twists: np.ndarray, lever: np.ndarray) -> np.ndarray:
    """v + w x r, written out by columns."""
    (vx, vy, vz, wx, wy, wz), (x, y, z) = twists.T, lever.T
    return np.stack([vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x], axis=1)


def _carrier(app: App, path: str) -> str | None:
    """The moving body or animated prim that carries a prim, or None."""
    found: str | None = app.fabric.body_of(path)
    return found
