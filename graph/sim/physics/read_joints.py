"""UsdPhysics joints, their limits and drives."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.sim import transforms
from graph.sim.scan import JointPrim, Scan
from graph.sim.stage import Warn
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom, UsdPhysics

from .attributes import kilograms_per_unit, quaternion_of
from .model import FREE, Drive, Joint, JointKind

_KINDS: tuple[tuple[Any, JointKind], ...] = (
    (UsdPhysics.FixedJoint, "fixed"),
    (UsdPhysics.RevoluteJoint, "revolute"),
    (UsdPhysics.PrismaticJoint, "prismatic"),
    (UsdPhysics.SphericalJoint, "spherical"),
)


def read_joints(scan: Scan, warn: Warn) -> tuple[Joint, ...]:
    """Joints with at least one body that can move; the others have nothing to do."""
    return tuple(joint for prim in scan.joints if (joint := _joint(scan, prim, warn)))


def _joint(scan: Scan, prim: JointPrim, warn: Warn) -> Joint | None:
    first, second = (body if body in scan.moving else None for body in prim.bodies)
    if first is None and second is None:
        return None
    if first == second:
        warn("bad-joint", prim.path, f"the joint ties {first} to itself; it is left out.")
        return None
    kind = next((name for schema, name in _KINDS if prim.prim.IsA(schema)), None)
    if kind is None:
        warn(
            "joint-not-supported", prim.path, f"a {prim.prim.GetTypeName()} is not simulated; its bodies are not tied."
        )
        return None
    for target in prim.targets:
        if target is not None and not scan.stage.GetPrimAtPath(target):
            warn("bad-joint", prim.path, f"there is no prim {target}; that end of the joint is tied to the world.")
    frames = _frame(scan, prim, 0, first), _frame(scan, prim, 1, second)
    if not all(np.isfinite(frame).all() for frame in frames):
        warn("bad-joint", prim.path, "localPos or localRot is not finite; the joint is left out.")
        return None
    schema = UsdPhysics.Joint(prim.prim)
    common: dict[str, Any] = {
        "path": prim.path,
        "bodies": (first, second),
        "frames": frames,
        "collide": bool(schema.GetCollisionEnabledAttr().Get(EARLIEST)),
        "in_tree": not schema.GetExcludeFromArticulationAttr().Get(EARLIEST),
    }
    if kind not in ("revolute", "prismatic"):
        return Joint(kind=kind, **common)
    typed = UsdPhysics.RevoluteJoint(prim.prim) if kind == "revolute" else UsdPhysics.PrismaticJoint(prim.prim)
    unit = math.pi / 180 if kind == "revolute" else scan.meters_per_unit
    lower, upper = (_limit(attribute, unit) for attribute in (typed.GetLowerLimitAttr(), typed.GetUpperLimitAttr()))
    if lower > upper:
        warn("bad-joint", prim.path, f"its lower limit is above its upper one ({lower:g} > {upper:g}); it has none.")
        lower, upper = -FREE, FREE
    axis = "XYZ".find(str(typed.GetAxisAttr().Get(EARLIEST)))
    if axis < 0:
        warn("bad-joint", prim.path, f"physics:axis is {typed.GetAxisAttr().Get(EARLIEST)}, not X, Y or Z; X is taken.")
        axis = 0
    start = _start(scan, frames, (first, second), axis, kind)
    if kind == "revolute" and not lower <= start <= upper:
        start += next((turn for turn in (2 * math.pi, -2 * math.pi) if lower <= start + turn <= upper), 0.0)
    return Joint(
        kind=kind,
        axis=axis,
        lower=lower,
        upper=upper,
        start=start,
        drive=_drive(scan, prim, kind, unit, warn),
        **common,
    )


def _limit(attribute: Any, unit: float) -> float:
    value = float(attribute.Get(EARLIEST))
    return value * unit if math.isfinite(value) else (math.copysign(FREE, value) if not math.isnan(value) else 0.0)


def _frame(scan: Scan, prim: JointPrim, side: int, body: str | None) -> Floats:
    """The joint's frame on one side, in that body's rigid frame (or the world), metres."""
    schema = UsdPhysics.Joint(prim.prim)
    place = (schema.GetLocalPos0Attr, schema.GetLocalPos1Attr)[side]().Get(EARLIEST)
    turn = (schema.GetLocalRot0Attr, schema.GetLocalRot1Attr)[side]().Get(EARLIEST)
    target = scan.stage.GetPrimAtPath(prim.targets[side]) if prim.targets[side] else None
    base = scan.world_matrix(target) if target and target.IsA(UsdGeom.Xformable) else np.eye(4)
    frame = transforms.rigid_part(base)
    frame[:3, :3] = frame[:3, :3] @ transforms.rotation_matrices(quaternion_of(turn))
    frame[:3, 3] = transforms.transformed(base, np.array([place], dtype=np.float64))[0] * scan.meters_per_unit
    return frame if body is None else transforms.inverse_rigid(scan.body_pose(body)) @ frame


def _start(
    scan: Scan, frames: tuple[Floats, Floats], bodies: tuple[str | None, str | None], axis: int, kind: JointKind
) -> float:
    """The joint's position as the scene places its two bodies."""
    first, second = (
        frame if body is None else scan.body_pose(body) @ frame for frame, body in zip(frames, bodies, strict=True)
    )
    if kind == "prismatic":
        return float(first[:3, axis] @ (second[:3, 3] - first[:3, 3]))
    w, *vector = transforms.quaternion(first[:3, :3].T @ second[:3, :3])
    angle = 2 * math.atan2(float(vector[axis]), float(w))
    return math.remainder(angle, 2 * math.pi)


def _drive(scan: Scan, prim: JointPrim, kind: JointKind, unit: float, warn: Warn) -> Drive | None:
    """Angular drives are written per degree, linear ones per stage unit."""
    name = "angular" if kind == "revolute" else "linear"
    if not prim.prim.HasAPI(UsdPhysics.DriveAPI, name):
        return None
    drive = UsdPhysics.DriveAPI(prim.prim, name)

    def number(attribute: Any) -> float:
        value = attribute.Get(EARLIEST)
        if value is not None and math.isnan(value):
            warn("bad-joint", prim.path, f"{attribute.GetName()} is not a number; 0 is taken.")
        return 0.0 if value is None or math.isnan(value) else float(value)

    acceleration = drive.GetTypeAttr().Get(EARLIEST) == UsdPhysics.Tokens.acceleration
    # A force is mass * length / s2, a torque mass * length2 / s2, in units of the stage.
    length, mass = scan.meters_per_unit, kilograms_per_unit(scan.stage)
    effort_unit = mass * (length**2 if kind == "revolute" else length)
    if acceleration:
        effort_unit = 1.0 if kind == "revolute" else length
    gain_unit = effort_unit / unit
    return Drive(
        stiffness=number(drive.GetStiffnessAttr()) * gain_unit,
        damping=number(drive.GetDampingAttr()) * gain_unit,
        position=number(drive.GetTargetPositionAttr()) * unit,
        velocity=number(drive.GetTargetVelocityAttr()) * unit,
        max_force=abs(number(drive.GetMaxForceAttr())) * effort_unit,
        acceleration=acceleration,
    )
