"""UCX publishers: the messages of their ROS 2 counterparts, on the topic /ucx/port_P/tag_T."""

from __future__ import annotations

from functools import partial
from typing import Any

from graph.node import Attribute, Database, node_type
from nodes.isaac.clocks import stamp_ns
from nodes.ros2.image_messages import IMAGE
from nodes.ros2.images import CUDA_DEVICE, DATA_PTR, image_of
from nodes.ros2.messages import CLOCK, clock
from nodes.ros2.motion import INERTIAL, POSE_AND_VELOCITIES, imu_of
from nodes.ros2.publishing import Publisher
from nodes.ros2.robot_messages import IMU, JOINT_STATE, ODOMETRY, joint_state, odometry

from .transport import SENT, TIME_STAMP, endpoint_inputs, listened_topic


@node_type(
    "isaacsim.ucx.nodes.UCXPublishClock",
    version=1,
    inputs={**endpoint_inputs(50008, 2985021151), "timeStamp": TIME_STAMP},
    outputs={"execOut": SENT},
    memory=partial(Publisher, CLOCK),
)
def publish_clock(db: Database) -> bool:
    """Send the time, as `rosgraph_msgs/Clock`."""
    topic = listened_topic(db)
    if topic is None:
        return False
    nanoseconds = stamp_ns(db.app, db.inputs.timeStamp)
    return _send(db, topic, CLOCK, clock(nanoseconds), nanoseconds)


@node_type(
    "isaacsim.ucx.nodes.UCXPublishJointState",
    version=1,
    inputs={
        **endpoint_inputs(50008, 3806437495),
        "timeStamp": TIME_STAMP,
        "jointPositions": Attribute("double[]", "positions, one per joint", default=[], unit="rad or m"),
        "jointVelocities": Attribute("double[]", "speeds, one per joint", default=[], unit="rad/s or m/s"),
        "jointEfforts": Attribute("double[]", "efforts, one per joint", default=[], unit="N m or N"),
    },
    outputs={"execOut": SENT},
    memory=partial(Publisher, JOINT_STATE),
)
def publish_joint_state(db: Database) -> bool:
    """Send joint values, as `sensor_msgs/JointState` without names."""
    topic = listened_topic(db)
    if topic is None:
        return False
    inputs = db.inputs
    nanoseconds = stamp_ns(db.app, inputs.timeStamp)
    message = joint_state(nanoseconds, [], inputs.jointPositions, inputs.jointVelocities, inputs.jointEfforts)
    return _send(db, topic, JOINT_STATE, message, nanoseconds)


@node_type(
    "isaacsim.ucx.nodes.UCXPublishOdometry",
    version=1,
    inputs={
        **endpoint_inputs(13337, 7),
        "timeStamp": TIME_STAMP,
        **POSE_AND_VELOCITIES,
    },
    outputs={"execOut": SENT},
    memory=partial(Publisher, ODOMETRY),
)
def publish_odometry(db: Database) -> bool:
    """Send a pose and velocities, as `nav_msgs/Odometry` in frame odom of base_link."""
    topic = listened_topic(db)
    if topic is None:
        return False
    inputs = db.inputs
    nanoseconds = stamp_ns(db.app, inputs.timeStamp)
    pose, motion = (inputs.position, inputs.orientation), (inputs.linearVelocity, inputs.angularVelocity)
    message = odometry(nanoseconds, ("odom", "base_link"), *pose, *motion)
    return _send(db, topic, ODOMETRY, message, nanoseconds)


@node_type(
    "isaacsim.ucx.nodes.UCXPublishImu",
    version=1,
    inputs={
        **endpoint_inputs(13337, 2),
        "timeStamp": TIME_STAMP,
        "frameId": Attribute("string", "frame of the message's header", default="sim_imu", role="frame"),
        **INERTIAL,
    },
    outputs={"execOut": SENT},
    memory=partial(Publisher, IMU),
)
def publish_imu(db: Database) -> bool:
    """Send inertial readings, as `sensor_msgs/Imu`."""
    topic = listened_topic(db)
    if topic is None:
        return False
    nanoseconds = stamp_ns(db.app, db.inputs.timeStamp)
    return _send(db, topic, IMU, imu_of(db, nanoseconds), nanoseconds)


@node_type(
    "isaacsim.ucx.nodes.UCXPublishImage",
    version=1,
    inputs={
        **endpoint_inputs(13337, 10, timeout=False),
        "timeStamp": TIME_STAMP,
        "data": Attribute("uchar[]", "pixels, rows from the top", default=[], optional=True),
        "width": Attribute("uint", "pixels in a row", default=0, optional=True, unit="px"),
        "height": Attribute("uint", "rows of pixels", default=0, optional=True, unit="px"),
        "encoding": Attribute(
            "token",
            "what a pixel is: bytes for the colours, or a depth [m]",
            default="rgb8",
            optional=True,
            allowed_tokens=("rgb8", "rgba8", "bgra8", "32FC1"),
        ),
        "dataPtr": DATA_PTR,
        "cudaDeviceIndex": CUDA_DEVICE,
        "bufferSize": Attribute("uint", "size of dataPtr; not needed, the handle knows", default=0, unit="bytes"),
        "format": Attribute("uint64", "pixel format of dataPtr; not needed, encoding says it", default=0),
        "sendCudaBuffer": Attribute("bool", "leave pixels on the device; here they are in host memory", default=True),
    },
    memory=partial(Publisher, IMAGE),
)
def publish_image(db: Database) -> bool:
    """Send an image, as `sensor_msgs/Image`; without pixels (before the first frame) nothing is sent."""
    topic = listened_topic(db)
    if topic is None:
        return False
    nanoseconds = stamp_ns(db.app, db.inputs.timeStamp)
    message = image_of(db, nanoseconds, "")
    if message is None:
        return False
    db.app.bus.publish(topic, IMAGE, message, nanoseconds)
    return True


def _send(db: Database, topic: str, type_name: str, message: Any, nanoseconds: int) -> bool:
    db.app.bus.publish(topic, type_name, message, nanoseconds)
    db.fire("execOut")
    return True
