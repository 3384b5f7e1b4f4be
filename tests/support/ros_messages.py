"""Messages of exact content: clocks and point clouds."""

import numpy as np

from graph.sim.messages.ros_types import message_type

CLOCK = "rosgraph_msgs/msg/Clock"
CLOUD = "sensor_msgs/msg/PointCloud2"


def stamp(ns):
    """A time of so many nanoseconds."""
    return message_type("builtin_interfaces/msg/Time")(ns // 10**9, ns % 10**9)


def clock(ns):
    """A CLOCK message."""
    return message_type(CLOCK)(stamp(ns))


def cloud(ns, points):
    """A CLOUD message of so many points of 16 bytes, which count up from 0 to 255 and begin again."""
    header = message_type("std_msgs/msg/Header")(stamp(ns), "lidar")
    field = message_type("sensor_msgs/msg/PointField")("x", 0, 7, 1)
    data = np.arange(points * 16, dtype=np.uint8)
    return message_type(CLOUD)(header, 1, points, [field], False, 16, 16 * points, data, True)
