"""One traversal of a stage: which prims are bodies, joints and colliders, and what can move."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from graph.base.limits import check
from graph.base.records import dataclass, field
from graph.sim import transforms
from graph.sim.attributes import first_target
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, Tf, Usd, UsdGeom, UsdPhysics

from .mechanisms import GIVEN, JointKind, Mechanisms, mechanisms_of
from .stage_metadata import meters_per_unit

SOFT_TYPES = ("Mesh", "TetMesh", "Points")
SOFT = frozenset(
    {
        "PhysxDeformableSurfaceAPI",
        "PhysxParticleClothAPI",
        "OmniPhysicsSurfaceDeformableSimAPI",
        "PhysxDeformableBodyAPI",
        "OmniPhysicsVolumeDeformableSimAPI",
        "PhysxParticleSetAPI",
    }
)
"""Types of prims that deform if one of these schemas is applied."""

SOFT_ATTACHMENTS = ("PhysxPhysicsAttachment", "OmniPhysicsVtxXformAttachment")
"""Types of prims that attach deformables."""

JOINT_KINDS: tuple[tuple[Any, JointKind], ...] = (
    (UsdPhysics.FixedJoint, "fixed"),
    (UsdPhysics.RevoluteJoint, "revolute"),
    (UsdPhysics.PrismaticJoint, "prismatic"),
    (UsdPhysics.SphericalJoint, "spherical"),
    (UsdPhysics.DistanceJoint, "distance"),
    (UsdPhysics.Joint, "d6"),
)
"""The schemas of joints, each before those from which it derives, and the kinds of joints in words."""

GRIPPER, ATTACHMENTS = "IsaacSurfaceGripper", "isaac:attachmentPoints"
"""Type of a surface gripper's prim, and its relationship to the joints that are its attachment points."""


@dataclass(frozen=True)
class BodyPrim:
    """A prim with an enabled rigid body; a kinematic one is moved by the user, not by forces."""

    path: str
    prim: Any
    kinematic: bool
    given: str = ""
    """Its name in the MJCF model that the prim mirrors."""


@dataclass(frozen=True)
class JointPrim:
    """An enabled joint: the prims that it names (None: the world) and their bodies (None: cannot move)."""

    path: str
    prim: Any
    targets: tuple[str | None, str | None]
    bodies: tuple[str | None, str | None]


@dataclass
class Scan:
    """The prims of a stage that matter for physics and rays, in stage order."""

    stage: Any
    meters_per_unit: float
    bodies: dict[str, BodyPrim] = field(default_factory=dict)
    colliders: dict[str, Any] = field(default_factory=dict)
    """Prims with colliders by path."""
    joints: list[JointPrim] = field(default_factory=list)
    scenes: list[Any] = field(default_factory=list)
    articulation_roots: list[str] = field(default_factory=list)
    grippers: list[Any] = field(default_factory=list)
    soft: list[Any] = field(default_factory=list)
    """Prims that deform: cloth, soft bodies, particles."""
    moving: frozenset[str] = frozenset()
    """Bodies whose pose can change: all except those that fixed joints hold to the world."""
    promoted: Mapping[str, bool] = field(default_factory=dict)
    """Static prims that users move while playing, treated as kinematic bodies; whether their descendants move with
    them.
    """
    placed: Mapping[str, Floats] = field(default_factory=dict)
    """Rigid poses [m] of bodies that replace the stage's, for them and everything that they carry."""
    driven: list[str] = field(default_factory=list)
    """Kinematic bodies whose transform, or an ancestor's, has time samples; all animated prims count as kinematic."""
    riders: dict[str, BodyPrim] = field(default_factory=dict)
    """Animated prims below a body that forces move: part of that body for physics, separate for rays."""
    animated: set[str] = field(default_factory=set)
    """Prims whose own transform has time samples."""
    resets: set[str] = field(default_factory=set)
    """Prims whose transform ignores their parent (`resetXformStack`): no body above carries them."""

    def __post_init__(self) -> None:
        self._xforms = UsdGeom.XformCache(EARLIEST)
        self._shifts: dict[str, Floats] = {}

    def world_matrix(self, prim: Any) -> Floats:
        """(4, 4) prim to world, stage units, scale included."""
        world = transforms.from_usd(self._xforms.GetLocalToWorldTransform(prim))
        if self.placed:
            body = self.body_of(str(prim.GetPath()))
            if body is not None and body in self.placed:
                world = self._shift(body) @ world
        return world

    def _shift(self, body: str) -> Floats:
        """From the stage's pose of a body to its placed pose, stage units."""
        if body not in self._shifts:
            there = self.placed[body].copy()
            there[:3, 3] /= self.meters_per_unit
            world = transforms.from_usd(self._xforms.GetLocalToWorldTransform(self.bodies[body].prim))
            self._shifts[body] = there @ transforms.inverse_rigid(transforms.rigid_part(world))
        return self._shifts[body]

    def body_pose(self, path: str) -> Floats:
        """(4, 4) rigid pose of a body in the world, metres."""
        if path in self.placed:
            return np.array(self.placed[path])
        body = self.riders[path] if path in self.riders else self.bodies[path]
        pose = transforms.rigid_part(self.world_matrix(body.prim))
        pose[:3, 3] *= self.meters_per_unit
        return pose

    def body_of(self, path: str) -> str | None:
        """The nearest body at or above a prim path."""
        here = path
        while here and here != "/":
            if here in self.bodies and (here == path or self.promoted.get(here, True)):
                return here
            if here in self.resets:
                return None
            here = here.rpartition("/")[0]
        return None

    def carrier_of(self, path: str) -> str | None:
        """What a prim moves with, for rays: the nearest moving body or animated prim at or above it."""
        body = self.moving_body_of(path)
        if not self.riders:
            return body
        here = path
        while here and here != body and here not in self.resets:
            if here in self.riders:
                return here
            here = here.rpartition("/")[0]
        return here if here in self.riders else body

    def moving_body_of(self, path: str) -> str | None:
        """The nearest body at or above a prim path, if it can move."""
        body = self.body_of(path)
        return body if body in self.moving else None

    @cached_property
    def mechanisms(self) -> Mechanisms:
        """The articulations of the stage."""
        jointed = self.joints or any(body.given for body in self.bodies.values())
        return mechanisms_of(self.stage) if jointed else Mechanisms((), self.articulation_roots, [*self.bodies])

    @property
    def dynamic(self) -> list[str]:
        """Bodies that forces can move."""
        return [path for path in self.bodies if path in self.moving and not self.bodies[path].kinematic]


def scan_stage(
    stage: Any, promoted: Mapping[str, bool] | None = None, placed: Mapping[str, Floats] | None = None
) -> Scan:
    """Walk the stage once, into instances too. Inactive, abstract and unloaded prims are passed over.

    Raises OverLimit beyond the limit physics.parts.
    """
    scan = Scan(stage, meters_per_unit(stage), promoted=promoted or {}, placed=placed or {})
    joints: list[Any] = []
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        name = str(prim.GetTypeName())
        kind = _kind(name)
        if kind == "joint":
            if not prim.HasAttribute(GIVEN):
                joints.append(prim)
            if prim.HasAPI(UsdPhysics.ArticulationRootAPI):
                scan.articulation_roots.append(str(prim.GetPath()))
            continue
        if kind == "scene":
            scan.scenes.append(prim)
            continue
        if name == GRIPPER:
            scan.grippers.append(prim)
            continue
        if name in SOFT_TYPES and not SOFT.isdisjoint(prim.GetPrimTypeInfo().GetAppliedAPISchemas()):
            scan.soft.append(prim)
            continue
        varies = kind == "placed" and _transform_varies(scan, prim)
        if promoted and (path := str(prim.GetPath())) in promoted:
            scan.bodies[path] = BodyPrim(path, prim, kinematic=True)
        if not prim.GetAppliedSchemas():
            if varies:
                _add_animated(scan, prim)
            continue
        if prim.HasAPI(UsdPhysics.RigidBodyAPI):
            body = UsdPhysics.RigidBodyAPI(prim)
            if body.GetRigidBodyEnabledAttr().Get(EARLIEST):
                path = str(prim.GetPath())
                given = prim.GetAttribute(GIVEN).Get() if prim.HasAttribute(GIVEN) else ""
                scan.bodies[path] = BodyPrim(path, prim, bool(body.GetKinematicEnabledAttr().Get(EARLIEST)), given)
        collision = UsdPhysics.CollisionAPI(prim) if prim.HasAPI(UsdPhysics.CollisionAPI) else None
        if collision and collision.GetCollisionEnabledAttr().Get(EARLIEST):
            scan.colliders[str(prim.GetPath())] = prim
        if prim.HasAPI(UsdPhysics.ArticulationRootAPI):
            scan.articulation_roots.append(str(prim.GetPath()))
        if varies:
            _add_animated(scan, prim)
    scan.driven = _driven(scan)
    held = _attachments(scan)
    scan.joints = [joint for prim in joints if str(prim.GetPath()) not in held and (joint := _joint(scan, prim))]
    scan.moving = _moving(scan)
    parts = len(scan.bodies) + len(scan.joints)
    check("physics.parts", parts, f"the stage has {parts:,} bodies and joints")
    return scan


def _transform_varies(scan: Scan, prim: Any) -> bool:
    """Whether a prim's own transform has several time samples; also records transforms that ignore the parent."""
    if not prim.HasAttribute("xformOpOrder"):
        return False
    xform = UsdGeom.Xformable(prim)
    if xform.GetResetXformStack():
        scan.resets.add(str(prim.GetPath()))
    return bool(xform.TransformMightBeTimeVarying())


@lru_cache(maxsize=1024)
def _kind(name: str) -> str:
    """The kind of a prim type: joint, scene, placed (it may have its own transform) or none of these."""
    kind = Usd.SchemaRegistry.GetTypeFromName(name)
    for word, base in (("joint", UsdPhysics.Joint), ("scene", UsdPhysics.Scene), ("placed", UsdGeom.Xformable)):
        if kind and kind.IsA(Tf.Type(base)):
            return word
    return ""


def _add_animated(scan: Scan, prim: Any) -> None:
    """Adds an animated prim: a kinematic body, unless forces move it or a body above it."""
    path = str(prim.GetPath())
    scan.animated.add(path)
    if path in scan.bodies:
        return
    above = scan.body_of(path)
    if above is not None and not scan.bodies[above].kinematic:
        scan.riders[path] = BodyPrim(path, prim, kinematic=True)
    else:
        scan.bodies[path] = BodyPrim(path, prim, kinematic=True)


def _driven(scan: Scan) -> list[str]:
    """Kinematic bodies with time samples on themselves or an ancestor."""
    if not scan.animated:
        return []
    found = []
    for path, body in scan.bodies.items():
        here = path
        while body.kinematic and here:
            if here in scan.animated:
                found.append(path)
                break
            here = "" if here in scan.resets else here.rpartition("/")[0]
    return found


def _attachments(scan: Scan) -> frozenset[str]:
    """Joints that are attachment points of grippers: they mark places and do not connect bodies."""
    relationships = [prim.GetRelationship(ATTACHMENTS) for prim in scan.grippers]
    return frozenset(str(path) for each in relationships if each for path in each.GetForwardedTargets())


def _joint(scan: Scan, prim: Any) -> JointPrim | None:
    joint = UsdPhysics.Joint(prim)
    if not joint.GetJointEnabledAttr().Get(EARLIEST):
        return None
    first, second = first_target(joint.GetBody0Rel()), first_target(joint.GetBody1Rel())
    bodies = scan.body_of(first), scan.body_of(second)
    return JointPrim(str(prim.GetPath()), prim, (first or None, second or None), bodies)


def _moving(scan: Scan) -> frozenset[str]:
    """All bodies except those that a chain of fixed joints holds to the world."""
    tied: dict[str | None, set[str | None]] = {}
    for joint in scan.joints:
        if joint.prim.IsA(UsdPhysics.FixedJoint):
            first, second = joint.bodies
            tied.setdefault(first, set()).add(second)
            tied.setdefault(second, set()).add(first)
    held: set[str | None] = {None}
    todo: list[str | None] = [None]
    while todo:
        for other in tied.get(todo.pop(), ()):
            if other not in held and not scan.bodies[str(other)].kinematic:
                held.add(other)
                todo.append(other)
    return frozenset(path for path, body in scan.bodies.items() if path not in held or body.given)
