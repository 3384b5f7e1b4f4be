"""Applies changes of the stage to a running engine: it adopts the changed world, and unchanged parts keep their
state.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from graph.base.paths import at_or_below
from graph.sim import transforms
from graph.sim.scene.scan import Scan, scan_stage
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .authored_settings import check_settings
from .protocol import PhysicsEngine
from .read_forces import start_surfaces
from .read_joints import SUFFIX
from .read_world import Known, read_world
from .world_model import Collider, WorldModel


def rebuild(
    physics: PhysicsEngine, stage: Any, touched: Iterable[str], warn: Warn, promoted: Mapping[str, bool] | None = None
) -> bool:
    """Makes the engine adopt the present stage, in the present state; False if nothing can move any more.

    touched: paths of edited prims. Mechanisms (bodies that joints connect) without an edit at, above or below their
    prims keep their rest poses and everything derived from them; the others rest in their present poses. promoted: see
    `Scan`. Raises UserError, with the engine unchanged, if it refuses the scene.
    """
    check_settings(stage, warn, mirrors=bool(physics.world.given))
    scan = scan_stage(stage, promoted)
    if not scan.dynamic:
        return False
    old = physics.world
    same = _untouched(old, scan, tuple(touched))
    rest = {body.path: body.pose for body in old.bodies}
    scan.placed = {
        path: rest[path] if path in same else _pose(physics, number)
        for number, path in enumerate(physics.body_paths)
        if path in scan.bodies and path in rest
    }
    world = read_world(scan, warn, _parts(old, same))
    compiled_from_elsewhere = frozenset(physics.body_paths).difference(rest)
    physics.adopt(world, same | compiled_from_elsewhere, warn)
    start_surfaces(physics, warn)
    return True


def restart(
    physics: PhysicsEngine,
    stage: Any,
    poses: Mapping[str, Floats],
    warn: Warn,
    promoted: Mapping[str, bool] | None = None,
) -> None:
    """Restarts with the bodies at `poses` (rigid, metres), and velocities, drives and grippers from the stage."""
    world = physics.world
    if any(not np.array_equal(body.pose, poses.get(body.path, body.pose)) for body in world.bodies):
        scan = scan_stage(stage, promoted)
        scan.placed = {path: pose for path, pose in poses.items() if path in scan.bodies}
        world = read_world(scan, warn)
    physics.adopt(world, None, warn)
    start_surfaces(physics, warn)


def _pose(physics: PhysicsEngine, number: int) -> Floats:
    return transforms.rigid(physics.rotations[number], physics.positions[number])


def _untouched(old: WorldModel, scan: Scan, touched: tuple[str, ...]) -> frozenset[str]:
    """The bodies of mechanisms whose bodies and joints are all unchanged."""
    parent: dict[str, str] = {}

    def find(path: str) -> str:
        while parent.setdefault(path, path) != path:
            path = parent[path]
        return path

    ties = {joint.path: joint.bodies for joint in scan.joints}
    before = {
        joint.path.partition(":")[0]: joint.bodies  # several axes share a prim
        for joint in old.joints
        if not joint.path.endswith(SUFFIX)
    }
    for bodies in (*ties.values(), *before.values()):
        first, second = bodies
        if first and second:
            parent[find(first)] = find(second)
    had = {body.path for body in old.bodies}
    has = {path for path in scan.bodies if path in scan.moving}
    changed = had ^ has | {path for path in had & has if _related(path, touched)}
    for path in ties.keys() | before.keys():
        there, now = before.get(path), ties.get(path)
        if now is None or (there is None and any(now)) or _related(path, touched):
            changed.update(body for body in (*(there or ()), *(now or ())) if body)
    groups = {find(path) for path in changed}
    return frozenset(path for path in had & has if find(path) not in groups)


def _related(path: str, touched: tuple[str, ...]) -> bool:
    """Whether one of the touched prims is a prim itself, a descendant or an ancestor of it."""
    return any(at_or_below(path, other) or at_or_below(other, path) for other in touched)


def _parts(old: WorldModel, same: frozenset[str]) -> Known:
    """The same objects for bodies, joints and colliders of unchanged mechanisms: their rest poses stay bit for bit."""
    colliders: dict[str, list[Collider]] = {}
    for collider in old.colliders:
        if collider.body in same:
            colliders.setdefault(collider.path, []).append(collider)
    return Known(
        {body.path: body for body in old.bodies if body.path in same},
        {joint.path: joint for joint in old.joints if same.issuperset(filter(None, joint.bodies))},
        colliders,
    )
