"""The simulation clock as a ROS 2 topic."""

from __future__ import annotations

from functools import partial

from graph.node import Attribute, Database, node_type
from nodes.isaac.clocks import stamp_ns

from .messages import CLOCK, clock
from .publishing import Publisher, check_names, publisher_inputs, subscribed_topic


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
def publish_clock(db: Database) -> bool:
    """Publish `rosgraph_msgs/Clock`; a time read from one of the App's clocks is published to the exact nanosecond."""
    topic = subscribed_topic(db)
    if topic is None:
        return False
    nanoseconds = stamp_ns(db.app, db.inputs.timeStamp)
    db.app.bus.publish(topic, CLOCK, clock(nanoseconds), nanoseconds)
    return True
