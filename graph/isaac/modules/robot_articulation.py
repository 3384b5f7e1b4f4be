"""The links and joints of a robot, in the order in which its joints connect them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from graph.sim.usd import Usd, UsdPhysics

__all__ = ["Articulation", "body_of", "targets", "walk"]
_ROBOT = "IsaacRobotAPI"


@dataclass(slots=True)
class Articulation:
    """What was found; a robot within the robot is one of its links and one of its joints."""

    root_link: Any
    root_joint: Any
    links: list[Any] = field(default_factory=list)
    joints: list[Any] = field(default_factory=list)


def targets(prim: Any, name: str) -> list[Any]:
    """The targets of a relationship; none if there is no prim or no relationship."""
    relation = prim.GetRelationship(name) if prim else None
    return list(relation.GetTargets()) if relation else []


def body_of(joint: Any, index: int) -> Any:
    """Path of body 0 or 1 of a joint; None without that body, or if the joint is excluded from the articulation."""
    excluded = joint.GetAttribute("physics:excludeFromArticulation") if joint and joint.IsA(UsdPhysics.Joint) else None
    if not excluded or excluded.Get():
        return None
    return next(iter(targets(joint, f"physics:body{index}")), None)


def walk(robot: Any, articulation: Any = None, depth_first: bool = True, root: Any = None) -> Articulation:
    """Follows the joints from the root link, or from `root`, without entering robots below this one.

    Without joints that connect, every joint and every rigid body below the robot counts.
    """
    nested = [one for one in Usd.PrimRange(robot) if one != robot and one.HasAPI(_ROBOT)]
    edges = list(_edges(robot, nested))
    start = next((one for one in Usd.PrimRange(articulation or robot) if _is_root(one)), robot)
    if _owner(start.GetPath(), nested):
        start = articulation or robot
    found = Articulation(*_root(robot, start, edges, nested))
    if root and (root.HasAPI(UsdPhysics.RigidBodyAPI) or any(root.GetPath() in ends for _, ends in edges)):
        found.root_link = root
    if found.root_link:
        _follow(found, edges, nested, depth_first)
    known = {*found.links}
    found.links += [one for one in nested if one not in known]
    found.joints += [one for one in nested if one not in known]
    if not found.joints:
        found.joints = [one for one in Usd.PrimRange(robot) if one.IsA(UsdPhysics.Joint)]
        known = {*found.links}
        bodies = (one for one in Usd.PrimRange(robot) if one.HasAPI(UsdPhysics.RigidBodyAPI))
        found.links += [one for one in bodies if one not in known]
    return found


def _is_root(prim: Any) -> bool:
    return bool(prim.HasAPI(UsdPhysics.ArticulationRootAPI))


def _owner(path: Any, nested: list[Any]) -> Any:
    """The innermost robot, of those below the robot, that holds a path."""
    holders = [one for one in nested if path.HasPrefix(one.GetPath())]
    return max(holders, key=lambda one: one.GetPath().pathElementCount, default=None)


def _edges(robot: Any, nested: list[Any]) -> Iterator[tuple[Any, list[Any]]]:
    """The joints of this robot itself, at least one body of which is its own, with the paths of both bodies."""
    for joint in Usd.PrimRange(robot):
        if joint.IsA(UsdPhysics.Joint):
            ends = [body_of(joint, 0), body_of(joint, 1)]
            if any(one is not None and _owner(one, nested) is None for one in ends):
                yield joint, ends


def _root(robot: Any, start: Any, edges: list[tuple[Any, list[Any]]], nested: list[Any]) -> tuple[Any, Any]:
    """The first link and the first joint.

    If the articulation's prim is not a body: the body that is most often the first of a joint and least often the
    second, and of equals the one nearest to the top of the stage.
    """
    if start.IsA(UsdPhysics.Joint):
        path = body_of(start, 0) or body_of(start, 1)
        return robot.GetStage().GetPrimAtPath(path) if path else None, start
    joint = next((joint for joint, ends in edges if start.GetPath() in ends), None)
    if start.HasAPI(UsdPhysics.RigidBodyAPI):
        return start, joint
    paths = dict.fromkeys(one for _, ends in edges for one in ends if one is not None and not _owner(one, nested))
    bodies = [one for one in map(robot.GetStage().GetPrimAtPath, paths) if one and one.HasAPI(UsdPhysics.RigidBodyAPI)]

    def rank(body: Any) -> tuple[int, int]:
        path = body.GetPath()
        score = sum((ends[0] == path) - (ends[1] == path) for _, ends in edges)
        return -score, path.pathElementCount

    return min(bodies, key=rank, default=start), joint


def _follow(found: Articulation, edges: list[tuple[Any, list[Any]]], nested: list[Any], depth_first: bool) -> None:
    stage = found.root_link.GetStage()
    joints: dict[Any, Any] = {found.root_joint.GetPath(): found.root_joint} if found.root_joint else {}
    links: dict[Any, Any] = {}
    seen = set()
    waiting = deque([found.root_link])
    while waiting:
        link = waiting.pop() if depth_first else waiting.popleft()
        path = link.GetPath()
        if path in seen:
            continue
        seen.add(path)
        if link.HasAPI(UsdPhysics.RigidBodyAPI):
            links[path] = link
        near = []
        for joint, ends in edges:
            if path not in ends:
                continue
            joints.setdefault(joint.GetPath(), joint)
            other = ends[1 - ends.index(path)]
            inner = _owner(other, nested) if other is not None else None
            if inner:
                links.setdefault(inner.GetPath(), inner)
                joints.setdefault(inner.GetPath(), inner)
            elif other is not None and (prim := stage.GetPrimAtPath(other)):
                near.append(prim)
        waiting.extend(reversed(near) if depth_first else near)
    found.links, found.joints = list(links.values()), list(joints.values())
