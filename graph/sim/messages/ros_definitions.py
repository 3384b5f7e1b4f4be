"""Interface definitions beside the common ROS 2 packages: those that this project's nodes send, and installed ones.

A service `pkg/srv/Name` is two message types, `pkg/srv/Name_Request` and `pkg/srv/Name_Response`, as in ROS 2 itself.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from graph.base.inputs import start_of

SEARCH_VARIABLE = "AMENT_PREFIX_PATH"
"""Folders of installed ROS 2 packages: `<folder>/share/<package>/<msg or srv>/<Name>.<msg or srv>`."""

_MOST_BYTES = 200_000

MESSAGES = {
    "ackermann_msgs/msg/AckermannDrive": """
        float32 steering_angle
        float32 steering_angle_velocity
        float32 speed
        float32 acceleration
        float32 jerk""",
    "ackermann_msgs/msg/AckermannDriveStamped": """
        std_msgs/Header header
        ackermann_msgs/AckermannDrive drive""",
    "vision_msgs/msg/Point2D": "float64 x\nfloat64 y",
    "vision_msgs/msg/Pose2D": "vision_msgs/Point2D position\nfloat64 theta",
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score",
    "vision_msgs/msg/ObjectHypothesisWithPose": """
        vision_msgs/ObjectHypothesis hypothesis
        geometry_msgs/PoseWithCovariance pose""",
    "vision_msgs/msg/BoundingBox2D": "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y",
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size",
    "vision_msgs/msg/Detection2D": """
        std_msgs/Header header
        vision_msgs/ObjectHypothesisWithPose[] results
        vision_msgs/BoundingBox2D bbox
        string id""",
    "vision_msgs/msg/Detection2DArray": "std_msgs/Header header\nvision_msgs/Detection2D[] detections",
    "vision_msgs/msg/Detection3D": """
        std_msgs/Header header
        vision_msgs/ObjectHypothesisWithPose[] results
        vision_msgs/BoundingBox3D bbox
        string id""",
    "vision_msgs/msg/Detection3DArray": "std_msgs/Header header\nvision_msgs/Detection3D[] detections",
}
"""Type name to definition."""

SERVICES = {
    "example_interfaces/srv/AddTwoInts": "int64 a\nint64 b\n---\nint64 sum",
    "std_srvs/srv/Empty": "---",
    "std_srvs/srv/SetBool": "bool data\n---\nbool success\nstring message",
    "std_srvs/srv/Trigger": "---\nbool success\nstring message",
    "nav_msgs/srv/GetMap": "---\nnav_msgs/OccupancyGrid map",
    "sensor_msgs/srv/SetCameraInfo": """
        sensor_msgs/CameraInfo camera_info
        ---
        bool success
        string status_message""",
    "isaac_ros2_messages/srv/GetPrims": """
        string path
        ---
        string[] paths
        string[] types
        bool success
        string message""",
    "isaac_ros2_messages/srv/GetPrimAttributes": """
        string path
        ---
        string[] names
        string[] displays
        string[] types
        bool success
        string message""",
    "isaac_ros2_messages/srv/GetPrimAttribute": """
        string path
        string attribute
        ---
        string value
        string type
        bool success
        string message""",
    "isaac_ros2_messages/srv/SetPrimAttribute": """
        string path
        string attribute
        string value
        ---
        bool success
        string message""",
}
"""Service name to definition: request, a line of dashes, response."""


def shipped() -> Iterator[tuple[str, str]]:
    """(message type, definition) of everything above."""
    yield from MESSAGES.items()
    for name, text in SERVICES.items():
        yield from service_parts(name, text)


def service_parts(name: str, text: str) -> list[tuple[str, str]]:
    """The two message types of a service definition. Raises ValueError if the line of dashes is missing."""
    lines = [line.strip() for line in text.strip().splitlines()]
    if lines.count("---") != 1:
        raise ValueError(f"{name}: a service definition has one line ---, between request and response")
    cut = lines.index("---")
    return [(f"{name}_Request", "\n".join(lines[:cut])), (f"{name}_Response", "\n".join(lines[cut + 1 :]))]


def installed(type_name: str) -> list[tuple[str, str]]:
    """(message type, definition) of a type that an installed ROS 2 package defines, if any."""
    package, kind, name = type_name.split("/")
    stem = name.removesuffix("_Request").removesuffix("_Response") if kind == "srv" else name
    if not all(part.isidentifier() for part in (package, kind, stem)):
        return []
    for folder in filter(None, os.environ.get(SEARCH_VARIABLE, "").split(os.pathsep)):
        path = Path(folder) / "share" / package / kind / f"{stem}.{kind}"
        try:
            data = start_of(path, _MOST_BYTES + 1)
            if len(data) <= _MOST_BYTES:
                text = data.decode("utf-8")
                return service_parts(f"{package}/srv/{stem}", text) if kind == "srv" else [(type_name, text)]
        except (OSError, ValueError):
            continue
    return []
