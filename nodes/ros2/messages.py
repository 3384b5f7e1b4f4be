"""Functions that make small ROS 2 messages and message parts; stamps are whole nanoseconds."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from graph.base.errors import RunError
from graph.base.exact import NANOSECONDS
from graph.node import Database
from graph.sim import settings as keys
from nodes.isaac.transform_trees import FrameTransform

MOST_SECONDS = 2**31 - 1
"""Seconds of a `builtin_interfaces/Time`, an int32."""
CLOCK = "rosgraph_msgs/msg/Clock"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
STRING = "std_msgs/msg/String"


def stamp(nanoseconds: int) -> Any:
    """`builtin_interfaces/Time` of a count of nanoseconds; also of a negative one (nanosec is 0 ... 999999999).

    Raises RunError beyond 2**31 - 1 s: the message's seconds are int32.
    """
    seconds, rest = divmod(nanoseconds, NANOSECONDS)
    if not -MOST_SECONDS <= seconds <= MOST_SECONDS:
        raise RunError(
            f"{seconds} s is not a time of a ROS 2 message, whose stamps end at 2**31 - 1 s (68 years); stop "
            "and play to restart the clock, or publish nothing"
        )
    return type_of("builtin_interfaces/msg/Time")(seconds, rest)


def header(nanoseconds: int, frame_id: str) -> Any:
    """`std_msgs/Header`."""
    return type_of("std_msgs/msg/Header")(stamp(nanoseconds), frame_id)


def clock(nanoseconds: int) -> Any:
    """`rosgraph_msgs/Clock`."""
    return type_of(CLOCK)(stamp(nanoseconds))


def publish_transforms(db: Database, topic: str, poses: Iterable[FrameTransform], nanoseconds: int) -> None:
    """Publishes a node's transforms as `tf2_msgs/TFMessage`.

    Those of other nodes with the same topic, quality and stamp join it, as in newer releases of Isaac Sim, unless
    /tickgraph/mergeTransforms is off.
    """
    bus, message = db.app.bus, transforms(poses, nanoseconds)
    if db.app.settings.get(keys.MERGE_TRANSFORMS):
        bus.gather(topic, TRANSFORMS, message.transforms, type_of(TRANSFORMS), nanoseconds, db.memory.quality)
    else:
        bus.publish(topic, TRANSFORMS, message, nanoseconds)


def transforms(poses: Iterable[FrameTransform], nanoseconds: int) -> Any:
    """`tf2_msgs/TFMessage` with one stamp for all its transforms."""
    stamped, transform = type_of("geometry_msgs/msg/TransformStamped"), type_of("geometry_msgs/msg/Transform")
    header_type, time = type_of("std_msgs/msg/Header"), stamp(nanoseconds)
    vector, quaternion = type_of("geometry_msgs/msg/Vector3"), type_of("geometry_msgs/msg/Quaternion")
    return type_of(TRANSFORMS)(
        [
            stamped(
                header_type(time, pose.parent),
                pose.child,
                transform(vector(*map(float, pose.translation)), quaternion(*map(float, pose.rotation))),
            )
            for pose in poses
        ]
    )


def stamped_json(content: Mapping[str, Any], nanoseconds: int) -> Any:
    """`std_msgs/String` with JSON: the content and, as `time_stamp`, the stamp."""
    time = stamp(nanoseconds)
    return type_of(STRING)(json.dumps({**content, "time_stamp": {"sec": time.sec, "nanosec": time.nanosec}}))


def class_labels(labels: Mapping[int, Mapping[str, str]], nanoseconds: int) -> Any:
    """`std_msgs/String` with JSON: number of a semantic class -> its labels, and the stamp."""
    return stamped_json({str(number): found for number, found in sorted(labels.items())}, nanoseconds)


def object_id_map(paths: Mapping[int, str], nanoseconds: int) -> Any:
    """`std_msgs/String` with JSON: decimal 128-bit object id -> prim path, and the stamp."""
    labels = {str(number): path for number, path in sorted(paths.items())}
    return stamped_json({"id_to_labels": labels}, nanoseconds)


@cache
def type_of(name: str) -> Any:
    """The class of a message type, such as `std_msgs/msg/String`; the type store is loaded at the first call."""
    from graph.sim.messages.ros_types import message_type

    return message_type(name)
