"""Velocities of hit points: rigid bodies, relative to the world or to a moving sensor."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from sensors.raycast.shared import cast_world, present_app

if TYPE_CHECKING:
    from graph.sim import App


class Velocities(Protocol):
    """A function that gives the velocities of surfaces."""

    def __call__(
        self,
        surfaces: np.ndarray,
        levers: Callable[[], np.ndarray],
        origin: np.ndarray,
        poses: Any,
        own: Callable[[], np.ndarray | None] | None = None,
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """The rows that move (m,) and their velocities (m, 3) float32 [m/s] along world axes; None if nothing moves.

        surfaces: (k,) that were hit. levers: gives the levers (3, k) float32 [m, world axes] from an origin to the hit
        points. origin: (3,) float64 [m, world]. poses: a state. own: gives the sensor's velocities, (6, k) float32
        [m/s, rad/s], when each ray was fired, as if it extended to the origin; None: those of the state for all rays.
        """


def surface_velocities(app: App, sensor_path: str, in_world: bool) -> Velocities:
    """The function that a scanner calls for the velocities of hit points.

    in_world: velocities in the world; otherwise relative to the sensor, with its own translation and rotation included
    (the rate of change of the point's sensor-frame coordinates, along world axes).
    """
    weak = weakref.ref(app)

    def measure(
        surfaces: np.ndarray,
        levers: Callable[[], np.ndarray],
        origin: np.ndarray,
        poses: Any,
        own: Callable[[], np.ndarray | None] | None = None,
    ) -> tuple[np.ndarray, np.ndarray] | None:
        app = present_app(weak)
        world = cast_world(app)
        poses = poses or app.fabric.capture()
        body = np.take(world.body_of, surfaces, mode="clip")
        moving = np.flatnonzero(body >= 0)
        carrier = None if in_world else _carrier(app, sensor_path)
        if carrier is None and not len(moving):
            return None
        lever = levers()
        found = np.zeros((3, len(moving)), np.float32)
        if len(moving):
            twists = twists_at(app, world.bodies, origin, poses)
            found = _at([np.take(column, body[moving]) for column in twists], np.take(lever, moving, axis=1))
        if carrier is None:
            return moving, found.T
        twist = None if own is None else own()
        relative = -_at(list(twists_at(app, (carrier,), origin, poses)[:, 0] if twist is None else twist), lever)
        relative[:, moving] += found
        return np.arange(len(surfaces)), relative.T

    return measure


def twists_at(app: App, bodies: tuple[str, ...], place: np.ndarray, poses: Any) -> np.ndarray:
    """(6, n) float32 linear [m/s] and angular [rad/s] velocities, world axes, of bodies at a place (3,) float64 [m].

    As if each body extended to that place.
    """
    twists = np.array(poses.velocities(bodies))
    origins = np.asarray(app.fabric.rigid_matrices(bodies, poses))[:, :3, 3]
    twists[:, :3] += np.cross(twists[:, 3:], place - origins)
    return np.ascontiguousarray(twists.T, np.float32)


def _at(twist: Sequence[np.ndarray], lever: np.ndarray) -> np.ndarray:
    """v + w x r: (3, n) float32 of six numbers or columns, and levers (3, n)."""
    out = np.empty(lever.shape, np.float32)
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        column = out[axis]
        np.multiply(lever[j], twist[3 + i], out=column)
        column -= lever[i] * twist[3 + j]
        column += twist[axis]
    return out


def _carrier(app: App, path: str) -> str | None:
    """The moving body or animated prim that carries a prim, or None."""
    found: str | None = app.fabric.body_of(path)
    return found
