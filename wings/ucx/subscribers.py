"""UCX subscribers: the messages of their ROS 2 counterparts, from the topic /ucx/port_P/tag_T."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type
from nodes.ros2.robot_messages import JOINT_STATE
from nodes.ros2.subscribing import EXEC_OUT, Subscriber, seconds, take, unsubscribe

from .transport import endpoint_inputs, topic_of

QUEUE = 10


@node_type(
    "isaacsim.ucx.nodes.UCXSubscribeJointCommand",
    version=1,
    inputs=endpoint_inputs(50008, 987171027),
    outputs={
        "execOut": EXEC_OUT,
        "timeStamp": Attribute("double", "stamp of the message", default=0.0, unit="s"),
        "positionCommand": Attribute("double[]", "wanted positions, one per joint, or none", unit="rad or m"),
        "velocityCommand": Attribute("double[]", "wanted speeds, one per joint, or none", unit="rad/s or m/s"),
        "effortCommand": Attribute("double[]", "wanted efforts, one per joint, or none", unit="N m or N"),
    },
    memory=Subscriber,
    release=unsubscribe,
)
def subscribe_joint_command(db: Database) -> bool:
    """Receive joint commands, as `sensor_msgs/JointState`: the next message, if any; at most ten wait."""
    message = take(db, JOINT_STATE, lambda: topic_of(db), lambda: QUEUE)
    if message is None:
        return False
    outputs = db.outputs
    outputs.timeStamp = seconds(message.header.stamp)
    outputs.positionCommand = message.position
    outputs.velocityCommand = message.velocity
    outputs.effortCommand = message.effort
    db.fire("execOut")
    return True
