"""The simulation clock as a ROS 2 topic."""

from __future__ import annotations

from functools import partial
from typing import Any

from graph.node import Attribute, Database, node_type

from .messages import CLOCK, clock
from .publishing import Publisher, check_names, publisher_inputs, publishes


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishClock",
    version=1,
    check=check_names,
    inputs={
        "execIn": Attribute("execution", "publishes the time"),
        **publisher_inputs("clock"),
        "timeStamp": Attribute("double", "the time to publish", default=0.0, unit="s", role="stamp"),
    },
    memory=partial(Publisher, CLOCK),
)
@publishes
def publish_clock(db: Database, nanoseconds: int) -> Any:
    """Publish `rosgraph_msgs/Clock`; a time read from one of the App's clocks is published to the exact nanosecond."""
    return clock(nanoseconds)
