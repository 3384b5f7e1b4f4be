"""Which prims are one articulation: links that joints connect, from a stage's joints and articulation roots."""

from __future__ import annotations

import weakref
from collections.abc import Collection, Iterable, Sequence
from functools import cached_property
from typing import Any, Literal

from graph.base.paths import at_or_below
from graph.base.records import dataclass
from graph.sim.attributes import first_target

JointKind = Literal["fixed", "revolute", "prismatic", "spherical", "d6", "distance"]

GIVEN = "mjc:name"
"""Attribute of a prim that mirrors a part of an MJCF model, with that part's name there. The model defines the physics
of these prims.
"""
ROOT_API = "PhysicsArticulationRootAPI"
BODY_API = "PhysicsRigidBodyAPI"
PRODUCTS = "/Render"
"""Graphs make render products below this prim while they run, which belong to no mechanism."""


@dataclass(frozen=True)
class Tie:
    """A joint and the links at its ends (None: the world, or what never moves); `joins`: it connects them."""

    path: str
    links: tuple[str | None, str | None]
    joins: bool = True


class Mechanisms:
    """All mechanisms of a stage: links that joints connect.

    A link is a rigid body, or a static prim to which a joint ties a link and that belongs to a robot: it is at or below
    an articulation root, or mirrors a body of an MJCF model. Distance joints, and joints that USD excludes from
    articulations, do not connect.
    """

    def __init__(self, ties: Sequence[Tie], roots: Sequence[str] = (), bodies: Sequence[str] = ()) -> None:
        """roots: prims with the root API, joints among them; bodies: those that move, jointed or not; stage order."""
        self.roots = tuple(roots)
        self._ties = {tie.path: tie for tie in ties}
        self._near: dict[str, list[str]] = {link: [] for link in bodies}
        self._grounded: dict[str, None] = {}
        for tie in ties:
            first, second = tie.links
            for link in filter(None, tie.links):
                if link not in self._near:
                    self._near[link], self._grounded[link] = [], None
            if first and second and tie.joins:
                self._near[first].append(second)
                self._near[second].append(first)
            elif tie.joins and (held := first or second):
                self._grounded[held] = None

    @cached_property
    def _groups(self) -> dict[str, tuple[str, ...]]:
        """Every link -> the links of its mechanism, in stage order."""
        number: dict[str, int] = {}
        members: list[list[str]] = []
        for link in self._near:
            if link not in number:
                number.update(dict.fromkeys(self._spread(link), len(members)))
                members.append([])
            members[number[link]].append(link)
        groups = [tuple(links) for links in members]
        return {link: groups[which] for link, which in number.items()}

    def _spread(self, start: str) -> dict[str, str]:
        """Each link of a mechanism and the link that carries it, from `start` outwards."""
        carriers, queue = {start: ""}, [start]
        for link in queue:
            fresh = [other for other in self._near[link] if other not in carriers]
            carriers.update(dict.fromkeys(fresh, link))
            queue += fresh
        return carriers

    def joins(self, links: Collection[str], bodies: Iterable[str | None]) -> bool:
        """Whether a joint between `bodies` (None: the world) is one of the mechanism with these links."""
        ends = [body for body in bodies if body in self._near]
        return bool(ends) and all(body in links for body in ends)

    def joints(self, links: Collection[str]) -> list[str]:
        """The joint prims of the mechanism with these links."""
        return [path for path, tie in self._ties.items() if self.joins(links, tie.links)]

    def carriers(self, path: str) -> dict[str, str]:
        """The links of the articulation of a prim, each with the link that carries it ("": none), root link first.

        path: of a root, a link or a prim in one, a joint (or `joint:axis`), or a prim above, which may stand for
        several articulations. Empty if there are no links.
        """
        path = path.partition(":")[0]
        out: dict[str, str] = {}
        for start in self._starts(path):
            if start not in out:
                out |= self._spread(self._root_link(self._groups[start]))
        return out

    def _starts(self, path: str) -> Iterable[str]:
        if path in self._ties:
            return [link for link in self._ties[path].links if link]
        if path in self._near:
            return [path]
        ties = [tie for tie in self._ties.values() if at_or_below(tie.path, path)]
        below = [link for link in self._near if at_or_below(link, path)]
        below += [link for tie in ties for link in tie.links if link]
        if below and path in self.roots:
            others = [root for root in self.roots if root != path and at_or_below(root, path)]
            taken = {link for root in others for link in self.carriers(root)}
            own = [link for link in below if link not in taken]
            return [link for link in own if self._near[link] or link in self._grounded] or own
        return below or sorted((link for link in self._near if at_or_below(path, link)), key=len)[-1:]

    def _root_link(self, group: Sequence[str]) -> str:
        """The link with the root API or at the joint with it, else one that is held to the world, else the first."""
        at_joints = (link for root in self.roots if root in self._ties for link in self._ties[root].links)
        for links in (self.roots, [*at_joints], self._grounded):
            if found := [link for link in group if link in links]:
                return found[0]
        return group[0]

    def standing_for(self, path: str) -> dict[str, str]:
        """As `carriers`, but only of prims that stand for a whole articulation; empty for others, such as a link.

        Those are articulation roots, joints, and prims above just one root.
        """
        if path in self._ties or path in self.roots:
            return self.carriers(path)
        below = [] if path in self._near else [root for root in self.roots if at_or_below(root, path)]
        return self.carriers(below[0]) if len(below) == 1 else {}


class _Found:
    """The mechanisms of one stage, until anything on it changes."""

    last: _Found | None = None

    def __init__(self, stage: Any) -> None:
        from graph.sim.usd import Tf, Usd

        self.stage = weakref.ref(stage)
        self.mechanisms = _read(stage)
        self._callback = self._forget  # USD holds it weakly
        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._callback, stage)

    def _forget(self, notice: Any, sender: Any) -> None:
        changed = (*notice.GetResyncedPaths(), *notice.GetChangedInfoOnlyPaths())
        if _Found.last is self and not all(at_or_below(str(path), PRODUCTS) for path in changed):
            _Found.last = None


def mechanisms_of(stage: Any) -> Mechanisms:
    """The mechanisms of a stage, instances included; read again only where the stage has changed."""
    found = _Found.last
    if found is None or found.stage() is not stage:
        found = _Found.last = _Found(stage)
    return found.mechanisms


def freedoms(stage: Any, path: str) -> list[str]:
    """The revolute and prismatic joints of the articulation at a path, in stage order."""
    from graph.sim.usd import UsdPhysics

    mechanisms = mechanisms_of(stage)
    joints = mechanisms.joints(mechanisms.carriers(path))
    kinds = UsdPhysics.RevoluteJoint, UsdPhysics.PrismaticJoint
    return [one for one in joints if any(stage.GetPrimAtPath(one).IsA(kind) for kind in kinds)]


def _read(stage: Any) -> Mechanisms:
    from graph.sim.usd import EARLIEST, Usd, UsdPhysics

    roots: list[str] = []
    bodies: list[str] = []
    joints: list[Any] = []
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdPhysics.Joint):
            joints.append(UsdPhysics.Joint(prim))
        applied = prim.GetAppliedSchemas()
        if ROOT_API in applied:
            roots.append(str(prim.GetPath()))
        if BODY_API in applied and UsdPhysics.RigidBodyAPI(prim).GetRigidBodyEnabledAttr().Get(EARLIEST):
            bodies.append(str(prim.GetPath()))
    moving = set(bodies)

    def link_of(path: str, other: str, rooted: bool) -> str | None:
        """The link at an end of a joint."""
        here = path
        while here:
            if here in moving:
                return here
            here = here.rpartition("/")[0]
        prim = stage.GetPrimAtPath(path) if path else None
        if not prim or at_or_below(other, path):
            return None
        belongs = rooted or prim.HasAttribute(GIVEN) or any(at_or_below(path, root) for root in roots)
        return path if belongs else None

    ties = []
    for joint in joints:
        path = str(joint.GetPath())
        if not joint.GetJointEnabledAttr().Get(EARLIEST):
            continue
        first, second = first_target(joint.GetBody0Rel()), first_target(joint.GetBody1Rel())
        links = link_of(first, second, False), link_of(second, first, path in roots)
        excluded = joint.GetExcludeFromArticulationAttr().Get(EARLIEST)
        joins = not excluded and not joint.GetPrim().IsA(UsdPhysics.DistanceJoint) and links[0] != links[1]
        ties.append(Tie(path, links, joins))
    return Mechanisms(ties, roots, bodies)
