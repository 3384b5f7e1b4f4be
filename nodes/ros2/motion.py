"""A robot's motion as ROS 2 topics: odometry, one transform, inertial readings, steering commands."""

from __future__ import annotations

from functools import partial
from typing import Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from nodes.isaac.clocks import stamp_ns
from nodes.isaac.transform_trees import FrameTransform

from .messages import TRANSFORMS, publish_transforms
from .publishing import (
    TIME_STAMP,
    Publisher,
    check_names,
    publisher_inputs,
    publishes,
    stamped_inputs,
    subscribed_topic,
)
from .robot_messages import ACKERMANN, IMU, ODOMETRY, ackermann, imu, odometry

EXEC_IN = Attribute("execution", "publishes")
IDENTITY = [0.0, 0.0, 0.0, 1.0]
ZERO = [0.0, 0.0, 0.0]
POSE_AND_VELOCITIES = {
    "position": Attribute("vectord[3]", "position in the odom frame", default=ZERO, unit="m", role="data"),
    "orientation": Attribute("quatd[4]", "orientation in the odom frame, x, y, z, w", default=IDENTITY, role="data"),
    "linearVelocity": Attribute("vectord[3]", "velocity along the robot's axes", default=ZERO, unit="m/s", role="data"),
    "angularVelocity": Attribute(
        "vectord[3]", "turn rate about the robot's axes", default=ZERO, unit="rad/s", role="data"
    ),
}
"""Inputs of odometry publishers."""
INERTIAL = {
    "publishOrientation": Attribute("bool", "whether orientation is part of the message", default=True),
    "publishLinearAcceleration": Attribute("bool", "whether acceleration is part of the message", default=True),
    "publishAngularVelocity": Attribute("bool", "whether the turn rate is part of the message", default=True),
    "orientation": Attribute("quatd[4]", "orientation, x, y, z, w", default=IDENTITY, optional=True, role="data"),
    "linearAcceleration": Attribute(
        "vectord[3]",
        "proper acceleration along the sensor's axes",
        default=ZERO,
        optional=True,
        unit="m/s^2",
        role="data",
    ),
    "angularVelocity": Attribute(
        "vectord[3]", "turn rate about the sensor's axes", default=ZERO, optional=True, unit="rad/s", role="data"
    ),
}
"""Inputs of IMU publishers."""


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishOdometry",
    version=1,
    check=check_names,
    inputs={
        "execIn": EXEC_IN,
        **publisher_inputs("odom"),
        "odomFrameId": Attribute("string", "frame that the pose is given in", default="odom", role="frame"),
        "chassisFrameId": Attribute(
            "string", "frame of the robot, that velocities are given in", default="base_link", role="frame"
        ),
        "timeStamp": TIME_STAMP,
        **POSE_AND_VELOCITIES,
        "robotFront": Attribute("vectord[3]", "the axis that points ahead", default=[1.0, 0.0, 0.0]),
        "publishRawVelocities": Attribute(
            "bool", "publish velocities as given; if not, along front, left and up", default=False
        ),
    },
    memory=partial(Publisher, ODOMETRY),
)
@publishes
def publish_odometry(db: Database, nanoseconds: int) -> Any:
    """Publish `nav_msgs/Odometry`. Its x axis of motion is robotFront, z the stage's up, y to the left."""
    inputs = db.inputs
    linear, angular = inputs.linearVelocity, inputs.angularVelocity
    if not inputs.publishRawVelocities:
        axes = _body_axes(db)
        linear, angular = axes @ linear, axes @ angular
    frames = (inputs.odomFrameId, inputs.chassisFrameId)
    return odometry(nanoseconds, frames, inputs.position, inputs.orientation, linear, angular)


def _body_axes(db: Database) -> Any:
    """(3, 3) rows: the robot's front, left and up as unit vectors, in the axes of the given velocities."""
    import numpy as np

    from graph.sim.scene.stage_metadata import up_axis

    up = np.array([0.0, 0.0, 1.0] if up_axis(db.app.stage) == "Z" else [0.0, 1.0, 0.0])
    front = np.array(db.inputs.robotFront)
    left = np.cross(up, front)
    length = float(np.linalg.norm(left))
    if not length > 1e-9 * (1 + float(np.linalg.norm(front))):
        db.fail(f"robotFront {front.tolist()} is zero or points up; give the axis that points ahead")
    left = left / length
    return np.stack([np.cross(left, up), left, up])


@dataclass(slots=True)
class _Static(Publisher):
    latched: FrameTransform | None = None


def _frames(db: Database) -> tuple[str, str] | None:
    if db.connected("inputs:parentFrameId") or db.connected("inputs:childFrameId"):
        return None
    return db.inputs.parentFrameId, db.inputs.childFrameId


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishRawTransformTree",
    version=1,
    check=check_names,
    inputs={
        "execIn": EXEC_IN,
        **publisher_inputs("tf"),
        "parentFrameId": Attribute("string", "frame that the transform is given in", default="odom", role="frame"),
        "childFrameId": Attribute("string", "frame that it places", default="base_link", role="frame"),
        "timeStamp": TIME_STAMP,
        "translation": Attribute("vectord[3]", "position in the parent frame", default=ZERO, unit="m"),
        "rotation": Attribute("quatd[4]", "rotation in the parent frame, x, y, z, w", default=IDENTITY),
        "staticPublisher": Attribute(
            "bool", "publish once, and again when it changed, on tf_static where topicName is tf", default=False
        ),
    },
    memory=partial(_Static, TRANSFORMS),
    frames=_frames,
)
def publish_raw_transform_tree(db: Database) -> bool:
    """Publish `tf2_msgs/TFMessage` with the transform of the inputs."""
    inputs, memory = db.inputs, db.memory
    static = inputs.staticPublisher
    topic = subscribed_topic(db, "tf_static" if static and inputs.topicName == "tf" else None, latched=static)
    if topic is None:
        return False
    x, y, z = inputs.translation.tolist()
    qx, qy, qz, qw = inputs.rotation.tolist()
    pose = FrameTransform(inputs.parentFrameId, inputs.childFrameId, (x, y, z), (qx, qy, qz, qw))
    if static:
        if pose == memory.latched:
            return False
        memory.latched = pose
    nanoseconds = stamp_ns(db.app, inputs.timeStamp)
    publish_transforms(db, topic, [pose], nanoseconds)
    return True


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishImu",
    version=1,
    check=check_names,
    inputs={**stamped_inputs("imu", frame_id="sim_imu"), **INERTIAL},
    memory=partial(Publisher, IMU),
)
@publishes
def publish_imu(db: Database, nanoseconds: int) -> Any:
    """Publish `sensor_msgs/Imu`; a reading that is switched off has covariance[0] = -1."""
    return imu_of(db, nanoseconds)


def imu_of(db: Database, nanoseconds: int) -> Any:
    """The message of an IMU publisher's inputs."""
    inputs = db.inputs
    return imu(
        nanoseconds,
        inputs.frameId,
        inputs.orientation if inputs.publishOrientation else None,
        inputs.angularVelocity if inputs.publishAngularVelocity else None,
        inputs.linearAcceleration if inputs.publishLinearAcceleration else None,
    )


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishAckermannDrive",
    version=1,
    check=check_names,
    inputs={
        **stamped_inputs("ackermann_cmd", frame_id=""),
        "timeStamp": Attribute("double", "stamp of the message", default=0, unit="s", role="stamp"),
        "steeringAngle": Attribute("double", "angle of the virtual middle wheel", default=0.0, unit="rad", role="data"),
        "steeringAngleVelocity": Attribute(
            "double", "rate of that angle; 0 is at once", default=0.0, unit="rad/s", role="data"
        ),
        "speed": Attribute("double", "forward speed", default=0.0, unit="m/s", role="data"),
        "acceleration": Attribute("double", "change of speed; 0 is at once", default=0.0, unit="m/s^2", role="data"),
        "jerk": Attribute("double", "change of acceleration; 0 is at once", default=0.0, unit="m/s^3", role="data"),
    },
    memory=partial(Publisher, ACKERMANN),
)
@publishes
def publish_ackermann_drive(db: Database, nanoseconds: int) -> Any:
    """Publish `ackermann_msgs/AckermannDriveStamped`."""
    inputs = db.inputs
    return ackermann(
        nanoseconds,
        inputs.frameId,
        inputs.steeringAngle,
        inputs.steeringAngleVelocity,
        inputs.speed,
        inputs.acceleration,
        inputs.jerk,
    )
