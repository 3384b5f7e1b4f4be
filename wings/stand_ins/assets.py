"""Stand-ins for the most used assets of Isaac Sim: floors, rooms, a warehouse, blocks, and the robots of examples.

Joints have the names, axes and limits of the originals; shapes are boxes and capsules, and sizes of rooms are ours.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import Any

from graph.sim.scene.assets import StandIn
from graph.sim.usd import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade

Numbers = Sequence[float]
EFFORTS = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)
"""Of the Franka's joints [N m]; fingers 20 N."""
ARM = (
    # at [m], turned about x by [deg], lower and upper limit [rad], mass of the link [kg]
    ((0, 0, 0.333), 0, -2.8973, 2.8973, 2.74),
    ((0, 0, 0), -90, -1.7628, 1.7628, 2.74),
    ((0, -0.316, 0), 90, -2.8973, 2.8973, 2.38),
    ((0.0825, 0, 0), 90, -3.0718, -0.0698, 2.38),
    ((-0.0825, 0.384, 0), -90, -2.8973, 2.8973, 2.74),
    ((0, 0, 0), 90, -0.0175, 3.7525, 1.55),
    ((0.088, 0, 0), 90, -2.8973, 2.8973, 0.54),
)
"""Frames of the Franka's seven joints, each in that of the joint before (its data sheet)."""
HOME = (0.0, -0.57, 0.0, -2.81, 0.0, 3.037, 0.741)
"""The joint positions at which it stands [rad]."""
FLANGE, HAND_TURN, FINGERS_AT, FINGERS_APART = 0.107, -45.0, 0.0584, 0.04
ROOM, ROOM_HEIGHT = (8.0, 8.0), 3.0
HALL, HALL_HEIGHT = (20.0, 30.0), 9.0
LAMP_RADIUS, LAMP_HEIGHT = 0.5, 7.0
WHEEL_RADIUS, WHEEL_DISTANCE = 0.03, 0.1125
SLOW, QUICK = (1e4, 1e4, 1e9), (1e6, 2e4, 1e9)
"""Stiffness, damping and highest force of drives that reach targets in seconds, or at once [N m, N, deg, m, s]."""
GROUND_OF_ANT = -0.78
"""The height of the ground below an ant at the origin [m]."""


def stand_in(tail: str) -> StandIn | None:
    """The stand-in for an asset by its path from `/Isaac/` on."""
    for pattern, make, what in KNOWN:
        if re.search(pattern, tail, re.IGNORECASE):
            stage = Usd.Stage.CreateInMemory(f"{tail.rpartition('/')[2].partition('.')[0]}.usda")
            UsdGeom.SetStageMetersPerUnit(stage, 1.0)
            UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
            stage.SetDefaultPrim(make(stage))
            return StandIn.of(stage, what)
    return None


def sphere_light(stage: Any, path: str, height: float) -> None:
    """A lamp that gives the ground below it, at its centre, about as much light as a dome of intensity 500 does."""
    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(LAMP_RADIUS)
    light.CreateIntensityAttr(500.0 * (height / LAMP_RADIUS) ** 2)
    light.AddTranslateOp().Set(Gf.Vec3d(0, 0, height))
    light.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(1))
    light.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(1))


def _ground(stage: Any, lamp_height: float = LAMP_HEIGHT) -> Any:
    sphere_light(stage, "/World/SphereLight", lamp_height)
    root = UsdGeom.Xform.Define(stage, "/World")
    plane = UsdGeom.Plane.Define(stage, "/World/GroundPlane")
    plane.CreateAxisAttr("Z")
    UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
    return root.GetPrim()


def _room(stage: Any) -> Any:
    root = _ground(stage, ROOM_HEIGHT - 2 * LAMP_RADIUS)
    _walls(stage, ROOM, ROOM_HEIGHT)
    _box(stage, "/World/table", (1.2, 0.8, 0.05), (0, 0, 0.725))
    for number, (x, y) in enumerate(((0.5, 0.3), (0.5, -0.3), (-0.5, 0.3), (-0.5, -0.3))):
        _box(stage, f"/World/table_leg_{number}", (0.05, 0.05, 0.7), (x, y, 0.35))
    return root


def _hall(stage: Any) -> Any:
    root = _ground(stage, HALL_HEIGHT - 2 * LAMP_RADIUS)
    _walls(stage, HALL, HALL_HEIGHT)
    for row, x in enumerate((-7.5, -2.5, 2.5, 7.5)):
        for level in range(4):
            _box(stage, f"/World/rack_{row}_shelf_{level}", (1.2, 20, 0.1), (x, 0, 0.3 + 1.8 * level))
        for side, y in enumerate((-10.0, 0.0, 10.0)):
            _box(stage, f"/World/rack_{row}_post_{side}", (1.2, 0.1, 6.0), (x, y, 3.0))
    return root


def _walls(stage: Any, size: tuple[float, float], height: float) -> None:
    width, length = size
    for name, x, y in (("east", 1, 0), ("west", -1, 0), ("north", 0, 1), ("south", 0, -1)):
        shape = (0.1, length, height) if x else (width, 0.1, height)
        _box(stage, f"/World/wall_{name}", shape, (x * width / 2, y * length / 2, height / 2))


def _block(stage: Any) -> Any:
    root = UsdGeom.Xform.Define(stage, "/Root").GetPrim()
    _box(stage, "/Root/Cube", (0.05, 0.05, 0.05), (0, 0, 0))
    _body(stage.GetPrimAtPath("/Root/Cube"), 0.1)
    return root


def _box(stage: Any, path: str, size: Numbers, at: Numbers) -> None:
    """A solid box; size and centre [m]."""
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(Gf.Vec3d(*map(float, at)))
    cube.AddScaleOp().Set(Gf.Vec3f(*map(float, size)))
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())


def _body(prim: Any, mass: float, inertia: Numbers = ()) -> None:
    UsdPhysics.RigidBodyAPI.Apply(prim)
    api = UsdPhysics.MassAPI.Apply(prim)
    api.CreateMassAttr(mass)
    if inertia:
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(*inertia))
        api.CreateCenterOfMassAttr(Gf.Vec3f(0))


def _franka(stage: Any) -> Any:
    """Seven revolute joints and two fingers; its links have no colliders but the fingers."""
    root = UsdGeom.Xform.Define(stage, "/panda").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    pose, link = Gf.Matrix4d(1.0), _link(stage, "panda_link0", Gf.Matrix4d(1.0), 2.8, 0.14)
    base = UsdPhysics.FixedJoint.Define(stage, "/panda/root_joint")
    base.CreateBody1Rel().SetTargets([link])
    for number, (at, turn, lower, upper, mass) in enumerate(ARM, start=1):
        step = _frame(at, (1, 0, 0), turn)
        pose = _frame((0, 0, 0), (0, 0, 1), math.degrees(HOME[number - 1])) * step * pose
        child = _link(stage, f"panda_link{number}", pose, mass, 0.12)
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"{link}/panda_joint{number}")
        _joined(joint, link, child, step)
        joint.CreateAxisAttr("Z")
        joint.CreateLowerLimitAttr(math.degrees(lower))
        joint.CreateUpperLimitAttr(math.degrees(upper))
        _drive(joint, "angular", 100.0, 10.0, EFFORTS[number - 1], math.degrees(HOME[number - 1]))
        link = child
    step = _frame((0, 0, FLANGE), (0, 0, 1), HAND_TURN)
    hand = _link(stage, "panda_hand", step * pose, 0.73, 0.1)
    _joined(UsdPhysics.FixedJoint.Define(stage, f"{link}/panda_hand_joint"), link, hand, step)
    for number, (name, side) in enumerate((("panda_leftfinger", 1), ("panda_rightfinger", -1)), start=1):
        turned = _frame((0, 0, FINGERS_AT), (0, 0, 1), 0.0 if side > 0 else 180.0)
        opened = _frame((0, FINGERS_APART, 0), (0, 0, 1), 0.0) * turned * step * pose
        finger = _link(stage, name, opened, 0.1, 0.05, solid=True)
        joint = UsdPhysics.PrismaticJoint.Define(stage, f"{hand}/panda_finger_joint{number}")
        _joined(joint, hand, finger, turned)
        joint.CreateAxisAttr("Y")
        joint.CreateLowerLimitAttr(0.0)
        joint.CreateUpperLimitAttr(FINGERS_APART)
        _drive(joint, "linear", 1000.0, 100.0, 20.0, FINGERS_APART)
    return root


def _link(stage: Any, name: str, pose: Any, mass: float, height: float, *, solid: bool = False) -> str:
    """A link of the Franka with a box of this height on its z axis."""
    path = f"/panda/{name}"
    prim = UsdGeom.Xform.Define(stage, path)
    prim.AddTransformOp().Set(pose)
    _body(prim.GetPrim(), mass, [mass * 0.01] * 3)
    shape = UsdGeom.Cube.Define(stage, f"{path}/visuals")
    shape.CreateSizeAttr(1.0)
    shape.AddTranslateOp().Set(Gf.Vec3d(0, 0.01 if solid else 0, height / 2 if solid else 0))
    shape.AddScaleOp().Set(Gf.Vec3f(0.02, 0.02, height) if solid else Gf.Vec3f(0.1, 0.1, height))
    if solid:
        UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    return path


def _frame(at: Numbers, axis: Numbers, degrees: float) -> Any:
    """A frame in its parent's: turned about an axis, then moved [m]; row vectors."""
    turn = Gf.Rotation(Gf.Vec3d(*map(float, axis)), degrees)
    return Gf.Matrix4d().SetTransform(turn, Gf.Vec3d(*map(float, at)))


def _joined(joint: Any, parent: str, child: str, frame: Any) -> None:
    """Joins two bodies; frame: the child's in the parent's."""
    joint.CreateBody0Rel().SetTargets([parent])
    joint.CreateBody1Rel().SetTargets([child])
    joint.CreateLocalPos0Attr(Gf.Vec3f(frame.ExtractTranslation()))
    joint.CreateLocalRot0Attr(Gf.Quatf(frame.ExtractRotationQuat()))
    joint.CreateLocalPos1Attr(Gf.Vec3f(0))
    joint.CreateLocalRot1Attr(Gf.Quatf(1))


def _drive(joint: Any, kind: str, stiffness: float, damping: float, force: float, target: float = 0.0) -> None:
    drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), kind)
    drive.CreateStiffnessAttr(stiffness)
    drive.CreateDampingAttr(damping)
    drive.CreateMaxForceAttr(force)
    drive.CreateTargetPositionAttr(target)


def _jetbot(stage: Any) -> Any:
    """Two driven wheels and a frictionless ball behind."""
    root = UsdGeom.Xform.Define(stage, "/jetbot").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    chassis = UsdGeom.Xform.Define(stage, "/jetbot/chassis")
    chassis.AddTranslateOp().Set(Gf.Vec3d(0, 0, WHEEL_RADIUS))
    _body(chassis.GetPrim(), 1.0)
    _box(stage, "/jetbot/chassis/body", (0.14, 0.08, 0.06), (-0.02, 0, 0.03))
    ball = UsdGeom.Sphere.Define(stage, "/jetbot/chassis/caster")
    ball.CreateRadiusAttr(0.01)
    ball.AddTranslateOp().Set(Gf.Vec3d(-0.07, 0, 0.01 - WHEEL_RADIUS))
    UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
    smooth = UsdShade.Material.Define(stage, "/jetbot/smooth")
    friction = UsdPhysics.MaterialAPI.Apply(smooth.GetPrim())
    friction.CreateStaticFrictionAttr(0.0)
    friction.CreateDynamicFrictionAttr(0.0)
    smooth.GetPrim().CreateAttribute("physxMaterial:frictionCombineMode", Sdf.ValueTypeNames.Token).Set("min")
    binding = UsdShade.MaterialBindingAPI.Apply(ball.GetPrim())
    binding.Bind(smooth, UsdShade.Tokens.weakerThanDescendants, "physics")
    for name, side in (("left_wheel", 1), ("right_wheel", -1)):
        at = (0.0, side * WHEEL_DISTANCE / 2, 0.0)
        wheel = UsdGeom.Cylinder.Define(stage, f"/jetbot/{name}")
        wheel.CreateAxisAttr("Y")
        wheel.CreateRadiusAttr(WHEEL_RADIUS)
        wheel.CreateHeightAttr(0.025)
        wheel.AddTranslateOp().Set(Gf.Vec3d(at[0], at[1], WHEEL_RADIUS))
        UsdPhysics.CollisionAPI.Apply(wheel.GetPrim())
        _body(wheel.GetPrim(), 0.05)
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/jetbot/chassis/{name}_joint")
        _joined(joint, "/jetbot/chassis", f"/jetbot/{name}", _frame(at, (0, 0, 1), 0.0))
        joint.CreateAxisAttr("Y")
        _drive(joint, "angular", 0.0, 0.01, 0.1)
    return root


def _articulation(stage: Any) -> Any:
    """A fixed pivot, an arm that turns about z, and a slider on the arm: the arm's load is 2 kg at 1 m."""
    return _pivot_arm(stage, "RevoluteJoint", SLOW)


def _three_joints(stage: Any) -> Any:
    """The same arm, with a second turning link on the slider."""
    root = _pivot_arm(stage, "CenterRevoluteJoint", QUICK)
    _bar(stage, "DistalPivot", 1.5, (0.4, 0.1, 0.1), 0.5)
    joint = UsdPhysics.RevoluteJoint.Define(stage, "/Articulation/DistalPivot/DistalRevoluteJoint")
    _joined(joint, "/Articulation/Slider", "/Articulation/DistalPivot", _frame((0.5, 0, 0), (0, 0, 1), 0.0))
    joint.CreateAxisAttr("Z")
    _drive(joint, "angular", *QUICK)
    return root


def _pivot_arm(stage: Any, name: str, drive: Numbers) -> Any:
    root = UsdGeom.Xform.Define(stage, "/Articulation").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    for link, at, size in (
        ("CenterPivot", 0.0, (0.1, 0.1, 0.1)),
        ("Arm", 1.0, (2.0, 0.1, 0.1)),
        ("Slider", 1.0, (0.2, 0.2, 0.08)),
    ):
        _bar(stage, link, at, size, 1.0)
    base = UsdPhysics.FixedJoint.Define(stage, "/Articulation/CenterPivot/FixedJoint")
    base.CreateBody1Rel().SetTargets(["/Articulation/CenterPivot"])
    turning = UsdPhysics.RevoluteJoint.Define(stage, f"/Articulation/Arm/{name}")
    turning.CreateBody0Rel().SetTargets(["/Articulation/CenterPivot"])
    turning.CreateBody1Rel().SetTargets(["/Articulation/Arm"])
    turning.CreateLocalPos1Attr(Gf.Vec3f(-1, 0, 0))
    turning.CreateAxisAttr("Z")
    _drive(turning, "angular", *drive)
    sliding = UsdPhysics.PrismaticJoint.Define(stage, "/Articulation/Slider/PrismaticJoint")
    _joined(sliding, "/Articulation/Arm", "/Articulation/Slider", _frame((0, 0, 0), (0, 0, 1), 0.0))
    sliding.CreateAxisAttr("X")
    sliding.CreateLowerLimitAttr(-1.0)
    sliding.CreateUpperLimitAttr(1.0)
    _drive(sliding, "linear", *drive)
    return root


def _bar(stage: Any, name: str, at: float, size: Numbers, mass: float) -> None:
    """A link of the pivot arm: a box whose centre is on the x axis."""
    link = UsdGeom.Xform.Define(stage, f"/Articulation/{name}")
    link.AddTranslateOp().Set(Gf.Vec3d(at, 0, 0))
    link.AddOrientOp().Set(Gf.Quatf(1))
    link.AddScaleOp().Set(Gf.Vec3f(1))
    _body(link.GetPrim(), mass)
    _box(stage, f"/Articulation/{name}/shape", size, (0, 0, 0))


def _ant(stage: Any) -> Any:
    """A ball on four legs of two links each, in centimetres scaled by 0.01, and the ground below it."""
    _ground(stage)
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath("/World/GroundPlane")).SetTranslate((0, 0, GROUND_OF_ANT))
    root = UsdGeom.Xform.Define(stage, "/Ant").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    ball = UsdGeom.Sphere.Define(stage, "/Ant/Sphere")
    ball.CreateRadiusAttr(25.0)
    _limb(ball, Gf.Matrix4d(1.0), 2.0)
    for number in range(4):
        side = _frame((0, 0, 0), (0, 0, 1), 90.0 * number)
        arm = f"/Ant/Arm_{number + 1:02d}"
        UsdGeom.Xform.Define(stage, arm)
        upper, lower = (UsdGeom.Capsule.Define(stage, f"{arm}/{name}") for name in ("Upper_Arm", "Lower_Arm"))
        bent = _frame((0.4, 0, 0), (0, 1, 0), 0.0) * _frame((0.6, 0, 0), (0, 1, 0), 60.0)
        for limb, height, pose in ((upper, 30.0, _frame((0.4, 0, 0), (0, 1, 0), 0.0)), (lower, 80.0, bent)):
            limb.CreateAxisAttr("X")
            limb.CreateRadiusAttr(8.0)
            limb.CreateHeightAttr(height)
            _limb(limb, pose * side, 0.25)
        for name, axis, ends, at in (
            ("Upper_Arm/shoulder_joint", "Z", (ball, upper), _frame((0.2, 0, 0), (0, 1, 0), 0.0) * side),
            ("Lower_Arm/lower_arm_joint", "Y", (upper, lower), _frame((0.6, 0, 0), (0, 1, 0), 0.0) * side),
        ):
            joint = UsdPhysics.RevoluteJoint.Define(stage, f"{arm}/{name}")
            joint.CreateAxisAttr(axis)
            _between(joint, *ends, at)
            joint.CreateLowerLimitAttr(-60.0)
            joint.CreateUpperLimitAttr(60.0)
            _drive(joint, "angular", 10.0, 1.0, 100.0)
    return root


def _limb(shape: Any, pose: Any, mass: float) -> None:
    """Makes a shape in centimetres a solid body at a pose [m]."""
    shape.AddTranslateOp().Set(pose.ExtractTranslation())
    shape.AddOrientOp().Set(Gf.Quatf(pose.ExtractRotationQuat()))
    shape.AddScaleOp().Set(Gf.Vec3f(0.01))
    UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    _body(shape.GetPrim(), mass)


def _between(joint: Any, parent: Any, child: Any, frame: Any) -> None:
    """Joins two bodies at a frame of the world."""
    for body, targets, position, rotation in (
        (parent, joint.CreateBody0Rel(), joint.CreateLocalPos0Attr(), joint.CreateLocalRot0Attr()),
        (child, joint.CreateBody1Rel(), joint.CreateLocalPos1Attr(), joint.CreateLocalRot1Attr()),
    ):
        pose = body.ComputeLocalToWorldTransform(0)
        targets.SetTargets([body.GetPath()])
        position.Set(Gf.Vec3f(pose.GetInverse().Transform(frame.ExtractTranslation())))
        turn = (frame * pose.GetOrthonormalized().GetInverse()).ExtractRotationQuat()
        rotation.Set(Gf.Quatf(turn))


KNOWN: tuple[tuple[str, Callable[[Any], Any], str], ...] = (
    (r"/Environments/Grid/", _ground, "an endless ground plane"),
    (r"/Environments/Simple_Room/", _room, "a room of 8 x 8 m with a table"),
    (r"/Environments/Simple_Warehouse/", _hall, "a hall of 20 x 30 m with four racks"),
    (r"/Props/Blocks/", _block, "a cube of 5 cm"),
    (r"/Robots/(FrankaRobotics/FrankaPanda|Franka)/franka[^/]*$", _franka, "an arm with its 9 joints, links as boxes"),
    (r"/Robots/(NVIDIA/)?Jetbot/jetbot[^/]*$", _jetbot, "a box on its two driven wheels"),
    (r"/SimpleArticulation/simple_articulation[^/]*$", _articulation, "an arm on a fixed pivot, and a slider on it"),
    (r"/SimpleArticulation/articulation_3_joints[^/]*$", _three_joints, "the arm and slider, and a second arm on it"),
    (r"/Robots/IsaacSim/Ant/ant_colored[^/]*$", _ant, "a ball on four legs of two links each, and a ground plane"),
)
"""Patterns of asset paths, what makes their stand-ins, and these in words."""
