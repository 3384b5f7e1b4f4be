"""`usd.schema.isaac.robot_schema.utils`: links, joints, sites and poses of robots, read from and written to prims."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from graph.sim.usd import Gf, Sdf, Usd, UsdGeom, UsdPhysics, Vt

from .carb import log_warn
from .robot_articulation import Articulation, body_of, targets, walk
from .robot_schema import ApplyJointAPI, ApplyLinkAPI, ApplySiteAPI, Attributes, Classes, DofOffsetOpOrder, Relations

__all__ = [
    "AddSitesToRobotLinks",
    "DetectAndApplySites",
    "EnsurePrependListForRobotRelationships",
    "GenerateRobotLinkTree",
    "GetAllNamedPoses",
    "GetAllRobotComponents",
    "GetAllRobotJoints",
    "GetAllRobotLinks",
    "GetJointBodyRelationship",
    "GetJointPose",
    "GetLinksFromJoint",
    "GetNamedPoseEndLink",
    "GetNamedPoseJointFixed",
    "GetNamedPoseJointValues",
    "GetNamedPoseJoints",
    "GetNamedPoseStartLink",
    "GetNamedPoseValid",
    "PopulateRobotSchemaFromArticulation",
    "PrintRobotTree",
    "RebuildRelationshipAsPrepend",
    "RecalculateRobotSchema",
    "RobotLinkNode",
    "UpdateDeprecatedJointDofOrder",
    "UpdateDeprecatedSchemas",
    "ValidateRobotSchemaRelationships",
]


class RobotLinkNode:
    """A link in the tree of a robot."""

    def __init__(self, prim: Any, parentLink: RobotLinkNode | None = None, joint: Any = None) -> None:
        self.prim = prim
        self.path = prim.GetPath() if prim else None
        self.name = prim.GetName() if prim else ""
        self.children: list[RobotLinkNode] = []
        self.parent = parentLink
        self.joint_to_parent = joint

    def add_child(self, child: RobotLinkNode) -> None:
        child.parent = self
        self.children.append(child)

    def links(self) -> list[Any]:
        """The prims of this link and of all behind it, branch after branch."""
        return [self.prim, *(link for child in self.children for link in child.links())]


def GetJointBodyRelationship(joint_prim: Any, bodyIndex: int) -> Any:
    """Path of body 0 or 1 of a joint; None without that body, or if the joint is excluded from the articulation."""
    return body_of(joint_prim, bodyIndex)


def PopulateRobotSchemaFromArticulation(
    stage: Any,
    robot_prim: Any,
    articulation_prim: Any = None,
    *,
    detect_sites: bool = False,
    sites_last: bool = False,
    traversal: str = "dfs",
) -> tuple[Any, Any]:
    """Marks the links and joints of an articulation and lists them on the robot; gives the first of each.

    A robot below this one is listed whole, where a joint reaches it. Raises ValueError for an invalid stage, prim or
    order.
    """
    found = _marked(stage, robot_prim, articulation_prim, traversal)
    sites = _mark_sites(found.links) if detect_sites else {}
    _write(robot_prim, Relations.ROBOT_LINKS, _with_sites([one.GetPath() for one in found.links], sites, sites_last))
    _write(robot_prim, Relations.ROBOT_JOINTS, [one.GetPath() for one in found.joints])
    return found.root_link, found.root_joint


def RecalculateRobotSchema(
    stage: Any,
    robot_prim: Any,
    articulation_prim: Any = None,
    *,
    detect_sites: bool = False,
    sites_last: bool = False,
    force_update: bool = False,
    traversal: str = "dfs",
) -> tuple[Any, Any]:
    """Adds new links and joints behind those listed, and drops those that left; `force_update` lists all again."""
    if force_update or not stage or not robot_prim:
        return PopulateRobotSchemaFromArticulation(
            *(stage, robot_prim, articulation_prim),
            detect_sites=detect_sites,
            sites_last=sites_last,
            traversal=traversal,
        )
    links, joints = (targets(robot_prim, one.name) for one in (Relations.ROBOT_LINKS, Relations.ROBOT_JOINTS))
    found = _marked(stage, robot_prim, articulation_prim, traversal, stage.GetPrimAtPath(links[0]) if links else None)
    if detect_sites:
        _mark_sites(found.links)
    sites = [one.GetPath() for one in Usd.PrimRange(robot_prim) if _is_site(one)]
    present = {one.GetPath() for one in found.links} | set(sites)
    new_sites = sites if detect_sites else []
    kept = [one for one in links if one in present]
    _write(robot_prim, Relations.ROBOT_LINKS, [*kept, *(one.GetPath() for one in found.links), *new_sites])
    present = {one.GetPath() for one in found.joints}
    first = [found.root_joint.GetPath()] if found.root_joint and found.root_joint.GetPath() not in joints else []
    kept = [one for one in joints if one in present]
    _write(robot_prim, Relations.ROBOT_JOINTS, [*first, *kept, *(one.GetPath() for one in found.joints)])
    return found.root_link, found.root_joint


def GetAllRobotJoints(stage: Any, robot_link_prim: Any, parse_nested_robots: bool = True) -> list[Any]:
    """The joints that the robot lists, then those of its articulation that it does not list, with a warning."""
    listed = _listed(stage, robot_link_prim, Relations.ROBOT_JOINTS, (Classes.JOINT_API,), parse_nested_robots)
    return _with_unlisted(stage, robot_link_prim, listed, "joints")


def GetAllRobotLinks(stage: Any, robot_link_prim: Any, include_reference_points: bool = False) -> list[Any]:
    """The links that the robot lists, then those of its articulation that it does not list, with a warning."""
    sites = (Classes.SITE_API, Classes.REFERENCE_POINT_API) if include_reference_points else ()
    listed = _listed(stage, robot_link_prim, Relations.ROBOT_LINKS, (Classes.LINK_API, *sites), True)
    return _with_unlisted(stage, robot_link_prim, listed, "links")


def GetAllRobotComponents(stage: Any, robot_prim: Any) -> list[Any]:
    """Every robot, link, joint and site at and below a prim."""
    wanted = [
        *(Classes.ROBOT_API, Classes.LINK_API, Classes.JOINT_API),
        *(Classes.SITE_API, Classes.REFERENCE_POINT_API),
    ]
    if not stage or not robot_prim:
        return []
    return [prim for prim in Usd.PrimRange(robot_prim) if any(prim.HasAPI(one.value) for one in wanted)]


def GetAllNamedPoses(stage: Any, robot_prim: Any) -> list[Any]:
    """The prims of the poses that a robot lists."""
    if not stage or not robot_prim:
        return []
    prims = [stage.GetPrimAtPath(one) for one in targets(robot_prim, Relations.NAMED_POSES.name)]
    return [one for one in prims if one and one.GetTypeName() == Classes.NAMED_POSE.value]


def GetNamedPoseStartLink(named_pose_prim: Any) -> Any:
    return next(iter(targets(named_pose_prim, Relations.POSE_START_LINK.name)), None)


def GetNamedPoseEndLink(named_pose_prim: Any) -> Any:
    return next(iter(targets(named_pose_prim, Relations.POSE_END_LINK.name)), None)


def GetNamedPoseJoints(named_pose_prim: Any) -> list[Any]:
    return targets(named_pose_prim, Relations.POSE_JOINTS.name)


def GetNamedPoseJointValues(named_pose_prim: Any) -> list[float] | None:
    return _list_of(named_pose_prim, Attributes.POSE_JOINT_VALUES)


def GetNamedPoseJointFixed(named_pose_prim: Any) -> list[bool] | None:
    return _list_of(named_pose_prim, Attributes.POSE_JOINT_FIXED)


def GetNamedPoseValid(named_pose_prim: Any) -> bool | None:
    value = _authored(named_pose_prim, Attributes.POSE_VALID)
    return None if value is None else bool(value)


def GetJointPose(robot_prim: Any, joint_prim: Any) -> Any:
    """The joint's frame in that of the robot, from its first body that exists; None without bodies."""
    joint = UsdPhysics.Joint(joint_prim)
    frames = ((0, "physics:localPos0", "physics:localRot0"), (1, "physics:localPos1", "physics:localRot1"))
    for index, position, rotation in frames if joint else ():
        path = body_of(joint_prim, index)
        body = joint_prim.GetStage().GetPrimAtPath(path) if path else None
        at, turn = joint_prim.GetAttribute(position).Get(), joint_prim.GetAttribute(rotation).Get()
        if body and at is not None and turn is not None:
            frame = Gf.Matrix4d().SetTransform(Gf.Rotation(Gf.Quatd(turn)), Gf.Vec3d(at))
            return frame * _to_world(body) * _to_world(robot_prim).GetInverse()
    return None


def GenerateRobotLinkTree(stage: Any, robot_link_prim: Any = None) -> RobotLinkNode | None:
    """The tree of a robot's links, those of robots below it too; None without links."""
    links = GetAllRobotLinks(stage, robot_link_prim) if stage and robot_link_prim else []
    if not links:
        return None
    left = GetAllRobotJoints(stage, robot_link_prim)
    root = RobotLinkNode(links[0])
    waiting = [root]
    reached = {root.path}
    for node in waiting:
        for joint in left:
            ends = [body_of(joint, 0), body_of(joint, 1)]
            if node.path not in ends:
                continue
            path = ends[1 - ends.index(node.path)]
            prim = stage.GetPrimAtPath(path) if path else None
            if prim and path not in reached:
                reached.add(path)
                node.add_child(RobotLinkNode(prim, node, joint))
        waiting += node.children
    return root


def GetLinksFromJoint(root: RobotLinkNode, joint_prim: Any) -> tuple[list[Any], list[Any]]:
    """The links before a joint, nearest first, and those behind it."""
    waiting = [root]
    behind = None
    for node in waiting:
        if node.joint_to_parent == joint_prim:
            behind = node
            break
        waiting += node.children
    if behind is None:
        return [], []
    before, node = [], behind
    while node.parent is not None:
        others = (one for one in node.parent.children if one is not node)
        before += [node.parent.prim, *(link for one in others for link in one.links())]
        node = node.parent
    return before, behind.links()


def PrintRobotTree(root: RobotLinkNode, indent: int = 0) -> None:
    print(" " * indent + root.name)
    for child in root.children:
        PrintRobotTree(child, indent + 2)


def DetectAndApplySites(
    stage: Any, robot_prim: Any, *, sites_last: bool = False
) -> tuple[list[Any], dict[str, list[Any]]]:
    """Marks the empty Xforms below links as sites; gives them, and them by the path of their link."""
    if not stage or not robot_prim:
        return [], {}
    links = [one for one in Usd.PrimRange(robot_prim) if one.HasAPI(Classes.LINK_API.value)]
    by_link = {str(path): sites for path, sites in _mark_sites(links).items()}
    return [site for sites in by_link.values() for site in sites], by_link


def AddSitesToRobotLinks(
    robot_prim: Any,
    sites: list[Any] | None = None,
    sites_by_parent: dict[str, list[Any]] | None = None,
    *,
    sites_last: bool = False,
) -> None:
    """Lists sites among the links of a robot: behind all, or each behind its link."""
    if not robot_prim or not robot_prim.HasAPI(Classes.ROBOT_API.value):
        return
    links = targets(robot_prim, Relations.ROBOT_LINKS.name)
    by_link = {Sdf.Path(path): [one for one in some if _is_site(one)] for path, some in (sites_by_parent or {}).items()}
    if sites_last:
        links += [one.GetPath() for one in sites or [] if _is_site(one)]
    else:
        links = _with_sites(links, by_link, False)
    _write(robot_prim, Relations.ROBOT_LINKS, links)


def ValidateRobotSchemaRelationships(robot_prim: Any) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
    """Listed links that exist, those that do not, and the same of joints."""
    found: list[list[Any]] = []
    for relation in (Relations.ROBOT_LINKS, Relations.ROBOT_JOINTS):
        paths = targets(robot_prim, relation.name)
        present = {one for one in paths if robot_prim.GetStage().GetPrimAtPath(one)}
        found += [[one for one in paths if one in present], [one for one in paths if one not in present]]
    return found[0], found[1], found[2], found[3]


def RebuildRelationshipAsPrepend(prim: Any, rel_name: str, targets: list[Any]) -> None:
    """Writes the targets as prepended ones, so that stronger layers add to them."""
    if not prim:
        return
    relation = prim.GetRelationship(rel_name) or prim.CreateRelationship(rel_name, custom=True)
    relation.ClearTargets(False)
    for target in dict.fromkeys(targets):
        relation.AddTarget(target, Usd.ListPositionBackOfPrependList)


def EnsurePrependListForRobotRelationships(robot_prim: Any) -> None:
    for relation in (Relations.ROBOT_LINKS, Relations.ROBOT_JOINTS):
        if paths := targets(robot_prim, relation.name):
            _write(robot_prim, relation, paths)


_OLD_OFFSETS = {
    f"isaac:physics:{axis}:DoFOffset": token.value
    for axis, token in zip(("Tr_X", "Tr_Y", "Tr_Z", "Rot_X", "Rot_Y", "Rot_Z"), DofOffsetOpOrder, strict=True)
}


def UpdateDeprecatedJointDofOrder(joint_prim: Any) -> bool:
    """Replaces the old offsets, one an axis, by their order; says whether there were any.

    A joint with one axis needs no order. Tokens that were there before stay, those without an old offset last.
    """
    if not joint_prim or not joint_prim.IsA(UsdPhysics.Joint):
        return False
    old = {name: joint_prim.GetAttribute(name) for name in _OLD_OFFSETS}
    old = {name: one for name, one in old.items() if one and one.HasAuthoredValue()}
    if not old:
        return False
    place = {_OLD_OFFSETS[name]: int(one.Get()) for name, one in old.items()}
    for name in old:
        joint_prim.RemoveProperty(name)
    if any(joint_prim.IsA(one) for one in (UsdPhysics.RevoluteJoint, UsdPhysics.PrismaticJoint, UsdPhysics.FixedJoint)):
        return True
    present = _authored(joint_prim, Attributes.DOF_OFFSET_OP_ORDER)
    # Sorting keeps the order of equal ones: that of the axes, or that of the tokens there were.
    order = sorted(present or place, key=lambda one: place.get(one, len(_OLD_OFFSETS) + max(place.values())))
    made = joint_prim.CreateAttribute(Attributes.DOF_OFFSET_OP_ORDER.name, Attributes.DOF_OFFSET_OP_ORDER.type, False)
    made.Set(Vt.TokenArray(order))
    return True


def UpdateDeprecatedSchemas(robot_prim: Any) -> None:
    """Makes reference points sites, and gives joints the order of their offsets."""
    for prim in Usd.PrimRange(robot_prim) if robot_prim else ():
        if prim.HasAPI(Classes.REFERENCE_POINT_API.value):
            prim.RemoveAppliedSchema(Classes.REFERENCE_POINT_API.value)
            ApplySiteAPI(prim)
        if prim.HasAPI(Classes.JOINT_API.value):
            UpdateDeprecatedJointDofOrder(prim)


def _marked(stage: Any, robot: Any, articulation: Any, traversal: str, root: Any = None) -> Articulation:
    """The articulation below a robot, its links and joints marked."""
    if not stage or not robot:
        raise ValueError(f"the {'robot prim' if stage else 'stage'} is not valid")
    if str(traversal).lower() not in ("dfs", "bfs"):
        raise ValueError(f'traversal is "dfs" or "bfs", not {traversal!r}')
    found = walk(robot, articulation, str(traversal).lower() == "dfs", root)
    for prims, apply in ((found.links, ApplyLinkAPI), (found.joints, ApplyJointAPI)):
        for prim in prims:
            if prim == robot or not prim.HasAPI(Classes.ROBOT_API.value):
                apply(prim)
    return found


def _mark_sites(links: Iterable[Any]) -> dict[Any, list[Any]]:
    """The new sites below links, by the path of the link; each is marked."""
    taken = (Classes.SITE_API.value, Classes.REFERENCE_POINT_API.value, UsdPhysics.RigidBodyAPI)
    found: dict[Any, list[Any]] = {}
    for link in links:
        for child in link.GetChildren():
            if child.IsA(UsdGeom.Xform) and not child.GetChildren() and not any(child.HasAPI(one) for one in taken):
                ApplySiteAPI(child)
                found.setdefault(link.GetPath(), []).append(child)
    return found


def _is_site(prim: Any) -> bool:
    return any(prim.HasAPI(one.value) for one in (Classes.SITE_API, Classes.REFERENCE_POINT_API))


def _with_sites(links: list[Any], sites: dict[Any, list[Any]], last: bool) -> list[Any]:
    """The paths of links, each followed by those of its sites, or all sites last."""
    behind = [[one.GetPath() for one in sites.get(link, [])] for link in links]
    if last:
        return [*links, *(one for some in behind for one in some)]
    return [one for link, some in zip(links, behind, strict=True) for one in (link, *some)]


def _write(robot: Any, relation: Relations, paths: list[Any]) -> None:
    RebuildRelationshipAsPrepend(robot, relation.name, paths)


def _listed(stage: Any, prim: Any, relation: Relations, kinds: tuple[Classes, ...], nested: bool) -> list[Any]:
    """What a robot lists of some kinds, and what the robots in its list do, each robot once."""
    if not stage or not prim:
        return []
    if any(prim.HasAPI(one.value) for one in kinds) and not prim.HasAPI(Classes.ROBOT_API.value):
        return [prim]
    found: dict[Any, Any] = {}
    waiting = [prim]
    for robot in waiting:
        for child in map(stage.GetPrimAtPath, targets(robot, relation.name)):
            if not child:
                continue
            if any(child.HasAPI(one.value) for one in kinds):
                found[child.GetPath()] = child
            elif nested and child.HasAPI(Classes.ROBOT_API.value) and child not in waiting:
                waiting.append(child)
    return list(found.values())


def _with_unlisted(stage: Any, robot: Any, listed: list[Any], what: str) -> list[Any]:
    if not stage or not robot:
        return listed
    known = {one.GetPath() for one in listed}
    nested = Classes.ROBOT_API.value
    articulation = walk(robot)
    found = articulation.links if what == "links" else articulation.joints
    missing = [one for one in found if one.GetPath() not in known and (one == robot or not one.HasAPI(nested))]
    if missing:
        paths = ", ".join(str(one.GetPath()) for one in missing)
        log_warn(f"{robot.GetPath()} does not list these {what}: {paths}; call RecalculateRobotSchema")
    return [*listed, *missing]


def _authored(prim: Any, attribute: Attributes) -> Any:
    found = prim.GetAttribute(attribute.name) if prim else None
    return found.Get() if found and found.HasAuthoredValue() else None


def _list_of(prim: Any, attribute: Attributes) -> list[Any] | None:
    value = _authored(prim, attribute)
    return None if value is None else list(value)


def _to_world(prim: Any) -> Any:
    return UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
