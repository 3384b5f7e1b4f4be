"""Checks the initial state of a scene: bodies that overlap, velocities that joints do not allow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .protocol import PhysicsEngine

DEEP = 0.01
"""Overlaps deeper than this [m] are reported; the engine pushes such bodies apart at about 18 m/s per metre."""

OFF = 1e-3
"""A velocity that differs from the authored one by more than this fraction of it, or by this much [m/s, rad/s], is
reported.
"""


def tell_start(physics: PhysicsEngine, warn: Warn) -> None:
    """Warns about the initial state of a world that has just been built: `bodies-overlap`, `velocity-not-possible`."""
    overlaps = sorted(_overlaps(physics).items(), key=lambda item: (item[1], item[0]))
    for (first, second), distance in overlaps[:1]:
        more = len(overlaps) - 1
        others = f", and so {'does 1 other pair' if more == 1 else f'do {more:,} other pairs'}" if more else ""
        warn(
            "bodies-overlap",
            first,
            f"it and {second} overlap by {-distance:.3g} m when play begins{others}; they are thrown apart. Move them "
            "apart, or name one in physics:filteredPairs of the other",
        )
    held = list(_lost_velocities(physics))
    for path, text in held[:1]:
        others = f" ({len(held) - 1:,} other bodies likewise)" if len(held) > 1 else ""
        warn("velocity-not-possible", path, f"{text}: its joints allow no other{others}. Author what the joints allow")


def _overlaps(physics: PhysicsEngine) -> dict[tuple[str, str], float]:
    """The negative distance [m] of each pair of bodies (or static colliders) that overlap deeply."""
    contacts, found = physics.contacts(), dict[tuple[str, str], float]()
    for index in np.flatnonzero(contacts.distances < -DEEP).tolist():
        sides = zip(contacts.bodies[index], contacts.pairs[index], strict=True)
        first, second = sorted(body or collider for body, collider in sides)
        if not {first, second} & set(physics.deformable_paths):  # soft bodies yield slowly
            found[first, second] = min(found.get((first, second), 0.0), float(contacts.distances[index]))
    return found


def _lost_velocities(physics: PhysicsEngine) -> Iterator[tuple[str, str]]:
    """Bodies that do not start with their authored velocity, and the velocity that they have."""
    wanted = [body for body in physics.world.bodies if body.velocity.any() or body.angular_velocity.any()]
    if not wanted:
        return
    motion, arms = physics.velocities(), physics.centers_of_mass - physics.positions
    rows = {path: row for row, path in enumerate(physics.body_paths)}
    for body in wanted:
        if body.kinematic or body.path not in rows:
            continue
        row = rows[body.path]
        linear = motion[row, :3] + np.cross(motion[row, 3:], arms[row])
        for has, asked, unit in ((linear, body.velocity, "m/s"), (motion[row, 3:], body.angular_velocity, "rad/s")):
            size = float(np.linalg.norm(asked))
            if size and np.linalg.norm(has - asked) > OFF * (1 + size):
                yield body.path, f"it starts with {_shown(has)} {unit}, not {_shown(asked)}"
                break


def _shown(vector: Floats) -> str:
    return f"({', '.join(f'{part:.3g}' for part in vector + 0.0)})"
