"""Stand-ins for robots: their joints have the names, axes and limits of the originals; shapes are simple."""

from __future__ import annotations

import math
from typing import Any

from graph.base.records import dataclass
from graph.sim.usd import Gf, Sdf, UsdGeom, UsdPhysics, UsdShade

from .parts import Numbers, add_box, add_drive, frame_at, ground, join, make_body

EFFORTS = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)
"""Of the Franka's joints [N m]; fingers 200 N, which Isaac Lab gives them, so that each holds its own place."""
ARM = (
    # at [m], turned about x by [deg], mass of the link [kg]
    ((0, 0, 0.333), 0, 2.74),
    ((0, 0, 0), -90, 2.74),
    ((0, -0.316, 0), 90, 2.38),
    ((0.0825, 0, 0), 90, 2.38),
    ((-0.0825, 0.384, 0), -90, 2.74),
    ((0, 0, 0), 90, 1.55),
    ((0.088, 0, 0), 90, 0.54),
)
"""Frames of the Franka's seven joints, each in that of the joint before (its data sheet)."""
LIMITS = {
    "panda": (
        (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
        (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
    ),
    "fr3": (
        (-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159),
        (2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159),
    ),
}
"""Lowest and highest joint positions [rad] of the Panda and of the Research 3, whose frames are the same."""
HOME = (0.0, -0.57, 0.0, -2.81, 0.0, 3.037, 0.741)
"""The joint positions at which it stands [rad]."""
VARIANTS = {"Gripper": ("Default", "AlternateFinger", "None", "Robotiq_2F_85"), "Mesh": ("Performance", "Quality")}
"""Of the original; here they all look alike."""
FLANGE, HAND_TURN, FINGERS_AT, FINGERS_APART = 0.107, -45.0, 0.0584, 0.04
STEERING = (1e4, 1e3, 1e5)
"""Stiffness, damping and highest torque of the drives that steer wheels [N m, deg, s]."""
SLOW, QUICK = (1e4, 1e4, 1e9), (1e6, 2e4, 1e9)
"""Stiffness, damping and highest force of drives that reach targets in seconds, or at once [N m, N, deg, m, s]."""
GROUND_OF_ANT = -0.78
"""The height of the ground below an ant at the origin [m]."""


def franka(stage: Any, name: str = "panda") -> Any:
    """Seven revolute joints and two fingers; its links have no colliders but the fingers."""
    root = UsdGeom.Xform.Define(stage, f"/{name}").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    pose, link = Gf.Matrix4d(1.0), _link(stage, f"/{name}/{name}_link0", Gf.Matrix4d(1.0), 2.8, 0.14)
    base = UsdPhysics.FixedJoint.Define(stage, f"/{name}/rootJoint")
    base.CreateBody1Rel().SetTargets([link])
    for number, ((at, turn, mass), lower, upper) in enumerate(zip(ARM, *LIMITS[name], strict=True), start=1):
        step = frame_at(at, (1, 0, 0), turn)
        pose = frame_at((0, 0, 0), (0, 0, 1), math.degrees(HOME[number - 1])) * step * pose
        child = _link(stage, f"/{name}/{name}_link{number}", pose, mass, 0.12)
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"{link}/{name}_joint{number}")
        join(joint, link, child, step)
        joint.CreateAxisAttr("Z")
        joint.CreateLowerLimitAttr(math.degrees(lower))
        joint.CreateUpperLimitAttr(math.degrees(upper))
        add_drive(joint, "angular", 100.0, 10.0, EFFORTS[number - 1], math.degrees(HOME[number - 1]))
        link = child
    step = frame_at((0, 0, FLANGE), (0, 0, 1), HAND_TURN)
    hand = _link(stage, f"/{name}/{name}_hand", step * pose, 0.73, 0.1)
    join(UsdPhysics.FixedJoint.Define(stage, f"{link}/{name}_hand_joint"), link, hand, step)
    for number, (finger_name, side) in enumerate((("leftfinger", 1), ("rightfinger", -1)), start=1):
        turned = frame_at((0, 0, FINGERS_AT), (0, 0, 1), 0.0 if side > 0 else 180.0)
        opened = frame_at((0, FINGERS_APART, 0), (0, 0, 1), 0.0) * turned * step * pose
        finger = _link(stage, f"/{name}/{name}_{finger_name}", opened, 0.1, 0.05, solid=True)
        joint = UsdPhysics.PrismaticJoint.Define(stage, f"{hand}/{name}_finger_joint{number}")
        join(joint, hand, finger, turned)
        joint.CreateAxisAttr("Y")
        joint.CreateLowerLimitAttr(0.0)
        joint.CreateUpperLimitAttr(FINGERS_APART)
        add_drive(joint, "linear", 2000.0, 100.0, 200.0, FINGERS_APART)
    for variant_set, choices in VARIANTS.items():
        variants = root.GetVariantSets().AddVariantSet(variant_set)
        for choice in choices:
            variants.AddVariant(choice)
        variants.SetVariantSelection(choices[0])
    return root


def _link(stage: Any, path: str, pose: Any, mass: float, height: float, *, solid: bool = False) -> str:
    """A link of the Franka with a box of this height on its z axis."""
    prim = UsdGeom.Xform.Define(stage, path)
    prim.AddTransformOp().Set(pose)
    make_body(prim.GetPrim(), mass, [mass * 0.01] * 3)
    shape = UsdGeom.Cube.Define(stage, f"{path}/geometry")
    shape.CreateSizeAttr(1.0)
    shape.AddTranslateOp().Set(Gf.Vec3d(0, 0.01 if solid else 0, height / 2 if solid else 0))
    shape.AddScaleOp().Set(Gf.Vec3f(0.02, 0.02, height) if solid else Gf.Vec3f(0.1, 0.1, height))
    if solid:
        UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    return path


@dataclass(frozen=True, slots=True)
class Wheel:
    """A driven wheel: its link and joint, where it is in the chassis [m], its radius, and the joint that steers it."""

    link: str
    joint: str
    x: float
    y: float
    radius: float
    steering: str = ""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A box on wheels, whose chassis frame is at the height of the first wheel's centre; a ball without friction
    stands below it where there are only two wheels.
    """

    root: str
    chassis: str
    size: Numbers
    at: Numbers
    """The centre of the box in the chassis [m]."""
    masses: tuple[float, float]
    """Of the chassis and of each wheel [kg]."""
    drive: tuple[float, float]
    """Damping [N m s/deg] and highest torque [N m] of the wheels' drives."""
    wheels: tuple[Wheel, ...]
    ball: tuple[float, float] = (0.0, 0.0)
    """Where the ball is behind the wheels, and its radius [m]."""


JETBOT = Vehicle(
    "jetbot",
    "chassis",
    (0.14, 0.08, 0.06),
    (-0.02, 0, 0.03),
    (1.0, 0.05),
    (0.01, 0.1),
    (
        Wheel("left_wheel", "left_wheel_joint", 0, 0.05625, 0.03),
        Wheel("right_wheel", "right_wheel_joint", 0, -0.05625, 0.03),
    ),
    (-0.07, 0.01),
)
NOVA_CARTER = Vehicle(
    "nova_carter",
    "chassis_link",
    (0.7, 0.34, 0.3),
    (-0.2, 0, 0.15),
    (45.0, 2.0),
    (1.0, 60.0),
    (
        Wheel("wheel_left", "joint_wheel_left", 0, 0.2066, 0.14),
        Wheel("wheel_right", "joint_wheel_right", 0, -0.2066, 0.14),
    ),
    (-0.38, 0.06),
)
CARTER = Vehicle(
    "carter",
    "chassis_link",
    (0.7, 0.44, 0.3),
    (-0.2, 0, 0.15),
    (30.0, 2.0),
    (1.0, 60.0),
    (
        Wheel("left_wheel_link", "left_wheel", 0, 0.27, 0.24),
        Wheel("right_wheel_link", "right_wheel", 0, -0.27, 0.24),
    ),
    (-0.4, 0.06),
)
TURTLEBOT = Vehicle(
    "turtlebot3_burger",
    "base_link",
    (0.138, 0.14, 0.12),
    (-0.032, 0, 0.09),
    (0.94, 0.03),
    (0.01, 1.0),
    (
        Wheel("wheel_left_link", "wheel_left_joint", 0, 0.08, 0.033),
        Wheel("wheel_right_link", "wheel_right_joint", 0, -0.08, 0.033),
    ),
    (-0.081, 0.016),
)
CREATE = Vehicle(
    "create_3",
    "base_link",
    (0.3, 0.2, 0.07),
    (0, 0, 0.02),
    (2.3, 0.1),
    (0.05, 5.0),
    (
        Wheel("left_wheel", "left_wheel_joint", 0, 0.1165, 0.03575),
        Wheel("right_wheel", "right_wheel_joint", 0, -0.1165, 0.03575),
    ),
    (0.125, 0.0125),
)
JACKAL = Vehicle(
    "jackal",
    "base_link",
    (0.42, 0.31, 0.184),
    (0, 0, 0.06),
    (16.5, 0.5),
    (0.5, 20.0),
    tuple(
        Wheel(f"{end}_{side}_wheel_link", f"{end}_{side}_wheel", x, y, 0.098)
        for end, x in (("front", 0.131), ("rear", -0.131))
        for side, y in (("left", 0.18779), ("right", -0.18779))
    ),
)
FORKLIFT = Vehicle(
    "forklift",
    "body",
    (2.2, 0.8, 0.5),
    (-0.85, 0, 0.35),
    (1500.0, 30.0),
    (20.0, 2000.0),
    tuple(
        Wheel(f"{side}_{end}_wheel", f"{side}_{end}_wheel_joint", x, y, radius, f"{side}_rotator" * (end == "back"))
        for end, x, radius in (("front", 0.0, 0.325), ("back", -1.65, 0.255))
        for side, y in (("left", 0.525), ("right", -0.525))
    ),
)


def vehicle(one: Vehicle, stage: Any) -> Any:
    """Makes a vehicle; returns its root."""
    root = UsdGeom.Xform.Define(stage, f"/{one.root}").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    height = one.wheels[0].radius
    chassis = UsdGeom.Xform.Define(stage, f"/{one.root}/{one.chassis}")
    chassis.AddTranslateOp().Set(Gf.Vec3d(0, 0, height))
    make_body(chassis.GetPrim(), one.masses[0])
    add_box(stage, f"{chassis.GetPath()}/body", one.size, one.at)
    if one.ball[1]:
        _ball(stage, one, height)
    for wheel in one.wheels:
        _wheel(stage, one, wheel, height)
    return root


def _ball(stage: Any, one: Vehicle, height: float) -> None:
    at, radius = one.ball
    ball = UsdGeom.Sphere.Define(stage, f"/{one.root}/{one.chassis}/caster")
    ball.CreateRadiusAttr(radius)
    ball.AddTranslateOp().Set(Gf.Vec3d(at, 0, radius - height))
    UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
    smooth = UsdShade.Material.Define(stage, f"/{one.root}/smooth")
    friction = UsdPhysics.MaterialAPI.Apply(smooth.GetPrim())
    friction.CreateStaticFrictionAttr(0.0)
    friction.CreateDynamicFrictionAttr(0.0)
    smooth.GetPrim().CreateAttribute("physxMaterial:frictionCombineMode", Sdf.ValueTypeNames.Token).Set("min")
    binding = UsdShade.MaterialBindingAPI.Apply(ball.GetPrim())
    binding.Bind(smooth, UsdShade.Tokens.weakerThanDescendants, "physics")


def _wheel(stage: Any, one: Vehicle, wheel: Wheel, height: float) -> None:
    holder, at = f"/{one.root}/{one.chassis}", (wheel.x, wheel.y, wheel.radius - height)
    if wheel.steering:
        arm = UsdGeom.Xform.Define(stage, f"/{one.root}/{wheel.steering}")
        arm.AddTranslateOp().Set(Gf.Vec3d(wheel.x, wheel.y, wheel.radius))
        make_body(arm.GetPrim(), one.masses[1], [one.masses[1] * wheel.radius**2] * 3)
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"{holder}/{wheel.steering}_joint")
        join(joint, holder, str(arm.GetPath()), frame_at(at, (0, 0, 1), 0.0))
        joint.CreateAxisAttr("Z")
        add_drive(joint, "angular", *STEERING)
        holder, at = str(arm.GetPath()), (0.0, 0.0, 0.0)
    disc = UsdGeom.Cylinder.Define(stage, f"/{one.root}/{wheel.link}")
    disc.CreateAxisAttr("Y")
    disc.CreateRadiusAttr(wheel.radius)
    disc.CreateHeightAttr(wheel.radius * 5 / 6)
    disc.AddTranslateOp().Set(Gf.Vec3d(wheel.x, wheel.y, wheel.radius))
    UsdPhysics.CollisionAPI.Apply(disc.GetPrim())
    make_body(disc.GetPrim(), one.masses[1])
    joint = UsdPhysics.RevoluteJoint.Define(stage, f"{holder}/{wheel.joint}")
    join(joint, holder, str(disc.GetPath()), frame_at(at, (0, 0, 1), 0.0))
    joint.CreateAxisAttr("Y")
    add_drive(joint, "angular", 0.0, *one.drive)


def cartpole(stage: Any) -> Any:
    """A cart that slides along y on a fixed rail, and a pole that swings about x on it."""
    root = UsdGeom.Xform.Define(stage, "/cartPole").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    for name, size, centre, mass in (
        ("rail", (0.03, 8.0, 0.03), (0, 0, 0), 1.0),
        ("cart", (0.2, 0.25, 0.2), (0, 0, 0), 1.0),
        ("pole", (0.04, 0.06, 1.0), (0, 0, 0.5), 0.5),
    ):
        link = UsdGeom.Xform.Define(stage, f"/cartPole/{name}")
        make_body(link.GetPrim(), mass)
        add_box(stage, f"/cartPole/{name}/shape", size, centre)
    base = UsdPhysics.FixedJoint.Define(stage, "/cartPole/rootJoint")
    base.CreateBody1Rel().SetTargets(["/cartPole/rail"])
    here = frame_at((0, 0, 0), (0, 0, 1), 0.0)
    slide = UsdPhysics.PrismaticJoint.Define(stage, "/cartPole/rail/cartJoint")
    join(slide, "/cartPole/rail", "/cartPole/cart", here)
    slide.CreateAxisAttr("Y")
    slide.CreateLowerLimitAttr(-4.0)
    slide.CreateUpperLimitAttr(4.0)
    swing = UsdPhysics.RevoluteJoint.Define(stage, "/cartPole/cart/poleJoint")
    join(swing, "/cartPole/cart", "/cartPole/pole", here)
    swing.CreateAxisAttr("X")
    return root


def crazyflie(stage: Any) -> Any:
    """A box with four propellers that turn about z: 28 g, 92 mm from one to the one across."""
    root = UsdGeom.Xform.Define(stage, "/cf2x")
    root.AddTranslateOp()
    UsdPhysics.ArticulationRootAPI.Apply(root.GetPrim())
    root.GetPrim().CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    make_body(UsdGeom.Xform.Define(stage, "/cf2x/body").GetPrim(), 0.025)
    add_box(stage, "/cf2x/body/shape", (0.06, 0.06, 0.03), (0, 0, 0))
    for number, (x, y) in enumerate(((1, -1), (-1, -1), (-1, 1), (1, 1)), start=1):
        at, path = (0.0325 * x, 0.0325 * y, 0.02), f"/cf2x/m{number}_prop"
        propeller = UsdGeom.Cylinder.Define(stage, path)
        propeller.CreateRadiusAttr(0.023)
        propeller.CreateHeightAttr(0.002)
        propeller.AddTranslateOp().Set(Gf.Vec3d(*at))
        make_body(propeller.GetPrim(), 0.00075)
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/cf2x/body/m{number}_joint")
        join(joint, "/cf2x/body", path, frame_at(at, (0, 0, 1), 0.0))
        joint.CreateAxisAttr("Z")
    return root.GetPrim()


def articulation(stage: Any) -> Any:
    """A fixed pivot, an arm that turns about z, and a slider on the arm: the arm's load is 2 kg at 1 m."""
    return _pivot_arm(stage, "RevoluteJoint", SLOW)


def three_joints(stage: Any) -> Any:
    """The same arm, with a second turning link on the slider."""
    root = _pivot_arm(stage, "CenterRevoluteJoint", QUICK)
    _bar(stage, "DistalPivot", 1.5, (0.4, 0.1, 0.1), 0.5)
    joint = UsdPhysics.RevoluteJoint.Define(stage, "/Articulation/DistalPivot/DistalRevoluteJoint")
    join(joint, "/Articulation/Slider", "/Articulation/DistalPivot", frame_at((0.5, 0, 0), (0, 0, 1), 0.0))
    joint.CreateAxisAttr("Z")
    add_drive(joint, "angular", *QUICK)
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
    add_drive(turning, "angular", *drive)
    sliding = UsdPhysics.PrismaticJoint.Define(stage, "/Articulation/Slider/PrismaticJoint")
    join(sliding, "/Articulation/Arm", "/Articulation/Slider", frame_at((0, 0, 0), (0, 0, 1), 0.0))
    sliding.CreateAxisAttr("X")
    sliding.CreateLowerLimitAttr(-1.0)
    sliding.CreateUpperLimitAttr(1.0)
    add_drive(sliding, "linear", *drive)
    return root


def _bar(stage: Any, name: str, at: float, size: Numbers, mass: float) -> None:
    """A link of the pivot arm: a box whose centre is on the x axis."""
    link = UsdGeom.Xform.Define(stage, f"/Articulation/{name}")
    link.AddTranslateOp().Set(Gf.Vec3d(at, 0, 0))
    link.AddOrientOp().Set(Gf.Quatf(1))
    link.AddScaleOp().Set(Gf.Vec3f(1))
    make_body(link.GetPrim(), mass)
    add_box(stage, f"/Articulation/{name}/shape", size, (0, 0, 0))


def coloured_ant(stage: Any) -> Any:
    """An ant above a ground, with the names of `ant_colored`."""
    ground(stage)
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath("/World/GroundPlane")).SetTranslate((0, 0, GROUND_OF_ANT))
    arms = [f"/Ant/Arm_{number:02d}" for number in range(1, 5)]
    for arm in arms:
        UsdGeom.Xform.Define(stage, arm)
    limbs = [(f"{arm}/Upper_Arm", f"{arm}/Lower_Arm") for arm in arms]
    joints = [(f"{arm}/Upper_Arm/shoulder_joint", f"{arm}/Lower_Arm/lower_arm_joint") for arm in arms]
    return _four_legs(stage, "/Ant", "/Ant/Sphere", limbs, joints)


def ant(stage: Any) -> Any:
    """An ant whose torso is the root of its joints, as in `ant_instanceable`."""
    UsdGeom.Scope.Define(stage, "/ant/joints")
    names = [(f"{leg}_leg", f"{leg}_foot") for leg in ("front_left", "left_back", "right_back", "front_right")]
    limbs, joints = ([(f"{above}{one}", f"{above}{two}") for one, two in names] for above in ("/ant/", "/ant/joints/"))
    _four_legs(stage, "/ant/torso", "/ant/torso", limbs, joints)
    UsdGeom.XformCommonAPI(UsdGeom.Xform.Define(stage, "/ant")).SetRotate((0, 0, 45))
    return stage.GetPrimAtPath("/ant")


def _four_legs(stage: Any, root: str, torso: str, limbs: list[tuple[str, str]], joints: list[tuple[str, str]]) -> Any:
    """A ball with legs of an upper and a lower limb, in centimetres scaled by 0.01, from +x on counterclockwise."""
    if root != torso:
        UsdGeom.Xform.Define(stage, root)
    ball = UsdGeom.Sphere.Define(stage, torso)
    ball.CreateRadiusAttr(25.0)
    _limb(ball, Gf.Matrix4d(1.0), 2.0)
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath(root))
    settings = stage.GetPrimAtPath(root)
    settings.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    bent = frame_at((0.4, 0, 0), (0, 1, 0), 0.0) * frame_at((0.6, 0, 0), (0, 1, 0), 60.0)
    for number, (paths, (shoulder, knee)) in enumerate(zip(limbs, joints, strict=True)):
        side = frame_at((0, 0, 0), (0, 0, 1), 90.0 * number)
        upper, lower = (UsdGeom.Capsule.Define(stage, path) for path in paths)
        for limb, height, pose in ((upper, 30.0, frame_at((0.4, 0, 0), (0, 1, 0), 0.0)), (lower, 80.0, bent)):
            limb.CreateAxisAttr("X")
            limb.CreateRadiusAttr(8.0)
            limb.CreateHeightAttr(height)
            _limb(limb, pose * side, 0.25)
        for path, axis, ends, at in (
            (shoulder, "Z", (ball, upper), frame_at((0.2, 0, 0), (0, 1, 0), 0.0) * side),
            (knee, "Y", (upper, lower), frame_at((0.6, 0, 0), (0, 1, 0), 0.0) * side),
        ):
            joint = UsdPhysics.RevoluteJoint.Define(stage, path)
            joint.CreateAxisAttr(axis)
            _between(joint, *ends, at)
            joint.CreateLowerLimitAttr(-60.0)
            joint.CreateUpperLimitAttr(60.0)
            add_drive(joint, "angular", 10.0, 1.0, 100.0)
    return settings


def _limb(shape: Any, pose: Any, mass: float) -> None:
    """Makes a shape in centimetres a solid body at a pose [m]."""
    shape.AddTranslateOp().Set(pose.ExtractTranslation())
    shape.AddOrientOp().Set(Gf.Quatf(pose.ExtractRotationQuat()))
    shape.AddScaleOp().Set(Gf.Vec3f(0.01))
    UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    make_body(shape.GetPrim(), mass)


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
