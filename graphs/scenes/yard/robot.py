"""The yard robot: a chassis on two driven wheels, two trailing casters and a skid, with a mast for its lidars."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from .bodies import collide, cube, cylinder, hinge, rigid
from .mesh import Mesh, bind

WHEEL_RADIUS, WHEEL_DISTANCE = 0.15, 0.52
"""What the drive graph has to know [m]."""

MOTOR_TORQUE = 5.0
"""Most of each motor [N m]: 2.2 m/s2 for 30 kg, so that the wheels do not slip and the robot stays level."""
CASTER_RADIUS = 0.06
CASTER_TRAIL = 0.04
SKID_RADIUS, SKID_GAP = 0.06, 0.002
"""A ball below the nose, above the ground by the gap: it bears when the robot brakes or starts backwards."""
SWIVELS = {"Left": (-0.26, 0.17), "Right": (-0.26, -0.17)}


def build_robot(stage: Usd.Stage, root: str, looks: dict[str, str]) -> None:
    """Write the robot at `root`; its frame is on the ground below the axle, x forward. Its bodies are siblings."""
    robot = UsdGeom.Xform.Define(stage, root)
    robot.AddTranslateOp().Set(Gf.Vec3d(-7.0, -3.0, 0.0))
    robot.AddRotateZOp().Set(15.0)
    UsdPhysics.ArticulationRootAPI.Apply(robot.GetPrim())
    UsdGeom.Scope.Define(stage, f"{root}/Joints")

    chassis = rigid(stage, f"{root}/Chassis", (0, 0, WHEEL_RADIUS), mass=24.0)
    UsdPhysics.MassAPI(stage.GetPrimAtPath(chassis)).CreateCenterOfMassAttr(Gf.Vec3f(-0.06, 0, 0.04))
    UsdPhysics.MassAPI(stage.GetPrimAtPath(chassis)).CreateDiagonalInertiaAttr(Gf.Vec3f(0.5, 0.9, 1.1))
    collide(cube(stage, f"{chassis}/Hull", (0.66, 0.4, 0.18), (-0.06, 0, 0.1)), looks["plastic"])
    mast = cylinder(stage, f"{chassis}/Mast", 0.025, 0.5, "Z", (-0.1, 0, 0.44))
    bind(mast, looks["painted_steel"])
    _trim().define(stage, f"{chassis}/Trim", looks["painted_steel"])
    skid = UsdGeom.Sphere.Define(stage, f"{chassis}/Skid")
    skid.CreateRadiusAttr(SKID_RADIUS)
    skid.AddTranslateOp().Set(Gf.Vec3d(0.22, 0, SKID_RADIUS + SKID_GAP - WHEEL_RADIUS))
    collide(skid.GetPrim(), looks["plastic"])

    for side, y in (("left", WHEEL_DISTANCE / 2), ("right", -WHEEL_DISTANCE / 2)):
        wheel = rigid(stage, f"{root}/{side.title()}Wheel", (0, y, WHEEL_RADIUS), mass=2.0)
        collide(cylinder(stage, f"{wheel}/Tyre", WHEEL_RADIUS, 0.06, "Y"), looks["rubber"])
        _spokes(y).define(stage, f"{wheel}/Hub", looks["painted_steel"])
        hinge(
            stage,
            f"{root}/Joints/{side}_wheel",
            wheel,
            (0, y, 0),
            "Y",
            base=chassis,
            damping=2.0,
            force=MOTOR_TORQUE,
        )
    for side, (x, y) in SWIVELS.items():
        _caster(stage, root, chassis, side, x, y, looks)


def _caster(stage: Usd.Stage, root: str, chassis: str, side: str, x: float, y: float, looks: dict[str, str]) -> None:
    """A fork that turns about z below the chassis and a wheel that trails behind its swivel axis."""
    height = 2 * CASTER_RADIUS + 0.02
    fork = rigid(stage, f"{root}/{side}Fork", (x, y, height), mass=0.5)
    UsdPhysics.MassAPI(stage.GetPrimAtPath(fork)).CreateDiagonalInertiaAttr(Gf.Vec3f(0.001, 0.001, 0.001))
    plates = Mesh().add_box((0, 0, 0), (0.06, 0.06, 0.012))
    for offset in (-0.022, 0.022):
        plates.add_box((-CASTER_TRAIL / 2, offset, -0.04), (0.06, 0.005, 0.08))
    plates.define(stage, f"{fork}/Plates", looks["painted_steel"])
    hinge(
        stage,
        f"{root}/Joints/{side.lower()}_swivel",
        fork,
        (x, y, height - WHEEL_RADIUS),
        "Z",
        base=chassis,
        damping=0.0005,
    )

    wheel = rigid(stage, f"{root}/{side}Caster", (x - CASTER_TRAIL, y, CASTER_RADIUS), mass=0.5)
    collide(cylinder(stage, f"{wheel}/Tyre", CASTER_RADIUS, 0.03, "Y"), looks["rubber"])
    hinge(
        stage,
        f"{root}/Joints/{side.lower()}_caster",
        wheel,
        (-CASTER_TRAIL, 0, CASTER_RADIUS - height),
        "Y",
        base=fork,
    )


def _trim() -> Mesh:
    """Bumpers, deck plate and a handrail around the deck."""
    trim = Mesh().add_box((0.285, 0, 0.06), (0.03, 0.44, 0.06)).add_box((-0.405, 0, 0.06), (0.03, 0.44, 0.06))
    trim.add_box((-0.06, 0, 0.196), (0.6, 0.38, 0.012))
    corners = [(0.2, 0.17), (0.2, -0.17), (-0.34, -0.17), (-0.34, 0.17)]
    for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        trim.add_tube([(x0, y0, 0.2), (x0, y0, 0.34)], 0.01, sides=4)
        trim.add_tube([(x0, y0, 0.34), (x1, y1, 0.34)], 0.01, sides=4)
    return trim


def _spokes(y: float) -> Mesh:
    """A hub and five spokes on the outer face of the wheel at `y`."""
    face = 0.032 if y > 0 else -0.032
    hub = Mesh().add_tube([(0, face - 0.004, 0), (0, face + 0.004, 0)], 0.04, sides=16)
    for angle in 2 * np.pi * np.arange(5) / 5:
        reach = 0.13 * np.array([np.cos(angle), 0, np.sin(angle)])
        hub.add_tube([(0, face, 0), reach + (0, face, 0)], 0.012, sides=4)
    return hub
