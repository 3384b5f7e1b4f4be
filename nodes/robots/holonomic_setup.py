"""The wheels of a holonomic robot as its prims describe them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RADIUS, ANGLE = "isaacmecanumwheel:radius", "isaacmecanumwheel:angle"
"""Attributes of a wheel's joint: radius [m], and angle [deg] from the axle to the driving direction."""

AXES = {"X": [1.0, 0.0, 0.0], "Y": [0.0, 1.0, 0.0], "Z": [0.0, 0.0, 1.0]}


@node_type(
    "isaacsim.robot.wheeled_robots.HolonomicRobotUsdSetup",
    version=1,
    inputs={
        "robotPrim": Attribute("target", "the robot; used unless usePath"),
        "comPrim": Attribute("target", "the prim that stands for its centre; none means the robot; unless usePath"),
        "usePath": Attribute("bool", "take the paths instead", default=False),
        "robotPrimPath": Attribute("token", "path of the robot", role="prim"),
        "comPrimPath": Attribute("token", "path of the prim that stands for its centre", role="prim"),
    },
    outputs={
        "wheelRadius": Attribute("double[]", "radius of each wheel", unit="m"),
        "wheelPositions": Attribute("double[3][]", "position of each wheel's joint in the centre's frame", unit="m"),
        "wheelOrientations": Attribute("double[4][]", "orientation of each joint there, quaternion w, x, y, z"),
        "mecanumAngles": Attribute("double[]", "angle from each wheel's axle to where it drives", unit="deg"),
        "wheelAxis": Attribute("double[3]", "axle in the frames of the joints"),
        "upAxis": Attribute("double[3]", "up axis of the stage"),
        "wheelDofNames": Attribute("token[]", "names of the wheels' joints"),
    },
)
def holonomic_robot_usd_setup(db: Database) -> bool:
    """Find the joints below a robot that have isaacmecanumwheel:radius and :angle, with their poses on the stage.

    For a robot without such joints the outputs keep their values, with a warning.
    """
    from graph.sim.usd import Usd, UsdGeom, UsdPhysics

    inputs, outputs, stage = db.inputs, db.outputs, db.app.stage
    if inputs.usePath:
        robot, center = inputs.robotPrimPath, inputs.comPrimPath
    else:
        robot, center = (str(targets[0]) if targets else "" for targets in (inputs.robotPrim, inputs.comPrim))
    for path in (robot, center or robot):
        if not path or not prim_at(stage, path):
            db.lack(f"there is no prim {path} on the stage" if path else "no robot; set robotPrim")
    prims = Usd.PrimRange(stage.GetPrimAtPath(robot), Usd.TraverseInstanceProxies())
    joints = [UsdPhysics.RevoluteJoint(prim) for prim in prims if prim.HasAttribute(ANGLE)]
    if not joints:
        db.warn("wheels-missing", f"{robot} has no wheels: give their revolute joints {RADIUS} and {ANGLE}")
        return False
    if not all(joints):
        db.fail(f"a prim below {robot} has {ANGLE} and is not a revolute joint; give it to the wheels' joints")
    outputs.wheelRadius = [_number(db, joint, RADIUS) for joint in joints]
    outputs.mecanumAngles = [_number(db, joint, ANGLE) for joint in joints]
    outputs.wheelPositions, outputs.wheelOrientations = wheel_frames(stage, center or robot, joints)
    outputs.wheelAxis = AXES[str(joints[-1].GetAxisAttr().Get())]
    outputs.upAxis = AXES[str(UsdGeom.GetStageUpAxis(stage))]
    outputs.wheelDofNames = [joint.GetPrim().GetName() for joint in joints]
    return True


def _number(db: Database, joint: Any, name: str) -> float:
    value = joint.GetPrim().GetAttribute(name).Get()
    if value is None:
        db.fail(f"{joint.GetPath()} has no {name}; author it")
    return float(value)


def wheel_frames(stage: Any, center: str, joints: list[Any]) -> tuple[Floats, Floats]:
    """Positions (n, 3) [m] and orientations (n, 4) w, x, y, z of joints, on their first body, in a prim's frame."""
    import numpy as np

    from graph.sim import transforms
    from graph.sim.usd import EARLIEST, UsdGeom

    xforms = UsdGeom.XformCache(EARLIEST)

    def world(path: Any) -> Floats:
        return transforms.from_usd(xforms.GetLocalToWorldTransform(stage.GetPrimAtPath(path)))

    unit = UsdGeom.GetStageMetersPerUnit(stage)
    to_center = transforms.inverse_rigid(transforms.rigid_part(world(center)))
    positions, orientations = np.empty((len(joints), 3)), np.empty((len(joints), 4))
    for row, joint in enumerate(joints):
        bodies = joint.GetBody0Rel().GetTargets()
        body = world(bodies[0]) if bodies else np.eye(4)
        place = transforms.transformed(body, np.array([joint.GetLocalPos0Attr().Get()], dtype=np.float64))
        positions[row] = transforms.transformed(to_center, place)[0] * unit
        turn = joint.GetLocalRot0Attr().Get()
        local = transforms.rotation_matrices(np.array([turn.GetReal(), *turn.GetImaginary()], dtype=np.float64))
        orientations[row] = transforms.quaternion(to_center[:3, :3] @ transforms.rigid_part(body)[:3, :3] @ local)
    return positions, orientations
