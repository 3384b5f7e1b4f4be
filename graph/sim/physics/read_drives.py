"""Drives of joints, and the joints' own inertia and friction, in SI units."""

from __future__ import annotations

import math
from typing import Any

from graph.sim.attributes import kilograms_per_unit, value_of
from graph.sim.scene.scan import JointPrim, Scan
from graph.sim.scene.stage import Warn
from graph.sim.usd import EARLIEST, UsdPhysics

from .world_model import Drive

STIFFEST = 1e30
"""Gains and targets above this are unusable for an engine: infinite, or PhysX's value for it, 3.4e38."""

_EFFORTS = {
    "armature": ("physxJointAxis:*:armature", "physxJoint:armature", "newton:armature", "mjc:armature"),
    "friction": (
        *("physxJointAxis:*:dynamicFrictionEffort", "physxJoint:jointFriction"),
        *("newton:friction", "mjc:frictionloss"),
    ),
    "damping": ("physxJointAxis:*:viscousFrictionCoefficient", "newton:damping", "mjc:damping"),
    "max_speed": ("physxJointAxis:*:maxJointVelocity", "physxJoint:maxJointVelocity", "newton:velocityLimit"),
}
"""Attributes of a joint's own effects; the first authored one counts; `*` stands for its axis."""


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
        text = f"{attribute.GetName()} is {value:g}, not {wanted}; 0 is taken"
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


def efforts_of(scan: Scan, prim: JointPrim, name: str, warn: Warn) -> dict[str, Any]:
    """The own effects of an axis ("angular", "linear", "rotX" ...), as PhysX, Newton and MuJoCo author them.

    The fields of `Joint`: armature, friction, damping, max_speed, initial_position and initial_velocity.
    """
    angular = name == "angular" or name.startswith("rot")
    length, mass = scan.meters_per_unit, kilograms_per_unit(scan.stage)
    effort = mass * length * (length if angular else 1.0)
    step = math.pi / 180 if angular else length
    units = {
        "armature": mass * (length**2 if angular else 1.0),
        "friction": effort,
        "damping": effort / step,
        "max_speed": step,
    }
    out = {}
    for key, names in _EFFORTS.items():
        for pattern in names:
            attribute = pattern.replace("*", name)
            value = value_of(prim.prim, attribute)
            if value is None:
                continue
            if math.isnan(value) or value < 0 or (math.isinf(value) and key != "max_speed"):
                text = f"{attribute} is {value:g}, not a number from 0; it counts as not written"
                warn("bad-joint", f"{prim.path}.{attribute}", text)
                continue
            if not value and key != "max_speed":  # PhysX's value for "not set"
                continue
            unit = units[key] if attribute != "mjc:damping" else effort if angular else effort / length
            out[key] = float(value) * unit
            break
    for key, what in (("initial_position", "position"), ("initial_velocity", "velocity")):
        attribute = f"state:{name}:physics:{what}"
        value = value_of(prim.prim, attribute)
        if value is not None and math.isfinite(value):
            out[key] = float(value) * step
        elif value is not None:
            text = f"{attribute} is {value:g}, not finite; the joint starts where its bodies are"
            warn("bad-joint", f"{prim.path}.{attribute}", text)
    return out
