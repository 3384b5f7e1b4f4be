"""Holonomic drive: a body with omni or mecanum wheels moves in any direction without turning first."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, NodeError, node_type
from graph.sim.scene.prim_paths import prim_at

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

ONCE = "read at the first compute after play"
NO_LIMIT = 100000
NEAR = 0.005
"""Factors that differ from 1 by less are not told."""

RADIUS, ANGLE = "isaacmecanumwheel:radius", "isaacmecanumwheel:angle"
"""Attributes of a wheel's joint: radius [m], and angle [deg] from the axle to the driving direction."""

AXES = {"X": [1.0, 0.0, 0.0], "Y": [0.0, 1.0, 0.0], "Z": [0.0, 0.0, 1.0]}


@dataclass(frozen=True, slots=True)
class Platform:
    """Wheel speeds per speed of the body, (n, 3), and the limits of body and wheels."""

    wheels: Floats
    max_linear: float = math.inf
    max_angular: float = math.inf
    max_wheel: float = math.inf
    factors: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Speed of the rolling body per wanted speed, along x and y, and round; see `body_factors`."""

    def speeds(self, forward: float, sideways: float, turning: float) -> Floats:
        """(n,) wheel speeds [rad/s] for the speeds of the body [m/s, m/s, rad/s].

        Speeds beyond a limit are scaled down together: the body's two linear ones, then all wheels.
        """
        import numpy as np

        linear = math.hypot(forward, sideways)
        share = self.max_linear / linear if linear > self.max_linear else 1.0
        turning = min(max(turning, -self.max_angular), self.max_angular)
        out: Floats = self.wheels @ np.array([forward * share, sideways * share, turning])
        largest = float(np.abs(out).max(initial=0.0))
        return out * (self.max_wheel / largest) if largest > self.max_wheel else out


def drive_directions(orientations: Floats, roller_angles: Floats, axis: Floats, up: Floats) -> Floats:
    """(n, 3) unit directions in which wheels drive: their axles, turned by the roller angles [deg] about `up`.

    orientations (n, 4): w, x, y, z of the wheel joints in the body; axis: the axle in the joints' frames.
    """
    import numpy as np

    from graph.sim.transforms import rotation_matrices

    normal = up / np.linalg.norm(up)
    unit = orientations / np.linalg.norm(orientations, axis=1, keepdims=True)
    axles = rotation_matrices(unit) @ (axis / np.linalg.norm(axis))
    angles = np.radians(roller_angles)[:, None]
    along = normal * (axles @ normal)[:, None] * (1 - np.cos(angles))
    out: Floats = axles * np.cos(angles) + np.cross(normal, axles) * np.sin(angles) + along
    return out


def wheel_matrix(radii: Floats, positions: Floats, directions: Floats) -> Floats:
    """(n, 3) wheel speeds per speed of the body, by the original's rule.

    The sum of radius x speed x direction over the wheels is the body's velocity along x and y; the sum of its cross
    products with the wheels' positions (direction x position) is the body's rotation. Of all solutions, the one with
    the least sum of radius x speed^2 is taken. Raises ValueError if the wheels cannot drive in all three ways.
    """
    import numpy as np

    drives = directions * radii[:, None]
    ways = np.stack([drives[:, 0], drives[:, 1], drives[:, 0] * positions[:, 1] - drives[:, 1] * positions[:, 0]])
    if np.linalg.matrix_rank(ways) < 3:
        raise ValueError("the wheels cannot drive forward, sideways and round independently")
    weighted = ways.T / radii[:, None]
    out: Floats = weighted @ np.linalg.inv(ways @ weighted)
    return out


def body_factors(
    wheels: Floats, radii: Floats, positions: Floats, directions: Floats, rolling: Floats
) -> tuple[float, float, float]:
    """How much of the wanted speeds along x and y, and round, a body has whose wheels roll without slip.

    A wheel's rollers leave only its drive direction d to the ground: d . (v + w x p) = radius x speed x d . t, with
    `rolling` t (n, 3), where the wheel rolls. Solved for v and w by least squares; their senses are not told.
    """
    import numpy as np

    turning = positions[:, 0] * directions[:, 1] - positions[:, 1] * directions[:, 0]
    held = np.stack([directions[:, 0], directions[:, 1], turning], axis=1)
    pushed = (radii * (directions * rolling).sum(axis=1))[:, None] * wheels
    moved = np.abs(np.diag(np.linalg.pinv(held) @ pushed)).tolist()
    return moved[0], moved[1], moved[2]


@dataclass(slots=True)
class _Driving:
    platform: Platform | None = None

    def explained(self, db: Database) -> Iterator[tuple[str, str]]:
        """Code and message for `graph explain`: the speeds that the body has, if they are not the wanted ones."""
        try:
            along, across, turn = (self.platform or _read(db)).factors
        except NodeError:  # the run reports it
            return
        linear, angular = abs(db.inputs.linearGain), abs(db.inputs.angularGain)
        moved = along * linear, across * linear, turn * angular
        if all(abs(one - 1) < NEAR for one in moved):
            return
        message = "with these wheels the body moves at {:.3f} of inputVelocity along x, {:.3f} along y, and turns at "
        message += "{:.3f} of it (the rule of the original)"
        if abs(along - across) < NEAR * along and turn:
            message += f"; linearGain {1 / along:.4g} and angularGain {1 / turn:.4g} make them 1"
        yield "holonomic-factors", message.format(*moved)


@node_type(
    "isaacsim.robot.wheeled_robots.HolonomicController",
    version=2,
    inputs={
        "execIn": Attribute("execution", "computes the wheel speeds"),
        "wheelRadius": Attribute("double[]", f"radius of each wheel, or one for all; {ONCE}", unit="m"),
        "wheelPositions": Attribute("double[3][]", f"position of each wheel in the body; {ONCE}", unit="m"),
        "wheelOrientations": Attribute(
            "double[4][]", f"orientation of each wheel's joint in the body, quaternion w, x, y, z; {ONCE}"
        ),
        "mecanumAngles": Attribute(
            "double[]", f"angle from each wheel's axle to where it drives, or one for all; {ONCE}", unit="deg"
        ),
        "wheelAxis": Attribute("double[3]", f"axle in the frame of a wheel's joint; {ONCE}", default=[1.0, 0.0, 0.0]),
        "upAxis": Attribute("double[3]", f"up axis of the body; {ONCE}", default=[0.0, 0.0, 1.0]),
        "inputVelocity": Attribute(
            "double[3]",
            "wanted speed along x and y, and round, times the factors of the original's rule",
            unit="m/s, m/s, rad/s",
            role="command",
        ),
        "maxLinearSpeed": Attribute(
            "double", f"limit of the linear speed; {ONCE}", default=NO_LIMIT, optional=True, unit="m/s"
        ),
        "maxAngularSpeed": Attribute(
            "double", f"limit of the turning speed; {ONCE}", default=NO_LIMIT, optional=True, unit="rad/s"
        ),
        "maxWheelSpeed": Attribute(
            "double", f"limit of each wheel's speed; {ONCE}", default=NO_LIMIT, optional=True, unit="rad/s"
        ),
        "linearGain": Attribute("double", "factor of the linear speed", default=1),
        "angularGain": Attribute("double", "factor of the turning speed", default=1),
    },
    outputs={"jointVelocityCommand": Attribute("double[]", "speed of each wheel", unit="rad/s")},
    memory=_Driving,
)
def holonomic_controller(db: Database) -> None:
    """Compute wheel speeds by the original's rule, which does not give the body the speed that inputVelocity names.

    It adds up the wheels' drives without the geometry of rolling. Three omniwheels move the body at 2/3 of the wanted
    speed, four mecanum wheels of 45 degrees at 0.354 of it; n omniwheels at d metres from the middle turn it at
    1 / (n d^2) times the wanted rate, three at 0.5 m at 1.333. linearGain and angularGain make up for it.
    """
    inputs, memory = db.inputs, db.memory
    platform = memory.platform
    if platform is None:
        platform = memory.platform = _read(db)
    forward, sideways, turning = (float(part) for part in inputs.inputVelocity)
    linear, angular = inputs.linearGain, inputs.angularGain
    db.outputs.jointVelocityCommand = platform.speeds(forward * linear, sideways * linear, turning * angular)


def _read(db: Database) -> Platform:
    import numpy as np

    inputs = db.inputs
    positions = np.array(inputs.wheelPositions, dtype=np.float64).reshape(-1, 3)
    orientations = np.array(inputs.wheelOrientations, dtype=np.float64).reshape(-1, 4)
    count = len(positions)
    if len(orientations) != count or not count:
        db.lack(f"wheelPositions has {count} and wheelOrientations {len(orientations)} entries; give one per wheel")
    numbers = []
    for name in ("wheelRadius", "mecanumAngles"):
        values = np.array(getattr(inputs, name), dtype=np.float64)
        if len(values) not in (1, count):
            db.fail(f"{name} has {len(values)} entries for {count} wheels; give one per wheel, or one for all")
        numbers.append(np.broadcast_to(values, (count,)))
    radii, angles = numbers
    if not (np.isfinite(radii).all() and (radii > 0).all()):
        db.fail("wheelRadius has an entry that is not a positive length")
    vectors = (orientations, inputs.wheelAxis[None], inputs.upAxis[None])
    if not all((np.linalg.norm(each, axis=1) > 0).all() for each in vectors):
        db.fail("wheelOrientations, wheelAxis and upAxis must not be zero")
    directions = drive_directions(orientations, angles, inputs.wheelAxis, inputs.upAxis)
    try:
        wheels = wheel_matrix(radii, positions, directions)
    except ValueError as error:
        db.fail(f"{error}; see wheelPositions, wheelOrientations and mecanumAngles")
    up = inputs.upAxis / np.linalg.norm(inputs.upAxis)
    rolling = np.cross(drive_directions(orientations, np.zeros(count), inputs.wheelAxis, up), up)
    factors = body_factors(wheels, radii, positions, directions, rolling)
    return Platform(wheels, inputs.maxLinearSpeed, inputs.maxAngularSpeed, inputs.maxWheelSpeed, factors)


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
    inputs, outputs, stage = db.inputs, db.outputs, db.app.stage
    if inputs.usePath:
        robot, center = inputs.robotPrimPath, inputs.comPrimPath
    else:
        robot, center = (str(targets[0]) if targets else "" for targets in (inputs.robotPrim, inputs.comPrim))
    for path in (robot, center or robot):
        if not path or not prim_at(stage, path):
            db.lack(f"there is no prim {path} on the stage" if path else "no robot; set robotPrim")
    try:
        found = wheels_of(stage, robot, center or robot)
    except ValueError as error:
        db.fail(str(error))
    if found is None:
        db.warn("wheels-missing", f"{robot} has no wheels: give their revolute joints {RADIUS} and {ANGLE}")
        return False
    for name, value in found.items():
        setattr(outputs, name, value)
    return True


def wheels_of(stage: Any, robot: str, center: str) -> dict[str, Any] | None:
    """The outputs of HolonomicRobotUsdSetup by name; None for a robot without wheels.

    Raises ValueError for a wheel without its attributes, and for a prim with them that is another kind of joint.
    """
    from graph.sim.usd import Usd, UsdGeom, UsdPhysics

    prims = Usd.PrimRange(stage.GetPrimAtPath(robot), Usd.TraverseInstanceProxies())
    joints = [UsdPhysics.RevoluteJoint(prim) for prim in prims if prim.HasAttribute(ANGLE)]
    if not joints:
        return None
    if not all(joints):
        raise ValueError(f"a prim below {robot} has {ANGLE} and is not a revolute joint; give it to the wheels' joints")
    positions, orientations = wheel_frames(stage, center, joints)
    return {
        "wheelRadius": [_number(joint, RADIUS) for joint in joints],
        "mecanumAngles": [_number(joint, ANGLE) for joint in joints],
        "wheelPositions": positions,
        "wheelOrientations": orientations,
        "wheelAxis": AXES[str(joints[-1].GetAxisAttr().Get())],
        "upAxis": AXES[str(UsdGeom.GetStageUpAxis(stage))],
        "wheelDofNames": [joint.GetPrim().GetName() for joint in joints],
    }


def _number(joint: Any, name: str) -> float:
    value = joint.GetPrim().GetAttribute(name).Get()
    if value is None:
        raise ValueError(f"{joint.GetPath()} has no {name}; author it")
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
