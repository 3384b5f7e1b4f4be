"""Functions that make small ROS 2 messages and message parts; stamps are whole nanoseconds."""

from __future__ import annotations

from collections.abc import Iterable
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
    return _type("builtin_interfaces/msg/Time")(seconds, rest)


def header(nanoseconds: int, frame_id: str) -> Any:
    """`std_msgs/Header`."""
    return _type("std_msgs/msg/Header")(stamp(nanoseconds), frame_id)


def clock(nanoseconds: int) -> Any:
    """`rosgraph_msgs/Clock`."""
    return _type(CLOCK)(stamp(nanoseconds))


def publish_transforms(db: Database, topic: str, poses: Iterable[FrameTransform], nanoseconds: int) -> None:
    """Publishes a node's transforms as `tf2_msgs/TFMessage`.

    Those of other nodes with the same topic, quality and stamp join it, as in newer releases of Isaac Sim, unless
    /tickgraph/mergeTransforms is off.
    """
    bus, message = db.app.bus, transforms(poses, nanoseconds)
    if db.app.settings.get(keys.MERGE_TRANSFORMS):
        bus.gather(topic, TRANSFORMS, message.transforms, _type(TRANSFORMS), nanoseconds, db.memory.quality)
    else:
        bus.publish(topic, TRANSFORMS, message, nanoseconds)


def transforms(poses: Iterable[FrameTransform], nanoseconds: int) -> Any:
    """`tf2_msgs/TFMessage` with one stamp for all its transforms."""
    stamped, transform = _type("geometry_msgs/msg/TransformStamped"), _type("geometry_msgs/msg/Transform")
    header_type, time = _type("std_msgs/msg/Header"), stamp(nanoseconds)
    vector, quaternion = _type("geometry_msgs/msg/Vector3"), _type("geometry_msgs/msg/Quaternion")
    return _type(TRANSFORMS)(
        [
            stamped(
                header_type(time, pose.parent),
                pose.child,
                transform(vector(*map(float, pose.translation)), quaternion(*map(float, pose.rotation))),
            )
            for pose in poses
        ]
    )


@cache
def _type(name: str) -> Any:
    from graph.sim.messages.ros_types import message_type

    return message_type(name)
