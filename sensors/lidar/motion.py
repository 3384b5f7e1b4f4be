"""How fast what a ray hits moves: rigid bodies, seen from the world or from a sensor that moves itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sensors.raycast.shared import cast_world

from .scan import Velocities

if TYPE_CHECKING:
    from graph.sim import App


def surface_velocities(app: App, sensor_path: str, in_world: bool) -> Velocities:
    """The function a scanner asks for the velocities of hit points.

    in_world: the points' velocities in the world; otherwise relative to the sensor, its own motion and turning
    included (the rate of change of the point's sensor-frame coordinates, along world axes).
    """

    def measure(surfaces: np.ndarray, points: np.ndarray, poses: Any) -> np.ndarray:
        world = cast_world(app)
        found = np.zeros((len(points), 3))
        poses = poses or app.fabric.capture()
        body = world.body_of[surfaces]
        moving = np.flatnonzero(body >= 0)
        if len(moving):
            twists, origins = _twists(app, world.bodies, poses)
            which = body[moving]
            found[moving] = _at(twists[which], points[moving] - origins[which])
        carrier = None if in_world else _carrier(app, sensor_path)
        if carrier is not None:
            twists, origins = _twists(app, (carrier,), poses)
            found -= _at(np.broadcast_to(twists, (len(points), 6)), points - origins)
        return found

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
    """The moving body that carries a prim, or None."""
    bodies = frozenset(app.physics.body_paths) if app.physics is not None else frozenset()
    while path and path not in bodies:
        path = path.rpartition("/")[0]
    return path or None
