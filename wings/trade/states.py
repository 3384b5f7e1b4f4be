"""What the bodies of a run did: their poses, velocities and contacts over time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import rotation_matrices

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.physics.protocol import PhysicsEngine

Floats = NDArray[np.float64]

MOST_NUMBERS = 8_000_000
"""Numbers kept of a run; of longer ones only every n-th step is."""
PER_BODY = 13


@dataclass(frozen=True)
class Trajectory:
    """The states of B bodies at n times; world axes, SI units.

    times (n,) of simulation; positions (n, B, 3) of origins; orientations (n, B, 4) w, x, y, z; velocities (n, B, 6),
    linear of the origins, then angular. masses (B,); inertias (B, 3, 3) about the centres of mass, along the bodies'
    axes; centres (B, 3) of mass in the bodies' frames. free (B,): held by neither a joint nor a user. depths (n,): the
    deepest contact. touching (n, B): whether a body touches anything. gravity (3,).
    """

    paths: tuple[str, ...]
    times: Floats
    positions: Floats
    orientations: Floats
    velocities: Floats
    masses: Floats
    inertias: Floats
    centres: Floats
    free: NDArray[np.bool_]
    depths: Floats
    touching: NDArray[np.bool_]
    gravity: Floats


class StateLog:
    """Records the bodies of an App that has begun to play, from now on, after each physics step.

    duration: about how long it will run [s]. If bodies are added or removed meanwhile, later states are left out.
    also: called whenever a state is recorded.
    """

    def __init__(self, app: App, duration: float, also: Callable[[], object] = tuple) -> None:
        self._app, self._also = app, also
        self._engine: PhysicsEngine | None = app.physics
        self._rows: list[tuple[float, Floats, Floats, Floats, float, NDArray[np.bool_]]] = []
        self._until = 0
        if self._engine is None:
            return
        self._paths = self._engine.body_paths
        self._number = {path: row for row, path in enumerate(self._paths)}
        steps = duration * float(app.simulation.steps_per_second)
        self._stride = max(1, math.ceil(steps * len(self._paths) * PER_BODY / MOST_NUMBERS))
        self._end: Callable[[], None] = app.on("physics_post_step", self._step)
        self._take()

    def _step(self) -> None:
        self._until += 1
        if self._until >= self._stride:
            self._take()

    def _take(self) -> None:
        engine = self._engine
        assert engine is not None
        self._until = 0
        if self._app.physics is not engine or engine.body_paths != self._paths:
            self._end()
            return
        contacts = engine.contacts()
        touching = np.zeros(len(self._paths), np.bool_)
        touching[[self._number[body] for pair in contacts.bodies for body in pair if body in self._number]] = True
        depth = float(-min(contacts.distances.min(initial=0.0), 0.0))
        self._rows.append(
            (
                float(self._app.simulation.time),
                engine.positions.copy(),
                engine.quaternions.copy(),
                engine.velocities().copy(),
                depth,
                touching,
            )
        )
        self._also()

    def trajectory(self) -> Trajectory | None:
        """What was recorded, before the App closes; None if nothing can move."""
        engine = self._engine
        if engine is None or not self._rows or not self._paths:
            return None
        times, positions, turns, velocities, depths, touching = zip(*self._rows, strict=True)
        rotations = rotation_matrices(engine.quaternions)
        offsets = engine.centers_of_mass - engine.positions
        free = [engine.is_free(path) and path not in engine.kinematic for path in self._paths]
        return Trajectory(
            self._paths,
            np.array(times),
            np.stack(positions),
            np.stack(turns),
            np.stack(velocities),
            np.array(engine.masses),
            np.array(engine.inertias),
            np.einsum("bji,bj->bi", rotations, offsets),
            np.array(free, np.bool_),
            np.array(depths),
            np.stack(touching),
            engine.gravity,
        )
