"""ROS 2 message classes, their CDR bytes and their definitions, from rosbags' type store (Humble)."""

from __future__ import annotations

from functools import cache
from typing import Any

from rosbags.typesys import Stores, get_typestore  # noqa: TID253

_STORE = get_typestore(Stores.ROS2_HUMBLE)


def message_type(name: str) -> type[Any]:
    """The dataclass of a message type such as "sensor_msgs/msg/PointCloud2". Raises KeyError if there is none."""
    return _STORE.types[name]


def serialize(message: Any, type_name: str) -> bytes:
    """The message as little-endian CDR."""
    return bytes(_STORE.serialize_cdr(message, type_name))


def deserialize(data: bytes, type_name: str) -> Any:
    """The message that little- or big-endian CDR `data` holds."""
    return _STORE.deserialize_cdr(data, type_name)


@cache
def definition(type_name: str) -> str:
    """The type's definition with those it depends on, as the "ros2msg" schema encoding wants it."""
    return _STORE.generate_msgdef(type_name, ros_version=2)[0]
