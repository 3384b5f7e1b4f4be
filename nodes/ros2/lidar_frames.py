"""ROS 2 messages from lidar frames."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from graph.base.exact import nanoseconds

from .point_clouds import CLOUD_FIELDS, point_cloud

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sensors.frame import Frame

    from .laser_scans import ScanStyle

SCAN_CHANNELS = frozenset({"azimuth", "distance", "scalar"})
"""What a laser scan needs of a frame."""


def cloud_channels(metadata: Iterable[str]) -> frozenset[str]:
    """What a cloud with these quantities needs of a frame."""
    return frozenset({"xyz", *(CLOUD_FIELDS[name].channel for name in metadata)})


def frame_cloud(frame: Frame, metadata: Iterable[str], nanoseconds: int, frame_id: str) -> Any:
    """`sensor_msgs/PointCloud2` of a frame's points, with those chosen quantities that the frame holds."""
    values = {name: column(frame, name) for name in metadata}
    return point_cloud(frame.xyz, values, nanoseconds, frame_id)


def column(frame: Frame, name: str) -> NDArray[np.generic]:
    """One quantity of `CLOUD_FIELDS` as `point_cloud` takes it; empty where the frame has none."""
    import numpy as np

    channel = CLOUD_FIELDS[name].channel
    if channel not in frame.arrays:
        return np.empty(0)
    array = frame.channel(channel)
    if name == "Timestamp":
        return array.astype(np.int64) + frame.timestamp_ns
    if name == "Time":
        return array.astype(np.int64) + (frame.timestamp_ns - nanoseconds(frame.reference))
    return array


def frame_scan(frame: Frame, nanoseconds: int, frame_id: str, style: ScanStyle) -> Any:
    """`sensor_msgs/LaserScan` of a frame, binned by azimuth whatever the elevations; the last in a beam wins."""
    from sensors.lidar.flat_scan import flat_scan

    from .laser_scans import laser_scan

    flat = flat_scan(frame, check_2d=False)
    return laser_scan(
        flat.ranges,
        flat.intensities,
        start_deg=flat.azimuth_range[0],
        resolution_deg=flat.horizontal_resolution,
        horizontal_fov_deg=flat.horizontal_fov,
        depth_range=flat.depth_range,
        rotation_rate=flat.rotation_rate,
        nanoseconds=nanoseconds,
        frame_id=frame_id,
        style=style,
        time_increment=0.0 if frame.one_instant and not style.bins else None,
    )
