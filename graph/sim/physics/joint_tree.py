"""Which body is the parent of which: a forest of the joints, and the joints that close loops."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graph.base.records import dataclass
from graph.sim import transforms
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .d6_joints import moved, step
from .world_model import Body, Joint, WorldModel

SNAP = 1e-3
"""Joint frames farther apart than this [m or rad] give a warning, because the joint pulls its body into place."""


@dataclass(frozen=True)
class Branch:
    """A body, its parent body (None: the world) and the joint between them (None: it is free)."""

    body: Body
    parent: str | None
    joint: Joint | None
    reversed: bool = False
    """The joint's second body is the parent."""


@dataclass(frozen=True)
class Forest:
    """Branches with parents before children, and the joints that connect two bodies of one tree."""

    branches: tuple[Branch, ...]
    loops: tuple[Joint, ...]


def grow_forest(world: WorldModel, warn: Warn) -> Forest:
    """Makes every body a child of the world or of another body, breadth first, joints in stage order.

    A group of jointed bodies has the world as root if a joint says so, else a kinematic body, else a given one, else
    its first body that is not the second body of any joint, which floats freely. If the frames of a joint do not meet,
    the child is moved.
    """
    given = [body.path for body in world.given]
    bodies = {body.path: body for body in (*world.given, *world.bodies)}
    ties = tuple(joint for joint in world.joints if joint.kind != "distance")
    placed = [*given, *(path for path, body in bodies.items() if body.kinematic)]
    hanging = _spanning(ties, frozenset(placed))
    at: dict[str | None, list[Joint]] = {}
    for joint in ties:
        if joint.path in hanging:
            for end in joint.bodies:
                at.setdefault(end, []).append(joint)
    branches: dict[str, Branch] = {}
    used: set[str] = set()

    def spread(roots: Sequence[str | None]) -> None:
        queue = list(roots)
        for here in queue:
            for joint in at.get(here, ()):
                first, second = joint.bodies
                other = second if first == here else first
                if joint.path in used or other is None or other in branches or bodies[other].kinematic:
                    continue
                used.add(joint.path)
                parent_pose = np.eye(4) if here is None else branches[here].body.pose
                child = _snapped(bodies[other], parent_pose, joint, reverse := other == first, warn)
                branches[other] = Branch(child, here, joint, reverse)
                queue.append(other)

    kinematic = list(dict.fromkeys(placed))
    branches.update({path: Branch(bodies[path], None, None) for path in kinematic})
    spread([None])
    spread(kinematic)
    children = {joint.bodies[1] for joint in ties if joint.path in hanging}
    for path in sorted(bodies, key=lambda path: path in children):
        if path not in branches:
            branches[path] = Branch(bodies[path], None, None)
            spread([path])
    loops = tuple(joint for joint in ties if joint.path not in used)
    return Forest(_parents_first(branches, tuple(bodies)), loops)


def _spanning(joints: Sequence[Joint], fixed: frozenset[str]) -> frozenset[str]:
    """The joints that make the tree; the others close loops.

    Of the joints of a loop, one that only ties points or axes together is left to close it, because an engine's ties
    have no limits or drives. Joints that USD excludes from articulations come last in any case.
    """
    parent: dict[str | None, str | None] = dict.fromkeys(fixed)

    def find(path: str | None) -> str | None:
        while path in parent:
            path = parent[path]
        return path

    chosen = set()
    for joint in sorted(joints, key=lambda joint: (not _needs_axes(joint), not joint.in_tree)):
        if not joint.in_tree and not _needs_axes(joint):
            continue
        first, second = (find(body) for body in joint.bodies)
        if first == second:
            continue
        if first is None:
            first, second = second, first
        parent[first] = second
        chosen.add(joint.path)
    return frozenset(chosen)


def _needs_axes(joint: Joint) -> bool:
    """Whether a joint needs its own coordinates."""
    several = joint.kind == "prismatic" or (joint.kind == "d6" and joint.singles[0].kind == "prismatic")
    return several or any(
        single.limited
        or single.drive
        or single.friction
        or single.armature
        or single.damping
        or math.isfinite(single.max_speed)
        or single.initial_position is not None
        or single.initial_velocity is not None
        for single in joint.singles
    )


def _parents_first(branches: dict[str, Branch], order: tuple[str, ...]) -> tuple[Branch, ...]:
    """Depth first, siblings in stage order (the order in which MuJoCo numbers bodies)."""
    children: dict[str | None, list[str]] = {}
    for path in order:
        children.setdefault(branches[path].parent, []).append(path)
    out, todo = [], list(reversed(children.get(None, ())))
    while todo:
        path = todo.pop()
        out.append(branches[path])
        todo.extend(reversed(children.get(path, ())))
    return tuple(out)


def motion(joint: Joint, position: float) -> Floats:
    """(4, 4) of the joint's second frame in its first one, at a joint position (a D6's: where it starts)."""
    if joint.kind == "d6":
        return moved([motion(single, single.start) for single in joint.dofs])
    if joint.kind in ("prismatic", "revolute"):
        return step(joint.kind == "revolute", joint.axis, position)
    return np.eye(4)


def _snapped(child: Body, parent_pose: Floats, joint: Joint, reverse: bool, warn: Warn) -> Body:
    """The child's pose, given its parent's, at which the joint's frames meet."""
    if joint.kind == "spherical":
        apart_by = motion(joint, 0.0)
        first, second = joint.frames[::-1] if reverse else joint.frames
        turn = transforms.inverse_rigid(parent_pose @ first) @ child.pose @ second
        apart_by[:3, :3] = turn[:3, :3]
    else:
        apart_by = motion(joint, joint.start)
        first, second = joint.frames
        if reverse:
            apart_by, first, second = transforms.inverse_rigid(apart_by), second, first
    pose = parent_pose @ first @ apart_by @ transforms.inverse_rigid(second)
    apart = float(np.linalg.norm(pose[:3, 3] - child.pose[:3, 3]))
    turned = float(np.abs(pose[:3, :3] - child.pose[:3, :3]).max())
    if max(apart, turned) > SNAP:
        warn(
            "joint-frames-apart",
            joint.path,
            f"its two frames do not meet ({apart:.4g} m, {turned:.4g} rad); {child.path} starts where they do",
        )
    return replace(child, pose=pose) if max(apart, turned) > 1e-9 else child
