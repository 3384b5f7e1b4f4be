"""What moves by itself: crates, barrels, balls, bottles, cones, pallets, and four parts on joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from .mesh import Mesh, bind
from .props import PANEL, add_pallet

Vector = tuple[float, float, float]
CRATE, BALL = 0.6, 0.18
"""Edge of a crate, radius of a ball [m]."""


def build_bodies(stage: Usd.Stage, root: str, looks: dict[str, str]) -> None:
    """Write every free body below `root`."""
    for index, (position, turn) in enumerate(_crates()):
        crate = rigid(stage, f"{root}/Crate_{index:02d}", position, mass=14.0, turn_deg=turn)
        collide(cube(stage, f"{crate}/Box", (CRATE, CRATE, CRATE)), looks["wood"])
    for index, (x, y) in enumerate(((-3.0, 3.6), (-2.3, 3.6), (-2.65, 4.25), (-3.4, 4.3))):
        barrel = rigid(stage, f"{root}/Barrel_{index:02d}", (x, y, 0.441), mass=18.0)
        collide(cylinder(stage, f"{barrel}/Drum", 0.29, 0.88, "Z"), looks["painted_steel"])
    rolling = rigid(
        stage,
        f"{root}/Barrel_04",
        (-1.0, 0.5, 0.29),
        mass=18.0,
        velocity=(1.45, 0, 0),
        spin_deg=(0, 286.5, 0),
    )
    collide(cylinder(stage, f"{rolling}/Drum", 0.29, 0.88, "Y"), looks["painted_steel"])
    for index, (position, velocity) in enumerate(_balls()):
        spin = (-np.degrees(velocity[1] / BALL), np.degrees(velocity[0] / BALL), 0.0)
        ball = rigid(stage, f"{root}/Ball_{index:02d}", position, mass=1.2, velocity=velocity, spin_deg=spin)
        sphere = UsdGeom.Sphere.Define(stage, f"{ball}/Skin")
        sphere.CreateRadiusAttr(BALL)
        collide(sphere.GetPrim(), looks["rubber"])
    for index, (x, y, push) in enumerate(((2.0, -6.5, 0.9), (2.6, -6.5, 1.6))):
        bottle = rigid(stage, f"{root}/Bottle_{index:02d}", (x, y, 0.561), mass=9.0, velocity=(0, push, 0))
        capsule = UsdGeom.Capsule.Define(stage, f"{bottle}/Shell")
        capsule.CreateAxisAttr(UsdGeom.Tokens.z)
        capsule.CreateRadiusAttr(0.11)
        capsule.CreateHeightAttr(0.9)
        collide(capsule.GetPrim(), looks["painted_steel"])
    for index, (x, y) in enumerate(((-3.0, -5.6), (-1.5, -0.6), (1.2, -5.4))):
        cone = rigid(stage, f"{root}/Cone_{index:02d}", (x, y, 0.0), mass=2.0)
        hull_mesh(_cone(), stage, f"{cone}/Cone", looks["plastic"])
    for index, z in enumerate((0.35, 0.75)):
        pallet = rigid(stage, f"{root}/Pallet_{index:02d}", (-4.5, 6.5, z), mass=20.0, turn_deg=12.0 * index)
        boards = Mesh()
        add_pallet(boards, (0, 0, 0))
        hull_mesh(boards, stage, f"{pallet}/Boards", looks["wood"])


def build_mechanisms(stage: Usd.Stage, root: str, looks: dict[str, str]) -> None:
    """Write the parts on joints below `root`: a swinging sign, a pendulum, a turning barrier and a sliding gate."""
    sign = rigid(stage, f"{root}/Sign", (-7.2, 3.0, 2.8), mass=6.0, spin_deg=(140, 0, 0))
    board = cube(stage, f"{sign}/Board", (1.2, 0.04, 0.8), (0, 0, -0.55))
    collide(board, looks["plastic"])
    hinge(stage, f"{root}/SignHinge", sign, (-7.2, 3.0, 2.8), "X", limits_deg=(-80, 80), damping=0.005)

    pendulum = rigid(stage, f"{root}/Pendulum", (6.0, -5.0, 3.0), mass=40.0, spin_deg=(0, 110, 0))
    rod = cylinder(stage, f"{pendulum}/Rod", 0.025, 2.0, "Z", (0, 0, -1.0))
    bind(rod, looks["painted_steel"])
    bob = UsdGeom.Sphere.Define(stage, f"{pendulum}/Bob")
    bob.CreateRadiusAttr(0.3)
    bob.AddTranslateOp().Set(Gf.Vec3d(0, 0, -2.1))
    collide(bob.GetPrim(), looks["painted_steel"])
    hinge(stage, f"{root}/PendulumHinge", pendulum, (6.0, -5.0, 3.0), "Y", damping=0.005)

    barrier = rigid(stage, f"{root}/Barrier", (0.5, -8.0, 0.95), mass=12.0)
    for name, size in (("ArmX", (2.4, 0.08, 0.08)), ("ArmY", (0.08, 2.4, 0.08))):
        collide(cube(stage, f"{barrier}/{name}", size), looks["painted_steel"])
    hinge(stage, f"{root}/BarrierHinge", barrier, (0.5, -8.0, 0.95), "Z", damping=2.0, speed_deg=75.0)

    gate = rigid(stage, f"{root}/Gate", (-29.8, 0.0, 0.0), mass=90.0)
    frame = Mesh()
    for z in (0.15, 1.0, 1.85):
        frame.add_box((0, 0, z), (0.06, 2 * PANEL, 0.08))
    for y in np.linspace(-PANEL, PANEL, 26):
        frame.add_box((0, y, 1.0), (0.03, 0.04, 1.7))
    frame.define(stage, f"{gate}/Frame", looks["painted_steel"])
    panel = cube(stage, f"{gate}/Panel", (0.06, 2 * PANEL, 1.7), (0, 0, 1.0))
    UsdGeom.Imageable(panel).MakeInvisible()
    UsdPhysics.CollisionAPI.Apply(panel)
    _gate_rail(stage, f"{root}/GateRail", gate)


def rigid(
    stage: Usd.Stage,
    path: str,
    position: Vector,
    *,
    mass: float,
    turn_deg: float = 0.0,
    velocity: Vector = (0, 0, 0),
    spin_deg: Sequence[float] = (0, 0, 0),
) -> str:
    """A rigid body at `position` [m], with its mass [kg], velocity [m/s] and spin [deg/s]; returns its path."""
    body = UsdGeom.Xform.Define(stage, path)
    body.AddTranslateOp().Set(Gf.Vec3d(*map(float, position)))
    if turn_deg:
        body.AddRotateZOp().Set(float(turn_deg))
    physics = UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
    if any(velocity):
        physics.CreateVelocityAttr(Gf.Vec3f(*map(float, velocity)))
    if any(spin_deg):
        physics.CreateAngularVelocityAttr(Gf.Vec3f(*(round(float(value), 3) for value in spin_deg)))
    UsdPhysics.MassAPI.Apply(body.GetPrim()).CreateMassAttr(mass)
    return path


def cube(stage: Usd.Stage, path: str, size: Vector, position: Vector = (0, 0, 0)) -> Usd.Prim:
    """A box of full edge lengths `size` [m] about `position` in its body's frame."""
    shape = UsdGeom.Cube.Define(stage, path)
    shape.CreateSizeAttr(1.0)
    shape.CreateExtentAttr([Gf.Vec3f(-0.5), Gf.Vec3f(0.5)])
    if any(position):
        shape.AddTranslateOp().Set(Gf.Vec3d(*map(float, position)))
    shape.AddScaleOp().Set(Gf.Vec3f(*map(float, size)))
    return shape.GetPrim()


def cylinder(
    stage: Usd.Stage, path: str, radius: float, height: float, axis: str, position: Vector = (0, 0, 0)
) -> Usd.Prim:
    """A cylinder along `axis` about `position` in its body's frame [m]."""
    shape = UsdGeom.Cylinder.Define(stage, path)
    shape.CreateAxisAttr(axis)
    shape.CreateRadiusAttr(radius)
    shape.CreateHeightAttr(height)
    if any(position):
        shape.AddTranslateOp().Set(Gf.Vec3d(*map(float, position)))
    return shape.GetPrim()


def collide(prim: Usd.Prim, look: str) -> None:
    """Make the shape a collider and give it its look."""
    UsdPhysics.CollisionAPI.Apply(prim)
    bind(prim, look)


def hull_mesh(mesh: Mesh, stage: Usd.Stage, path: str, look: str) -> None:
    """Write a mesh that collides as its convex hull."""
    prim = mesh.define(stage, path, look).GetPrim()
    UsdPhysics.CollisionAPI.Apply(prim)
    UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(UsdPhysics.Tokens.convexHull)


def hinge(
    stage: Usd.Stage,
    path: str,
    body: str,
    anchor: Vector,
    axis: str,
    *,
    base: str = "",
    pivot: Vector = (0, 0, 0),
    limits_deg: tuple[float, float] | None = None,
    damping: float | None = None,
    speed_deg: float = 0.0,
    force: float | None = None,
) -> UsdPhysics.RevoluteJoint:
    """A revolute joint about `axis` from `anchor` (frame of `base`, else the world) to `pivot` (frame of `body`).

    damping: of the velocity drive towards `speed_deg` [N m s/deg]; force: the most it may apply [N m].
    """
    joint = UsdPhysics.RevoluteJoint.Define(stage, path)
    joint.CreateAxisAttr(axis)
    if base:
        joint.CreateBody0Rel().SetTargets([Sdf.Path(base)])
    joint.CreateBody1Rel().SetTargets([Sdf.Path(body)])
    joint.CreateLocalPos0Attr(Gf.Vec3f(*map(float, anchor)))
    joint.CreateLocalPos1Attr(Gf.Vec3f(*map(float, pivot)))
    if limits_deg:
        joint.CreateLowerLimitAttr(limits_deg[0])
        joint.CreateUpperLimitAttr(limits_deg[1])
    if damping is not None:
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
        drive.CreateStiffnessAttr(0.0)
        drive.CreateDampingAttr(damping)
        drive.CreateTargetVelocityAttr(speed_deg)
        if force is not None:
            drive.CreateMaxForceAttr(force)
    return joint


def _gate_rail(stage: Usd.Stage, path: str, gate: str) -> None:
    rail = UsdPhysics.PrismaticJoint.Define(stage, path)
    rail.CreateAxisAttr("Y")
    rail.CreateBody1Rel().SetTargets([Sdf.Path(gate)])
    rail.CreateLocalPos0Attr(Gf.Vec3f(-29.8, 0, 0))
    rail.CreateLowerLimitAttr(-0.1)
    rail.CreateUpperLimitAttr(4.6)
    drive = UsdPhysics.DriveAPI.Apply(rail.GetPrim(), "linear")
    drive.CreateStiffnessAttr(60.0)
    drive.CreateDampingAttr(150.0)
    drive.CreateTargetPositionAttr(4.5)
    drive.CreateMaxForceAttr(400.0)


def _crates() -> list[tuple[Vector, float]]:
    """A pyramid of six and three that fall onto the asphalt, as (position, turn [deg])."""
    pitch, rest = CRATE + 0.05, CRATE / 2
    pyramid = [
        ((3.5, 2.0 + pitch * (column - (2 - row) / 2), rest + CRATE * row), 0.0)
        for row in range(3)
        for column in range(3 - row)
    ]
    return [*pyramid, ((0.5, 5.0, 1.8), 20.0), ((1.0, 5.3, 2.7), -35.0), ((9.0, 1.0, 1.2), 45.0)]


def _balls() -> list[tuple[Vector, Vector]]:
    """Position [m] and velocity [m/s]; all balls are one size, so that sensors can share their mesh."""
    return [
        ((-9.0, -6.0, BALL), (2.4, 0.6, 0)),
        ((-2.0, -9.0, BALL), (0.3, 1.6, 0)),
        ((5.0, 6.0, 2.5), (-0.8, -0.4, 0)),
        ((0.0, 8.0, BALL), (0.5, -2.6, 0)),
        ((10.0, -3.0, BALL), (-1.8, 0.9, 0)),
        ((-5.0, 1.0, 3.5), (0.7, 0, 0)),
    ]


def _cone() -> Mesh:
    profile = [(0.15, 0.03), (0.03, 0.7)]
    cone = Mesh().add_box((0, 0, 0.015), (0.4, 0.4, 0.03))
    return cone.add_tube([(0, 0, z) for _, z in profile], [radius for radius, _ in profile], sides=20)
