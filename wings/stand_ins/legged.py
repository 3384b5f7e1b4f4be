"""Stand-ins for robots on four legs: a box, and legs of three joints with capsules that end in balls."""

from __future__ import annotations

import math
from typing import Any

from graph.base.records import dataclass
from graph.sim.usd import Gf, Sdf, UsdGeom, UsdPhysics

from .parts import Numbers, add_box, add_drive, frame_at, join, make_body

Range = tuple[float, float]
FOOT, LIMB = 0.02, 0.015
"""Radii of feet and limbs [m]."""


@dataclass(frozen=True, slots=True)
class Quadruped:
    """Names, sizes [m], masses [kg], limits [rad] and highest torques [N m] of one, from its maker's description.

    legs: names, front left, front right, rear left, rear right. links, joints: of the hip, thigh and calf of a leg,
    {} stands for its name. hip: where the front left one is in the trunk. out: from the hip to the thigh, sideways.
    lengths: of thigh and calf. masses: of trunk, hip, thigh, calf. ranges: of hip, front thigh, rear thigh, calf.
    """

    root: str
    trunk: str
    size: Numbers
    legs: tuple[str, ...]
    links: tuple[str, str, str]
    joints: tuple[str, str, str]
    hip: tuple[float, float]
    out: float
    lengths: tuple[float, float]
    masses: tuple[float, float, float, float]
    ranges: tuple[Range, Range, Range, Range]
    torques: tuple[float, float, float]
    stand: tuple[float, float, float]
    """Where the joints of a leg start [rad]."""
    gains: tuple[float, float]
    """Stiffness [N m/rad] and damping [N m s/rad] of the drives."""


_UNITREE = ("FL", "FR", "RL", "RR")
_LINKS, _JOINTS = ("{}_hip", "{}_thigh", "{}_calf"), ("{}_hip_joint", "{}_thigh_joint", "{}_calf_joint")
MODELS = {
    "a1": Quadruped(
        "a1", "trunk", (0.267, 0.194, 0.114), _UNITREE, _LINKS, _JOINTS, (0.183, 0.047), 0.08505, (0.2, 0.2),
        (4.713, 0.696, 1.013, 0.226),
        ((-0.802851, 0.802851), (-1.0472, 4.18879), (-1.0472, 4.18879), (-2.69653, -0.916298)),
        (33.5, 33.5, 33.5), (0.0, 0.8, -1.5), (85.0, 2.0),
    ),
    "go1": Quadruped(
        "go1", "trunk", (0.3762, 0.0935, 0.114), _UNITREE, _LINKS, _JOINTS, (0.1881, 0.04675), 0.08, (0.213, 0.213),
        (5.204, 0.591, 0.92, 0.196), ((-0.863, 0.863), (-0.686, 4.501), (-0.686, 4.501), (-2.818, -0.888)),
        (23.7, 23.7, 35.55), (0.0, 0.8, -1.5), (40.0, 1.0),
    ),
    "go2": Quadruped(
        "go2", "base", (0.3762, 0.0935, 0.114), _UNITREE, _LINKS, _JOINTS, (0.1934, 0.0465), 0.0955, (0.213, 0.213),
        (6.921, 0.678, 1.152, 0.194), ((-1.0472, 1.0472), (-1.5708, 3.4907), (-0.5236, 4.5379), (-2.7227, -0.83776)),
        (23.7, 23.7, 45.43), (0.0, 0.8, -1.5), (40.0, 1.0),
    ),
    "spot": Quadruped(
        "spot", "body", (0.85, 0.24, 0.19), ("fl", "fr", "hl", "hr"), ("{}_hip", "{}_uleg", "{}_lleg"),
        ("{}_hx", "{}_hy", "{}_kn"), (0.29785, 0.055), 0.110945, (0.3205, 0.37), (16.7, 1.68, 2.34, 0.35),
        ((-0.785398, 0.785398), (-0.898845, 2.295108), (-0.898845, 2.295108), (-2.7929, -0.254801)),
        (45.0, 45.0, 115.0), (0.0, 0.9, -1.5), (300.0, 6.0),
    ),
}  # fmt: skip


def quadruped(name: str, stage: Any) -> Any:
    """Makes one; returns its root, at the centre of its trunk."""
    one = MODELS[name]
    root = UsdGeom.Xform.Define(stage, f"/{one.root}").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    trunk = f"/{one.root}/{one.trunk}"
    make_body(UsdGeom.Xform.Define(stage, trunk).GetPrim(), one.masses[0])
    add_box(stage, f"{trunk}/shape", one.size, (0, 0, 0))
    for link in one.links:  # joints are numbered as their links stand here: all hips first, as in Isaac Sim
        for leg in one.legs:
            UsdGeom.Xform.Define(stage, f"/{one.root}/{link.format(leg)}")
    for number, leg in enumerate(one.legs):
        _leg(stage, one, leg, front=number < 2, side=1 if number % 2 == 0 else -1)
    return root


def _leg(stage: Any, one: Quadruped, leg: str, *, front: bool, side: int) -> None:
    root, above = f"/{one.root}", f"/{one.root}/{one.trunk}"
    steps: tuple[Numbers, ...] = (
        (one.hip[0] if front else -one.hip[0], side * one.hip[1], 0),
        (0, side * one.out, 0),
        (0, 0, -one.lengths[0]),
    )
    ranges = (one.ranges[0], one.ranges[1 if front else 2], one.ranges[3])
    pose = Gf.Matrix4d(1.0)
    for part, (at, axis, limits, angle) in enumerate(zip(steps, "XYY", ranges, one.stand, strict=True)):
        here = frame_at(at, (0, 0, 1), 0.0)
        turn = frame_at((0, 0, 0), (axis == "X", axis == "Y", 0), math.degrees(angle))
        pose = turn * here * pose
        path = f"{root}/{one.links[part].format(leg)}"
        link = UsdGeom.Xform.Define(stage, path)
        link.AddTranslateOp().Set(pose.ExtractTranslation())
        link.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(pose.ExtractRotationQuat())
        make_body(link.GetPrim(), one.masses[part + 1], [one.masses[part + 1] * 0.005] * 3)
        if part:
            _limb(stage, path, one.lengths[part - 1], foot=part == 2)
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"{above}/{one.joints[part].format(leg)}")
        join(joint, above, path, here)
        joint.CreateAxisAttr(axis)
        joint.CreateLowerLimitAttr(math.degrees(limits[0]))
        joint.CreateUpperLimitAttr(math.degrees(limits[1]))
        gains = [math.radians(gain) for gain in one.gains]  # USD's are for degrees
        add_drive(joint, "angular", gains[0], gains[1], one.torques[part], math.degrees(angle))
        above = path


def _limb(stage: Any, link: str, length: float, *, foot: bool) -> None:
    """A capsule from the link's origin down its -z axis; the last one is solid at its foot alone."""
    capsule = UsdGeom.Capsule.Define(stage, f"{link}/shape")
    capsule.CreateAxisAttr("Z")
    capsule.CreateRadiusAttr(LIMB)
    capsule.CreateHeightAttr(length - 2 * LIMB)
    capsule.AddTranslateOp().Set(Gf.Vec3d(0, 0, -length / 2))
    if foot:
        ball = UsdGeom.Sphere.Define(stage, f"{link}/foot")
        ball.CreateRadiusAttr(FOOT)
        ball.AddTranslateOp().Set(Gf.Vec3d(0, 0, -length))
        UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
