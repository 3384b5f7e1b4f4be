"""UsdPhysics joints with their limits and drives, joints that mimic others, and the joints that locked axes of bodies
make.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graph.sim import transforms
from graph.sim.attributes import applied_schemas, first_target, quaternion_of, value_of
from graph.sim.scene.physics_settings import AXES
from graph.sim.scene.prim_paths import NAME_OVERRIDE, near_prim
from graph.sim.scene.scan import JOINT_KINDS, JointPrim, Scan
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom, UsdPhysics

from .authored_settings import StoredSettings
from .d6_joints import Axis, single_joints
from .read_drives import drive_of, efforts_of
from .world_model import FREE, Body, Joint, Mimic

NEVER_BREAKS = 3e38
"""A break force from here on means unbreakable: USD uses infinity for it, PhysX the largest float32, 3.4e38."""

_NAMED = frozenset(f"Physics{schema.__name__}" for schema, _ in JOINT_KINDS)


def read_joints(scan: Scan, warn: Warn, known: Mapping[str, Joint]) -> tuple[Joint, ...]:
    """Joints with at least one body that can move; the others have no effect. `known` joints are not read again."""
    found = (known.get(prim.path) or _joint(scan, prim, warn) for prim in scan.joints)
    out = tuple(joint for joint in found if joint)
    _say_friction(scan, out, warn)
    return out


def _say_friction(scan: Scan, joints: Sequence[Joint], warn: Warn) -> None:
    """PhysX's coefficient has no unit: it multiplies the load of the joint."""
    name, paths = "physxJoint:jointFriction", {joint.path for joint in joints}
    loaded = [prim.path for prim in scan.joints if prim.path in paths and value_of(prim.prim, name)]
    if loaded:
        others = f" ({len(loaded)} joints)" if len(loaded) > 1 else ""
        warn(
            "joint-friction-effort",
            f"{loaded[0]}.{name}",
            f"it is taken as dry friction in N or N m, whatever the joint carries{others}; PhysX multiplies it by the "
            "joint's load. Write newton:friction to mean an effort",
        )


def _joint(scan: Scan, prim: JointPrim, warn: Warn) -> Joint | None:
    first, second = (body if body in scan.moving else None for body in prim.bodies)
    if first is None and second is None:
        return None
    if first == second:
        warn("bad-joint", prim.path, f"the joint ties {first} to itself; it is left out")
        return None
    name = str(prim.prim.GetTypeName())
    if name not in _NAMED:
        warn("joint-not-supported", prim.path, f"a {name} is not simulated; its bodies are not tied")
        return None
    kind = next(kind for schema, kind in JOINT_KINDS if prim.prim.IsA(schema))
    for target in prim.targets:
        if target is not None and not scan.stage.GetPrimAtPath(target):
            near = near_prim(scan.stage, target)
            warn("bad-joint", prim.path, f"there is no prim {target}; that end is tied to the world{near}")
    schema = UsdPhysics.Joint(prim.prim)
    frames = (
        joint_frame(scan, schema, 0, prim.targets[0], first),
        joint_frame(scan, schema, 1, prim.targets[1], second),
    )
    if not all(np.isfinite(frame).all() for frame in frames):
        warn("bad-joint", prim.path, "localPos or localRot is not finite; the joint is left out")
        return None
    for attribute in (schema.GetLocalRot0Attr(), schema.GetLocalRot1Attr()):
        if not attribute.Get(EARLIEST).GetLength():
            name = attribute.GetName()
            warn("bad-joint", f"{prim.path}.{name}", f"{name} has the length 0; it counts as no turn")
    _say_unbreakable(schema, prim.path, warn)
    joint = Joint(
        path=prim.path,
        kind=kind,
        bodies=(first, second),
        frames=frames,
        collide=bool(schema.GetCollisionEnabledAttr().Get(EARLIEST)),
        label=str(value_of(prim.prim, NAME_OVERRIDE) or ""),
        in_tree=not schema.GetExcludeFromArticulationAttr().Get(EARLIEST),
    )
    if kind in ("revolute", "prismatic"):
        return _single(scan, prim, joint, warn)
    if kind == "spherical":
        return _spherical(scan, prim, joint, warn)
    if kind == "distance":
        return _distance(scan, prim, joint, warn)
    return _d6(scan, prim, joint, warn) if kind == "d6" else joint


def _say_unbreakable(schema: Any, path: str, warn: Warn) -> None:
    named = (("breakForce", schema.GetBreakForceAttr()), ("breakTorque", schema.GetBreakTorqueAttr()))
    finite = [name for name, attribute in named if attribute.Get(EARLIEST) < NEVER_BREAKS]
    if finite:
        are = "are" if len(finite) > 1 else "is"
        warn("break-force", path, f"{' and '.join(finite)} {are} not simulated: the joint never breaks")


def _single(scan: Scan, prim: JointPrim, joint: Joint, warn: Warn) -> Joint:
    angular = joint.kind == "revolute"
    typed = UsdPhysics.RevoluteJoint(prim.prim) if angular else UsdPhysics.PrismaticJoint(prim.prim)
    unit = math.pi / 180 if angular else scan.meters_per_unit
    lower = _limit(typed.GetLowerLimitAttr(), unit, -FREE, prim.path, warn)
    upper = _limit(typed.GetUpperLimitAttr(), unit, FREE, prim.path, warn)
    if lower > upper:
        warn(
            "bad-joint",
            prim.path,
            f"its lower limit is above its upper one ({lower:g} > {upper:g}); neither is applied",
        )
        lower, upper = -FREE, FREE
    axis = _axis(typed.GetAxisAttr(), prim.path, warn)
    start = _start(scan, joint, axis)
    if angular and not lower <= start <= upper:
        start += next((turn for turn in (2 * math.pi, -2 * math.pi) if lower <= start + turn <= upper), 0.0)
    return replace(
        joint,
        axis=axis,
        lower=lower,
        upper=upper,
        start=start,
        drive=drive_of(scan, prim, "angular" if angular else "linear", warn),
        **efforts_of(scan, prim, "angular" if angular else "linear", warn),
    )


def _axis(attribute: Any, path: str, warn: Warn) -> int:
    name = str(attribute.Get(EARLIEST))
    axis = "XYZ".find(name) if len(name) == 1 else -1
    if axis < 0:
        warn("bad-joint", path, f"physics:axis is {name}, not X, Y or Z; X is taken")
    return max(axis, 0)


def _spherical(scan: Scan, prim: JointPrim, joint: Joint, warn: Warn) -> Joint:
    """Free, or within a cone about its axis; a cone with two different angles is approximated by three axes."""
    typed = UsdPhysics.SphericalJoint(prim.prim)
    axis = _axis(typed.GetAxisAttr(), prim.path, warn)
    limits = typed.GetConeAngle0LimitAttr(), typed.GetConeAngle1LimitAttr()
    cones = [_limit(each, math.radians(1), FREE, prim.path, warn) for each in limits]
    wide = [angle if 0 <= angle < math.pi else FREE for angle in cones]
    if wide == [FREE, FREE] or wide[0] == wide[1]:
        return replace(joint, axis=axis, cone=wide[0])
    around = [(axis + 1) % 3, (axis + 2) % 3]
    axes = [Axis(3 + axis)]
    axes += [Axis(3 + a, -angle, angle) for a, angle in zip(around, wide, strict=True)]
    order = (3 + around[1], 3 + around[0], 3 + axis)
    return replace(joint, kind="d6", dofs=single_joints(scan, joint, axes, order))


def _distance(scan: Scan, prim: JointPrim, joint: Joint, warn: Warn) -> Joint | None:
    typed = UsdPhysics.DistanceJoint(prim.prim)
    unit = scan.meters_per_unit
    low = _limit(typed.GetMinDistanceAttr(), unit, FREE, prim.path, warn)
    high = _limit(typed.GetMaxDistanceAttr(), unit, FREE, prim.path, warn)
    lower, upper = low if 0 < low < FREE else 0.0, high if high >= 0 else FREE
    if lower > upper:
        text = f"its minDistance is above its maxDistance ({low / unit:g} > {high / unit:g}); it is left out"
        warn("bad-joint", prim.path, text)
        return None
    return replace(joint, lower=lower, upper=upper, collide=joint.collide)


def _d6(scan: Scan, prim: JointPrim, joint: Joint, warn: Warn) -> Joint:
    """Every axis is free unless a LimitAPI of its name limits it, or locks it by a lower limit above the upper one."""
    axes = []
    for number, name in enumerate(AXES):
        unit = math.pi / 180 if number >= 3 else scan.meters_per_unit
        lower, upper = -FREE, FREE
        if prim.prim.HasAPI(UsdPhysics.LimitAPI, name):
            limit = UsdPhysics.LimitAPI(prim.prim, name)
            lower = _limit(limit.GetLowAttr(), unit, -FREE, prim.path, warn)
            upper = _limit(limit.GetHighAttr(), unit, FREE, prim.path, warn)
            if lower >= upper:
                continue
        drive = drive_of(scan, prim, name, warn)
        axes.append(Axis(number, lower, upper, drive, efforts_of(scan, prim, name, warn)))
    if prim.prim.HasAPI(UsdPhysics.LimitAPI, "distance"):
        warn("joint-not-supported", prim.path, "its limit of the distance has no effect; use a PhysicsDistanceJoint")
    if not axes:
        return replace(joint, kind="fixed")
    turning = [axis for axis in axes if axis.number >= 3]
    if len(axes) == 3 == len(turning) and not any(axis.drive or axis.limited for axis in axes):
        return replace(joint, kind="spherical")
    return replace(joint, dofs=single_joints(scan, joint, axes))


def _limit(attribute: Any, unit: float, free: float, path: str, warn: Warn) -> float:
    """A limit [m or rad]; `free` if it is not finite."""
    value = float(attribute.Get(EARLIEST))
    if math.isnan(value):
        name = attribute.GetName()
        warn("bad-joint", f"{path}.{name}", f"{name} is nan, not a number; it counts as no limit")
        return free
    return value * unit if math.isfinite(value) else math.copysign(FREE, value)


def joint_frame(scan: Scan, schema: Any, side: int, link: str | None, body: str | None) -> Floats:
    """The joint's frame on one side, where it names the prim `link`, in a body's rigid frame (or the world), metres."""
    place = (schema.GetLocalPos0Attr, schema.GetLocalPos1Attr)[side]().Get(EARLIEST)
    turn = (schema.GetLocalRot0Attr, schema.GetLocalRot1Attr)[side]().Get(EARLIEST)
    target = scan.stage.GetPrimAtPath(link) if link else None
    base = scan.world_matrix(target) if target and target.IsA(UsdGeom.Xformable) else np.eye(4)
    frame = transforms.rigid_part(base)
    frame[:3, :3] = frame[:3, :3] @ transforms.rotation_matrices(quaternion_of(turn))
    frame[:3, 3] = transforms.transformed(base, np.array([place], dtype=np.float64))[0] * scan.meters_per_unit
    return frame if body is None else transforms.inverse_rigid(scan.body_pose(body)) @ frame


def _start(scan: Scan, joint: Joint, axis: int) -> float:
    """The joint's position for the poses of its two bodies in the scene."""
    first, second = (
        frame if body is None else scan.body_pose(body) @ frame
        for frame, body in zip(joint.frames, joint.bodies, strict=True)
    )
    if joint.kind == "prismatic":
        return float(first[:3, axis] @ (second[:3, 3] - first[:3, 3]))
    w, *vector = transforms.quaternion(first[:3, :3].T @ second[:3, :3])
    angle = 2 * math.atan2(float(vector[axis]), float(w))
    return math.remainder(angle, 2 * math.pi)


def read_mimics(scan: Scan, joints: tuple[Joint, ...], warn: Warn) -> tuple[Mimic, ...]:
    """Joints that NewtonMimicAPI or PhysxMimicJointAPI couple to other joints."""
    singles = {single.path: single for joint in joints for single in joint.singles if single.kind != "spherical"}
    out = []
    for prim in scan.joints:
        if (found := _mimic_of(prim, warn)) is None:
            continue
        axis, target, leader_axis, offset, ratio = found
        paths = [_dof_path(singles, prim.path, axis), _dof_path(singles, target, leader_axis)]
        if None in paths or paths[0] == paths[1]:
            warn("bad-mimic", prim.path, f"it cannot follow {target or 'nothing'}; both must be joints of one axis")
            continue
        units = [math.pi / 180 if singles[str(path)].kind == "revolute" else scan.meters_per_unit for path in paths]
        out.append(Mimic(str(paths[0]), str(paths[1]), offset * units[0], ratio * units[0] / units[1]))
    return tuple(out)


def _dof_path(singles: dict[str, Joint], path: str, axis: str) -> str | None:
    return path if path in singles else f"{path}:{axis}" if f"{path}:{axis}" in singles else None


def _mimic_of(prim: JointPrim, warn: Warn) -> tuple[str, str, str, float, float] | None:
    """Axis, leader, its axis, offset and ratio, in the units of the joints (degrees, stage units)."""
    schemas = applied_schemas(prim.prim)

    def number(name: str, default: float) -> float:
        value = value_of(prim.prim, name)
        if value is None or math.isfinite(value):
            return default if value is None else float(value)
        warn("bad-joint", f"{prim.path}.{name}", f"{name} is {value:g}, not finite; {default:g} is taken")
        return default

    if "NewtonMimicAPI" in schemas:
        if value_of(prim.prim, "newton:mimicEnabled") is False:
            return None
        leader = first_target(prim.prim.GetRelationship("newton:mimicJoint"))
        return "", leader, "", number("newton:mimicCoef0", 0.0), number("newton:mimicCoef1", 1.0)
    for axis in AXES:
        if f"PhysxMimicJointAPI:{axis}" in schemas:
            name = f"physxMimicJoint:{axis}"
            other = value_of(prim.prim, f"{name}:referenceJointAxis")
            leader = first_target(prim.prim.GetRelationship(f"{name}:referenceJoint"))
            return axis, leader, str(other or "rotX"), -number(f"{name}:offset", 0.0), -number(f"{name}:gearing", 1.0)
    return None


SUFFIX = "#locked"
"""Suffix of a body's path that gives the path of the joint for its locks."""

POSITION, ROTATION = "physxRigidBody:lockedPosAxis", "physxRigidBody:lockedRotAxis"


def read_locks(scan: Scan, bodies: tuple[Body, ...], joints: tuple[Joint, ...], stored: StoredSettings) -> list[Joint]:
    """The joints of bodies with locked axes; what cannot be had is noted in `stored`.

    A locked body keeps its origin, not its centre of mass, on the axes that stay: they differ only where it may turn.
    """
    tied = {path for joint in joints for path in joint.bodies if path}
    out = []
    for body in bodies:
        prim = scan.bodies[body.path].prim
        place, turn = (int(value_of(prim, name) or 0) & 7 for name in (POSITION, ROTATION))
        if not place and not turn:
            continue
        why = ""
        if body.kinematic:
            why = "a kinematic body follows its transforms; write others"
        elif body.path in tied:
            why = "a joint holds this body; lock axes by the limits of its joints"
        if why:
            for name, mask in ((POSITION, place), (ROTATION, turn)):
                if mask:
                    stored.add(body.path, name, why)
            continue
        if turn in (1, 2, 4):
            stored.add(body.path, ROTATION, "one axis of rotation cannot be locked alone; lock two, or all three")
            turn = 0
        if place or turn:
            out.append(_locked(scan, body, place, turn))
    return out


def _locked(scan: Scan, body: Body, place: int, turn: int) -> Joint:
    """Slides along the world's axes that are free, then a turn about the free one, or about all.

    The frames depend only on what the locks keep, so that a joint made later measures the same positions.
    """
    free_turns = [axis for axis in range(3) if not turn >> axis & 1]
    frame = np.eye(4)
    rotation = body.pose[:3, :3]
    frame[:3, :3] = _onto(free_turns[0], rotation.T[:, free_turns[0]]) if len(free_turns) == 1 else rotation.T
    base = np.eye(4)
    base[:3, 3] = [body.pose[axis, 3] if place >> axis & 1 else 0.0 for axis in range(3)]
    whole = Joint(f"{body.path}{SUFFIX}", "d6", (None, body.path), (base, frame), collide=True)
    axes = [Axis(axis) for axis in range(3) if not place >> axis & 1]
    axes += [Axis(3 + free_turns[0])] if len(free_turns) == 1 else []
    dofs = single_joints(scan, whole, axes)
    if len(free_turns) == 3:
        ball = transforms.rigid(np.eye(3), body.pose[:3, 3])
        dofs += (Joint(f"{whole.path}:rot", "spherical", whole.bodies, (ball, frame), collide=True),)
    if not dofs:
        return Joint(whole.path, "fixed", whole.bodies, (body.pose @ frame, frame), collide=True)
    return Joint(whole.path, "d6", whole.bodies, whole.frames, collide=True, dofs=dofs)


def _onto(axis: int, direction: Floats) -> Floats:
    """(3, 3): the least rotation that takes an axis to a unit direction."""
    start = np.eye(3)[axis]
    half = start + direction
    length = float(np.linalg.norm(half))
    if length < 1e-9:  # opposite: half a turn about another axis
        out = -np.eye(3)
        out[(axis + 1) % 3, (axis + 1) % 3] = 1.0
        return out
    half /= length
    quaternion = np.concatenate([[float(start @ half)], np.cross(start, half)])
    return transforms.rotation_matrices(quaternion)
