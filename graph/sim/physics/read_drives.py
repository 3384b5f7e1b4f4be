"""Drives of joints, and the inertia and friction that joints have by themselves, in SI units."""

from __future__ import annotations

import math
from typing import Any

from graph.sim.scene.scan import JointPrim, Scan
from graph.sim.scene.stage import Warn
from graph.sim.usd import EARLIEST, UsdPhysics

from .attributes import kilograms_per_unit, value_of
from .model import Drive

STIFFEST = 1e30
"""Gains and targets above are not numbers that an engine can work with: infinite, or PhysX's word for it, 3.4e38."""

_ARMATURE = ("physxJoint:armature", "newton:armature", "mjc:armature")
_FRICTION = ("newton:friction", "mjc:frictionloss")


def drive_of(scan: Scan, prim: JointPrim, name: str, warn: Warn) -> Drive | None:
    """The drive of a name ("angular", "linear", "rotX" ...); angular ones are written per degree, others per unit."""
    if not prim.prim.HasAPI(UsdPhysics.DriveAPI, name):
        return None
    drive = UsdPhysics.DriveAPI(prim.prim, name)
    angular = name == "angular" or name.startswith("rot")
    unit = math.pi / 180 if angular else scan.meters_per_unit

    def number(attribute: Any, lowest: float = -math.inf, highest: float = STIFFEST) -> float:
        value = attribute.Get(EARLIEST)
        if value is None or (lowest <= value <= highest and abs(value) <= highest):
            return float(value or 0.0)
        wanted = f"a number from {lowest:g}" if lowest == 0 else "a finite number"
        text = f"{attribute.GetName()} is {value:g}, not {wanted}; 0 is taken."
        warn("bad-joint", f"{prim.path}.{attribute.GetName()}", text)
        return 0.0

    acceleration = drive.GetTypeAttr().Get(EARLIEST) == UsdPhysics.Tokens.acceleration
    # A force is mass * length / s2, a torque mass * length2 / s2, in units of the stage.
    length, mass = scan.meters_per_unit, kilograms_per_unit(scan.stage)
    effort_unit = mass * (length**2 if angular else length)
    if acceleration:
        effort_unit = 1.0 if angular else length
    gain_unit = effort_unit / unit
    return Drive(
        stiffness=number(drive.GetStiffnessAttr(), 0.0) * gain_unit,
        damping=number(drive.GetDampingAttr(), 0.0) * gain_unit,
        position=number(drive.GetTargetPositionAttr()) * unit,
        velocity=number(drive.GetTargetVelocityAttr()) * unit,
        max_force=abs(number(drive.GetMaxForceAttr(), highest=math.inf)) * effort_unit,
        acceleration=acceleration,
    )


def efforts_of(scan: Scan, prim: JointPrim, angular: bool, warn: Warn) -> dict[str, Any]:
    """armature and friction of a joint, as PhysxJointAPI, Newton and MuJoCo write them."""
    length, mass = scan.meters_per_unit, kilograms_per_unit(scan.stage)
    units = {
        "armature": mass * (length**2 if angular else 1.0),
        "friction": mass * length * (length if angular else 1.0),
    }
    out = {}
    for key, names in (("armature", _ARMATURE), ("friction", _FRICTION)):
        found = next(((name, value) for name in names if (value := value_of(prim.prim, name)) is not None), None)
        if found is None:
            continue
        if not math.isfinite(found[1]) or found[1] < 0:
            warn("bad-joint", prim.path, f"{found[0]} is {found[1]:g}, not a number from 0; 0 is taken.")
        else:
            out[key] = float(found[1]) * units[key]
    return out
