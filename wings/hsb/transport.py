"""What the nodes of the sensor bridge share: the receiver, which is a topic of the bus."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from graph.node import Attribute, Database, NodeAtLoad, node_type
from nodes.ros2.messages import type_of
from nodes.ros2.publishing import Publisher, subscribed_topic

BYTES = "std_msgs/msg/UInt8MultiArray"
PLANES = ("coe", "linux")
SENT = Attribute("execution", "the frame was sent")


def receiver_inputs(*, tokens: bool) -> dict[str, Attribute]:
    """execIn, address, data plane and sensor; tokens: whether dataPlaneType is a token with choices."""
    plane = (
        Attribute("token", "kind of data plane", default="coe", allowed_tokens=PLANES)
        if tokens
        else Attribute("string", f"kind of data plane: {' or '.join(PLANES)}", default="coe")
    )
    return {
        "execIn": Attribute("execution", "sends a frame"),
        "ipAddress": Attribute("string", "address of the receiver; part of the topic's name", default="127.0.0.1"),
        "dataPlaneType": plane,
        "dataPlaneId": Attribute("uint", "number of the data plane; part of the topic's name", default=0),
        "sensorId": Attribute("uint", "number of the sensor; part of the topic's name", default=0),
    }


def topic_of(db: Database) -> str:
    """The topic of a receiver. Fails the node for an unknown data plane."""
    inputs = db.inputs
    if inputs.dataPlaneType not in PLANES:
        db.fail(f'input dataPlaneType is "{inputs.dataPlaneType}"; use {" or ".join(PLANES)}')
    address = re.sub(r"[^A-Za-z0-9]+", "_", inputs.ipAddress).strip("_")
    if not address:
        db.fail("input ipAddress is empty; give it the address of a receiver")
    plane = f"plane_{inputs.dataPlaneType}_{int(inputs.dataPlaneId)}"
    return f"/hsb/receiver_{address}/{plane}/sensor_{int(inputs.sensorId)}"


def bytes_message(data: Any) -> Any:
    """`std_msgs/UInt8MultiArray` of (n,) uint8."""
    layout = type_of("std_msgs/msg/MultiArrayLayout")([], 0)
    return type_of(BYTES)(layout, data)


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    plane = node.db.inputs.dataPlaneType
    if not node.db.connected("inputs:dataPlaneType") and plane not in PLANES:
        yield "inputs:dataPlaneType", f'dataPlaneType is "{plane}"; use {" or ".join(PLANES)}'


def _publisher() -> Publisher:
    return Publisher(BYTES)


@node_type(
    "isaacsim.hsb.nodes.HSBSend",
    version=1,
    check=_check,
    inputs={
        **receiver_inputs(tokens=False),
        "timeStamp": Attribute("double", "stamp of the frame", default=0.0, unit="s", role="stamp"),
        "data": Attribute("uchar[]", "the frame's bytes", default=[], optional=True),
    },
    outputs={"execOut": SENT},
    memory=_publisher,
)
def hsb_send(db: Database) -> bool:
    """Send raw bytes to a receiver of the Holoscan sensor bridge: a message on the topic of its address and sensor."""
    from nodes.isaac.clocks import stamp_ns

    topic = subscribed_topic(db, topic_of(db))
    if topic is None or not len(db.inputs.data):
        return False
    nanoseconds = stamp_ns(db.app, db.inputs.timeStamp)
    db.app.bus.publish(topic, BYTES, bytes_message(db.inputs.data.copy()), nanoseconds)
    db.fire("execOut")
    return True
