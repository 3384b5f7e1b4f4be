"""Subscribers of commands: velocity, joints, Ackermann steering, and the clock."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, node_type

from .messages import CLOCK
from .publishing import check_names
from .robot_messages import ACKERMANN, JOINT_STATE, TWIST
from .subscribing import EXEC_OUT, Subscriber, receives, seconds, subscriber_inputs, unsubscribe


@node_type(
    "isaacsim.ros2.bridge.ROS2SubscribeTwist",
    version=1,
    check=check_names,
    inputs=subscriber_inputs("cmd_vel"),
    outputs={
        "execOut": EXEC_OUT,
        "linearVelocity": Attribute("vectord[3]", "linear velocity", default=[0.0, 0.0, 0.0], unit="m/s"),
        "angularVelocity": Attribute("vectord[3]", "angular velocity", default=[0.0, 0.0, 0.0], unit="rad/s"),
    },
    memory=Subscriber,
    release=unsubscribe,
)
@receives(TWIST)
def subscribe_twist(outputs: Any, message: Any) -> None:
    """Receive `geometry_msgs/Twist`: the next message of the topic, if any."""
    linear, angular = message.linear, message.angular
    outputs.linearVelocity = (linear.x, linear.y, linear.z)
    outputs.angularVelocity = (angular.x, angular.y, angular.z)


@node_type(
    "isaacsim.ros2.bridge.ROS2SubscribeJointState",
    version=2,
    check=check_names,
    inputs=subscriber_inputs("joint_command"),
    outputs={
        "execOut": EXEC_OUT,
        "timeStamp": Attribute("double", "stamp of the message", default=0.0, unit="s"),
        "jointNames": Attribute("token[]", "the commanded joints"),
        "positionCommand": Attribute("double[]", "wanted positions, one per joint, or none", unit="rad or m"),
        "velocityCommand": Attribute("double[]", "wanted speeds, one per joint, or none", unit="rad/s or m/s"),
        "effortCommand": Attribute("double[]", "wanted efforts, one per joint, or none", unit="N m or N"),
    },
    memory=Subscriber,
    release=unsubscribe,
)
@receives(JOINT_STATE)
def subscribe_joint_state(outputs: Any, message: Any) -> None:
    """Receive `sensor_msgs/JointState` as a command: the next message of the topic, if any.

    Values are passed on unchanged, in rad and m, whatever the units of the stage.
    """
    outputs.timeStamp = seconds(message.header.stamp)
    outputs.jointNames = list(message.name)
    outputs.positionCommand = message.position
    outputs.velocityCommand = message.velocity
    outputs.effortCommand = message.effort


@node_type(
    "isaacsim.ros2.bridge.ROS2SubscribeClock",
    version=1,
    check=check_names,
    inputs=subscriber_inputs("clock"),
    outputs={"execOut": EXEC_OUT, "timeStamp": Attribute("double", "the time received", unit="s")},
    memory=Subscriber,
    release=unsubscribe,
)
@receives(CLOCK)
def subscribe_clock(outputs: Any, message: Any) -> None:
    """Receive `rosgraph_msgs/Clock`: the next message of the topic, if any."""
    outputs.timeStamp = seconds(message.clock)


@node_type(
    "isaacsim.ros2.bridge.ROS2SubscribeAckermannDrive",
    version=1,
    check=check_names,
    inputs=subscriber_inputs("ackermann_cmd"),
    outputs={
        "execOut": EXEC_OUT,
        "frameId": Attribute("string", "frame of the message's header", default=""),
        "timeStamp": Attribute("double", "stamp of the message", default=0, unit="s"),
        "steeringAngle": Attribute("double", "angle of the virtual middle wheel", default=0.0, unit="rad"),
        "steeringAngleVelocity": Attribute("double", "rate of that angle; 0 is at once", default=0.0, unit="rad/s"),
        "speed": Attribute("double", "forward speed", default=0.0, unit="m/s"),
        "acceleration": Attribute("double", "change of speed; 0 is at once", default=0.0, unit="m/s^2"),
        "jerk": Attribute("double", "change of acceleration; 0 is at once", default=0.0, unit="m/s^3"),
    },
    memory=Subscriber,
    release=unsubscribe,
)
@receives(ACKERMANN)
def subscribe_ackermann_drive(outputs: Any, message: Any) -> None:
    """Receive `ackermann_msgs/AckermannDriveStamped`: the next message of the topic, if any."""
    drive = message.drive
    outputs.frameId = message.header.frame_id
    outputs.timeStamp = seconds(message.header.stamp)
    outputs.steeringAngle, outputs.steeringAngleVelocity = drive.steering_angle, drive.steering_angle_velocity
    outputs.speed, outputs.acceleration, outputs.jerk = drive.speed, drive.acceleration, drive.jerk
