"""Surface grippers (suction cups), by Isaac Sim's robot schema."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.attributes import first_target, kilograms_per_unit
from graph.sim.scene.scan import ATTACHMENTS, Scan
from graph.sim.scene.stage import Warn
from graph.sim.usd import EARLIEST, UsdPhysics

from .read_joints import joint_frame
from .world_model import FREE, Gripper, Suction

REACH = 0.01
"""Default of isaac:maxGripDistance [stage units]."""


def read_grippers(scan: Scan, warn: Warn) -> tuple[Gripper, ...]:
    """The grippers of a stage with attachment points on bodies that can move."""
    return tuple(_gripper(scan, prim, warn) for prim in scan.grippers)


def _gripper(scan: Scan, prim: Any, warn: Warn) -> Gripper:
    path = str(prim.GetPath())
    points = []
    attached = prim.GetRelationship(ATTACHMENTS)
    for target in attached.GetForwardedTargets() if attached else ():
        joint = scan.stage.GetPrimAtPath(target.GetPrimPath())
        point = _point(scan, joint) if joint and joint.IsA(UsdPhysics.Joint) else None
        if point is None:
            warn("bad-gripper", path, f"{target} is not a joint whose first body can move; it holds nothing")
        elif not np.isfinite([*point.place, *point.direction]).all():
            warn("bad-gripper", path, f"localPos0 or localRot0 of {target} is not finite; it holds nothing")
        else:
            points.append(point)
    newton = kilograms_per_unit(scan.stage) * scan.meters_per_unit
    return Gripper(
        path,
        tuple(points),
        reach=_number(prim, "isaac:maxGripDistance", REACH) * scan.meters_per_unit,
        coaxial_limit=_limit(prim, "isaac:coaxialForceLimit") * newton,
        shear_limit=_limit(prim, "isaac:shearForceLimit") * newton,
        patience=max(_number(prim, "isaac:retryInterval", 0.0), 0.0),
    )


def _point(scan: Scan, prim: Any) -> Suction | None:
    joint = UsdPhysics.Joint(prim)
    link = first_target(joint.GetBody0Rel())
    body = scan.moving_body_of(link)
    if body is None:
        return None
    local = joint_frame(scan, joint, 0, link, body)
    attribute = prim.GetAttribute("isaac:forwardAxis")
    axis = str((attribute.Get(EARLIEST) if attribute else None) or "Z").upper()
    direction = local[:3, "XYZ".index(axis) if axis in ("X", "Y", "Z") else 2]
    clearance = _number(prim, "isaac:clearanceOffset", 0.0) * scan.meters_per_unit
    return Suction(str(prim.GetPath()), body, local[:3, 3], direction, clearance)


def _number(prim: Any, name: str, default: float) -> float:
    attribute = prim.GetAttribute(name)
    value = attribute.Get(EARLIEST) if attribute else None
    return default if value is None or not np.isfinite(value) else float(value)


def _limit(prim: Any, name: str) -> float:
    """A force; an unauthored value, or one not above 0, means no limit."""
    value = _number(prim, name, 0.0)
    return value if value > 0 else FREE
