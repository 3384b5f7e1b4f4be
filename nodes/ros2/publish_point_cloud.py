"""A point cloud from buffers, as OgnIsaacExtractRTXSensorPointCloud gives them."""

from __future__ import annotations

from functools import partial
from typing import Any

from graph.node import Attribute, Database, node_type
from nodes.isaac.clocks import stamp_ns

from .point_clouds import POINT_CLOUD, point_cloud
from .publishing import TIME_STAMP, Publisher, check_names, publisher_inputs, subscribed_topic

# Quantity -> stem of its inputs, type and default of its DataType input, defaults of its size input.
_BUFFERS: dict[str, tuple[str, str, Any, dict[str, Any]]] = {
    "Intensity": ("intensity", "float", 0, {"default": 0}),
    "Timestamp": ("timestamp", "uint64", 8, {}),
    "EmitterId": ("emitterId", "uint", 0, {}),
    "ChannelId": ("channelId", "uint", 0, {}),
    "MaterialId": ("materialId", "uint", 0, {}),
    "TickId": ("tickId", "uint", 0, {}),
    "HitNormal": ("hitNormal", "float[3]", [0, 0, 0], {}),
    "Velocity": ("velocity", "float[3]", [0, 0, 0], {}),
    "ObjectId": ("objectId", "uint[]", [0, 0, 0, 0], {}),
    "EchoId": ("echoId", "uchar", 0, {}),
    "TickState": ("tickState", "uchar", 0, {}),
    "RadialVelocityMS": ("radialVelocityMS", "float", 0, {}),
}


def _buffer_inputs() -> dict[str, Attribute]:
    inputs: dict[str, Attribute] = {}
    for quantity, (stem, data_type, default, size) in _BUFFERS.items():
        inputs[f"output{quantity}"] = Attribute("bool", f"whether the message has {quantity}", default=False)
        inputs[f"{stem}Ptr"] = Attribute("uint64", f"handle of the {quantity} buffer; 0 means none", default=0)
        inputs[f"{stem}DataType"] = Attribute(
            data_type, f"stands for the element type of {stem}Ptr; its value means nothing", default=default
        )
        inputs[f"{stem}BufferSize"] = Attribute(
            "uint64", f"size of {stem}Ptr; the handle knows it", unit="bytes", **size
        )
    return inputs


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishPointCloud",
    version=3,
    check=check_names,
    inputs={
        "execIn": Attribute("execution", "publishes the cloud"),
        **publisher_inputs("point_cloud", frame_id="sim_lidar"),
        "timeStamp": TIME_STAMP,
        "dataPtr": Attribute(
            "uint64", "handle of the points, float32 x 3; 0 takes `data`", default=0, unit="m", role="data"
        ),
        "data": Attribute("pointf[3][]", "the points, where dataPtr is 0", default=[], unit="m", role="data"),
        "cudaDeviceIndex": Attribute("int", "must stay -1: buffers are in host memory", default=-1),
        "bufferSize": Attribute("uint", "size of dataPtr; the handle knows it", unit="bytes"),
        **_buffer_inputs(),
    },
    memory=partial(Publisher, POINT_CLOUD),
)
def publish_point_cloud(db: Database) -> bool:
    """Publish `sensor_msgs/PointCloud2`: x, y, z and each quantity whose output flag and handle are both set."""
    inputs = db.inputs
    if inputs.cudaDeviceIndex != -1:
        db.fail(f"input cudaDeviceIndex is {inputs.cudaDeviceIndex}; buffers are in host memory, leave it at -1")
    topic = subscribed_topic(db)
    if topic is None:
        return False
    points = _buffer(db, "dataPtr") if inputs.dataPtr else inputs.data
    values = {
        quantity: _buffer(db, f"{stem}Ptr")
        for quantity, (stem, *_) in _BUFFERS.items()
        if getattr(inputs, f"output{quantity}") and getattr(inputs, f"{stem}Ptr")
    }
    nanoseconds = stamp_ns(db.app, inputs.timeStamp)
    try:
        message = point_cloud(points.reshape(-1, 3), values, nanoseconds, inputs.frameId)
    except ValueError as error:
        db.fail(f"the buffers do not belong together: {error}")
    db.app.bus.publish(topic, POINT_CLOUD, message, nanoseconds)
    return True


def _buffer(db: Database, name: str) -> Any:
    """The array that a handle refers to. Fails the node if the handle is not valid (any more)."""
    import numpy as np

    from sensors.handles import resolve

    array = resolve(getattr(db.inputs, name))
    if not isinstance(array, np.ndarray):
        db.lack(f"input {name} is not a handle of a buffer; connect it to what makes one in the same evaluation")
    return array
