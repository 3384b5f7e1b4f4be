"""What stand-ins are made of: grounds, boxes, bodies, joints and drives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from graph.sim.scene.lamps import LAMP_HEIGHT, sphere_light
from graph.sim.usd import Gf, UsdGeom, UsdPhysics

Numbers = Sequence[float]


def ground(stage: Any, lamp_height: float = LAMP_HEIGHT) -> Any:
    """An endless ground plane and a lamp above it, below /World; returns /World."""
    sphere_light(stage, "/World/SphereLight", lamp_height)
    root = UsdGeom.Xform.Define(stage, "/World")
    plane = UsdGeom.Plane.Define(stage, "/World/GroundPlane")
    plane.CreateAxisAttr("Z")
    UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
    return root.GetPrim()


def add_box(stage: Any, path: str, size: Numbers, at: Numbers) -> None:
    """A solid box; size and centre [m]."""
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(Gf.Vec3d(*map(float, at)))
    cube.AddScaleOp().Set(Gf.Vec3f(*map(float, size)))
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())


def make_body(prim: Any, mass: float, inertia: Numbers = ()) -> None:
    """Lets physics move a prim; mass [kg], inertia about its axes [kg m2], if not that of its shapes."""
    UsdPhysics.RigidBodyAPI.Apply(prim)
    api = UsdPhysics.MassAPI.Apply(prim)
    api.CreateMassAttr(mass)
    if inertia:
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(*inertia))
        api.CreateCenterOfMassAttr(Gf.Vec3f(0))


def frame_at(at: Numbers, axis: Numbers, degrees: float) -> Any:
    """A frame in its parent's: turned about an axis, then moved [m]; row vectors."""
    turn = Gf.Rotation(Gf.Vec3d(*map(float, axis)), degrees)
    return Gf.Matrix4d().SetTransform(turn, Gf.Vec3d(*map(float, at)))


def join(joint: Any, parent: str, child: str, frame: Any) -> None:
    """Joins two bodies; frame: the child's in the parent's."""
    joint.CreateBody0Rel().SetTargets([parent])
    joint.CreateBody1Rel().SetTargets([child])
    joint.CreateLocalPos0Attr(Gf.Vec3f(frame.ExtractTranslation()))
    joint.CreateLocalRot0Attr(Gf.Quatf(frame.ExtractRotationQuat()))
    joint.CreateLocalPos1Attr(Gf.Vec3f(0))
    joint.CreateLocalRot1Attr(Gf.Quatf(1))


def add_drive(joint: Any, kind: str, stiffness: float, damping: float, force: float, target: float = 0.0) -> None:
    """Gives a joint a drive of the kind "angular" or "linear"; numbers in degrees, metres, newtons."""
    drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), kind)
    drive.CreateStiffnessAttr(stiffness)
    drive.CreateDampingAttr(damping)
    drive.CreateMaxForceAttr(force)
    drive.CreateTargetPositionAttr(target)
