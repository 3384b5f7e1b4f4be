"""Warnings about bodies that move as nobody wants: robots that tip over, bodies that pass through others."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from graph.sim.physics.world_model import Collider

    from .engine import MujocoEngine

TIPPED = math.cos(math.radians(45))
"""Cosine of the turn from its first pose beyond which a robot's base has tipped over."""


class BodyWatch:
    """Looks at all bodies at once: whether the bases of driven robots stand as at first, and whether no free body moves
    by more than its size in a step. Each body is reported once. It reads the state that the last step started from.
    """

    def __init__(self, engine: MujocoEngine) -> None:
        model, paths = engine.model, engine.body_paths
        gravity = np.array(model.opt.gravity)
        strength = float(np.linalg.norm(gravity))
        bases = [1 + paths.index(path) for path in _bases(engine)] if strength else []
        self._bases = np.array(bases, dtype=np.intp)
        turned = engine.data.xmat[self._bases].reshape(-1, 3, 3)
        up = -gravity / max(strength, 1e-12)
        self._uprights: Floats = np.einsum("i,nkj,k->nij", up, turned, up).reshape(-1, 9)
        """(n, 9) with the base's rotation: the cosine of its turn from its first pose, away from gravity."""
        joints = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        free = [(int(model.jnt_bodyid[joint]) - 1, int(model.jnt_dofadr[joint])) for joint in joints]
        sizes = _sizes(engine)
        free = [(row, dof) for row, dof in free if row < len(paths) and math.isfinite(sizes[row])]
        self._rows = np.array([row for row, _ in free], dtype=np.intp)
        self._dofs = np.array([dof + np.arange(3) for _, dof in free], dtype=np.intp).reshape(-1, 3)
        self._sizes = sizes[self._rows]

    def look(self, engine: MujocoEngine, warn: Warn) -> None:
        """Warns of `body-tipped` and `body-too-fast`."""
        if len(self._bases):
            upright = (engine.data.xmat.take(self._bases, axis=0) * self._uprights).sum(axis=1)
            if upright.min() < TIPPED:
                self._tell_tipped(engine, upright, warn)
        if len(self._rows):
            speeds = engine.data.qvel.take(self._dofs)
            dt = engine.model.opt.timestep
            slow = float(self._sizes.min()) / dt / 2  # at least sqrt(3): no body moves by its size
            if speeds.max() > slow or speeds.min() < -slow:
                moves = np.sqrt((speeds * speeds).sum(axis=1)) * dt
                if (moves > self._sizes).any():
                    self._tell_fast(engine, moves, warn)

    def _tell_tipped(self, engine: MujocoEngine, upright: Floats, warn: Warn) -> None:
        for body in self._bases[upright < TIPPED].tolist():
            warn(
                "body-tipped",
                engine.body_name(body),
                f"this base of a robot has turned by more than 45 degrees at {float(engine.data.time):.3g} s; "
                "give it supports around its centre of mass, such as casters in front and behind, or its drives less "
                "force (maxForce)",
            )
        left = upright >= TIPPED
        self._bases, self._uprights = self._bases[left], self._uprights[left]

    def _tell_fast(self, engine: MujocoEngine, moves: Floats, warn: Warn) -> None:
        fast = moves > self._sizes
        worst = int(np.flatnonzero(fast)[0])
        others = int(fast.sum()) - 1
        more = f" ({others:,} other bodies likewise)" if others else ""
        rate = math.ceil(moves[worst] / float(engine.dt) / self._sizes[worst])
        warn(
            "body-too-fast",
            engine.body_paths[self._rows[worst]],
            f"it moves by {moves[worst]:.3g} m in a physics step, its size is {self._sizes[worst]:.3g} m{more}: it "
            f"can pass through others without contact; raise physics_hz to {rate:,}",
        )
        self._rows, self._dofs, self._sizes = self._rows[~fast], self._dofs[~fast], self._sizes[~fast]


def _bases(engine: MujocoEngine) -> Iterator[str]:
    """The free base of each articulation that has a driven joint."""
    mechanisms = engine.world.mechanisms
    if mechanisms is None:
        return
    moved = {body for joint in engine.joints if joint.drive is not None for body in joint.bodies if body}
    bodies = set(engine.body_paths)
    for root in mechanisms.roots:
        links = mechanisms.carriers(root)
        base = next(iter(links), "")
        if base in bodies and engine.is_free(base) and not moved.isdisjoint(links):
            yield base


def _sizes(engine: MujocoEngine) -> Floats:
    """(B,) the largest extent of each body's colliders [m]; infinite for a body without one."""
    rows = {path: row for row, path in enumerate(engine.body_paths)}
    sizes = np.zeros(len(rows))
    for collider in engine.world.colliders:
        if collider.body in rows and not collider.trigger:
            row = rows[collider.body]
            sizes[row] = max(sizes[row], _extent(collider))
    sizes[sizes == 0] = math.inf
    for body in engine.world.bodies:
        if body.kinematic and body.path in rows:
            sizes[rows[body.path]] = math.inf
    return sizes


def _extent(collider: Collider) -> float:
    if collider.kind == "plane":
        return math.inf
    if collider.vertices is not None and len(collider.vertices):
        return float(np.ptp(collider.vertices, axis=0).max())
    if collider.kind in ("box", "ellipsoid", "sphere"):
        return 2 * max(collider.size, default=math.inf)
    if collider.kind in ("capsule", "cylinder"):
        radius, half = collider.size
        return 2 * (half + radius if collider.kind == "capsule" else max(radius, half))
    return math.inf
