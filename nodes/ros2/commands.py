"""Subscribers of commands: velocity, joints, Ackermann steering, and the clock."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type

from .messages import CLOCK
from .publishing import check_names
from .robot_messages import ACKERMANN, JOINT_STATE, TWIST
from .subscribing import EXEC_OUT, Subscriber, next_message, seconds, subscriber_inputs, unsubscribe


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
def subscribe_twist(db: Database) -> bool:
    """Receive `geometry_msgs/Twist`: the next message of the topic, if any."""
    message = next_message(db, TWIST)
    if message is None:
        return False
    linear, angular = message.linear, message.angular
    db.outputs.linearVelocity = (linear.x, linear.y, linear.z)
    db.outputs.angularVelocity = (angular.x, angular.y, angular.z)
    db.fire("execOut")
    return True


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
def subscribe_joint_state(db: Database) -> bool:
    """Receive `sensor_msgs/JointState` as a command: the next message of the topic, if any.

    Values are passed on unchanged, in rad and m, whatever the units of the stage.
    """
    message = next_message(db, JOINT_STATE)
    if message is None:
        return False
    outputs = db.outputs
    outputs.timeStamp = seconds(message.header.stamp)
    outputs.jointNames = list(message.name)
    outputs.positionCommand = message.position
    outputs.velocityCommand = message.velocity
    outputs.effortCommand = message.effort
    db.fire("execOut")
    return True


@node_type(
    "isaacsim.ros2.bridge.ROS2SubscribeClock",
    version=1,
    check=check_names,
    inputs=subscriber_inputs("clock"),
    outputs={"execOut": EXEC_OUT, "timeStamp": Attribute("double", "the time received", unit="s")},
    memory=Subscriber,
    release=unsubscribe,
)
def subscribe_clock(db: Database) -> bool:
    """Receive `rosgraph_msgs/Clock`: the next message of the topic, if any."""
    message = next_message(db, CLOCK)
    if message is None:
        return False
    db.outputs.timeStamp = seconds(message.clock)
    db.fire("execOut")
    return True


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
def subscribe_ackermann_drive(db: Database) -> bool:
    """Receive `ackermann_msgs/AckermannDriveStamped`: the next message of the topic, if any."""
    message = next_message(db, ACKERMANN)
    if message is None:
        return False
    outputs, drive = db.outputs, message.drive
    outputs.frameId = message.header.frame_id
    outputs.timeStamp = seconds(message.header.stamp)
    outputs.steeringAngle, outputs.steeringAngleVelocity = drive.steering_angle, drive.steering_angle_velocity
    outputs.speed, outputs.acceleration, outputs.jerk = drive.speed, drive.acceleration, drive.jerk
    db.fire("execOut")
    return True
